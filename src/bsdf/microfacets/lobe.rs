//! A GGX lobe as one view sees it.

use glam::{DVec2, DVec3, Vec2, Vec3};

/// Lowest cosine of a view; views along the surface are replaced by it.
const MIN_COSINE: f64 = 1e-12;

/// The microfacets of a GGX lobe that a view sees.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Microfacets {
    pub(super) wo: DVec3,
    /// α along X and Y, 1 along Z.
    pub(super) alpha: DVec3,
    /// Length of the view scaled by α.
    pub(super) length: f64,
    /// Direction of the view scaled by α.
    pub(super) view: DVec3,
}

impl Microfacets {
    /// An anisotropic lobe with `alpha` along X and Y, both above 0.
    pub(in crate::bsdf) fn anisotropic(wo: Vec3, alpha: Vec2) -> Self {
        Self::new(wo.as_dvec3(), alpha.as_dvec2())
    }

    /// An isotropic lobe; `alpha` is above 0.
    pub(in crate::bsdf) fn isotropic(cos_o: f32, alpha: f32) -> Self {
        let cosine = f64::from(cos_o);
        Self::new(DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine), DVec2::splat(f64::from(alpha)))
    }

    fn new(mut wo: DVec3, alpha: DVec2) -> Self {
        if wo.z < MIN_COSINE {
            wo.z = MIN_COSINE;
        }
        let alpha = alpha.extend(1.0);
        let length = (wo * alpha).length();
        Self { wo, alpha, length, view: wo * alpha / length }
    }
}
