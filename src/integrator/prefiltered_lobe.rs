//! The prefiltered lobe that stands for the light that a rough surface reflects or transmits.

use glam::Vec3;

/// Coefficients of the fit of [`PrefilteredLobe::new`]: of the axis, and of the roughness.
const TILT: f32 = 0.76;
const TILT_BY_COSINE: f32 = 2.9;
const WIDER_BEYOND: f32 = 0.5;
const WIDER: f32 = 0.6;

/// A lobe around a direction, as [`crate::scene::Environment::prefiltered`] averages it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrefilteredLobe {
    pub(super) direction: Vec3,
    pub(super) roughness: f32,
}

impl PrefilteredLobe {
    /// The lobe of a surface of `roughness`, from 0 to 1, to a viewer at `cos_o` from the normal.
    ///
    /// Prefiltered lobes are those of a view along the normal. Seen obliquely, a rough lobe leans from the mirror direction towards the normal, around
    /// which it is at roughness 1 (Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering", 2014, section 4.9.3). This fit has the least
    /// mean square of what is looked up less what the lobe reflects, in light whose correlation falls by e over 0.5 radians.
    #[inline(always)]
    pub(super) fn new(mirrored: Vec3, normal: Vec3, cos_o: f32, roughness: f32) -> Self {
        let share = roughness * roughness * (1.0 + (1.0 - roughness) * (TILT - TILT_BY_COSINE * cos_o));
        let axis = mirrored + (normal - mirrored) * share.clamp(0.0, 1.0);
        let wider = roughness * (1.0 + WIDER * (roughness - WIDER_BEYOND).max(0.0));
        Self { direction: axis * (1.0 / axis.dot(axis).sqrt()), roughness: wider.min(1.0) }
    }
}
