//! What is looked up of an environment in the stead of the light that a rough surface reflects or transmits.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::interaction::MaterialSample;

/// Coefficients of the fit of [`PrefilteredLobe::new`]: of the axis, and of the roughness.
const TILT: f32 = 0.76;
const TILT_BY_COSINE: f32 = 2.9;
const WIDER_BEYOND: f32 = 0.5;
const WIDER: f32 = 0.6;

/// Least square of a lobe's width, so that narrow lobes stay finite.
const MIN_ALPHA_SQUARED: f32 = 1e-6;

/// By how much the narrow lobe of [`RoughLobe::new`] is sharper where it is seen along the surface.
const NARROWER: f32 = 0.25;
/// By how much its axis leans to the normal there.
const TILT_OBLIQUELY: f32 = 1.1;
/// Share of its broad part below which a lobe has none: that of roughness 1/4.
const FAINTEST: f32 = 1.0 / 64.0;

/// A lobe around a direction, as [`crate::scene::Environment::prefiltered`] averages it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrefilteredLobe {
    pub(super) direction: Vec3,
    pub(super) roughness: f32,
}

/// A rough lobe as the sum of a prefiltered one and of the one of roughness 1 around the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoughLobe {
    pub(super) narrow: PrefilteredLobe,
    /// Share of the lobe of roughness 1.
    pub(super) broad_share: f32,
}

impl RoughLobe {
    /// The lobe of a surface of `roughness`, from 0 to 1, to a viewer at `cos_o` from the normal.
    ///
    /// Rough lobes have a core near the mirror direction, narrower than that of a view along the normal, above a broad part. This fit has less than half the mean
    /// square error of [`PrefilteredLobe::new`] in light whose correlation falls by e over 0.15, 0.5 and 1.5 radians. The irradiance may stand for the broad part,
    /// with somewhat more.
    #[inline(always)]
    pub(super) fn new(mirrored: Vec3, normal: Vec3, cos_o: f32, roughness: f32) -> Self {
        let obliquely = 1.0 - cos_o;
        let axis = mirrored
            + (normal - mirrored) * (TILT_OBLIQUELY * roughness * roughness * obliquely).clamp(0.0, 1.0);
        let narrow = PrefilteredLobe {
            direction: axis * (1.0 / axis.dot(axis).sqrt()),
            roughness: roughness * (1.0 - NARROWER * obliquely),
        };
        Self { narrow, broad_share: Self::broad_share(roughness) }
    }

    /// The lobe that a surface of this material reflects. That of dielectrics without a diffuse part, such as glass, is too faint for another lookup.
    #[inline(always)]
    pub(super) fn of(material: &MaterialSample, (mirrored, normal): (Vec3, Vec3), cos_o: f32) -> Self {
        let roughness = material.roughness.clamp(0.0, 1.0);
        if has_broad_part(material) {
            Self::new(mirrored, normal, cos_o, roughness)
        } else {
            Self { narrow: PrefilteredLobe::new(mirrored, normal, cos_o, roughness), broad_share: 0.0 }
        }
    }

    /// See [`RoughLobe::broad_share`]: the cube of the roughness, less what would be too faint to look up.
    #[inline(always)]
    pub(super) fn broad_share(roughness: f32) -> f32 {
        ((roughness * roughness * roughness - FAINTEST) / (1.0 - FAINTEST)).max(0.0)
    }
}

/// Whether the irradiance of a surface of this material is looked up anyway, or its specular lobe is a metal's.
#[inline(always)]
pub(super) fn has_broad_part(material: &MaterialSample) -> bool {
    material.metallic > 0.0 || material.transmission < 1.0 || material.sheen.is_some()
}

impl PrefilteredLobe {
    /// The lobe that stands alone for that of a surface of `roughness`, from 0 to 1, to a viewer at `cos_o` from the normal.
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

    /// The density of the lobe in a direction by solid angle: GGX for a view along the axis times the cosine, within 3 %.
    pub(super) fn density(&self, direction: Vec3) -> f32 {
        let roughness = self.roughness;
        let alpha = roughness * roughness;
        let alpha_squared = (alpha * alpha).max(MIN_ALPHA_SQUARED);
        let cosine = self.direction.dot(direction);
        // The square of the half vector's cosine with both directions
        let denominator = 1.0 - (1.0 + cosine) * 0.5 * (1.0 - alpha_squared);
        let distribution = alpha_squared * FRAC_1_PI / (denominator * denominator);
        // Its integral is 4 where the lobe is narrow, and 1 where all normals are equally likely; the fit between is ours.
        let integral = 4.0 / (1.0 + alpha * roughness * (2.1 + 0.9 * roughness));
        distribution * cosine.max(0.0) / integral
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;
    use crate::geometry::spiral_direction;

    const DIRECTIONS: u32 = 700;

    fn directions() -> Vec<Vec3> {
        (0..DIRECTIONS).map(|index| spiral_direction(index, DIRECTIONS)).collect()
    }

    /// The weights of directions, with a sum of 1.
    fn normalized(weight: impl Fn(Vec3) -> f32) -> Vec<f32> {
        let weights: Vec<f32> = directions().into_iter().map(weight).collect();
        let sum: f32 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    }

    fn distribution(half: Vec3, alpha: f32) -> f32 {
        let slope = half.z * half.z * (alpha * alpha - 1.0) + 1.0;
        alpha * alpha / (PI * slope * slope)
    }

    /// The GGX lobe of a surface with the normal +Z (Walter et al. 2007; Heitz 2014, equation 99).
    fn reflected(wo: Vec3, alpha: f32) -> Vec<f32> {
        let root = |cosine: f32| (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt();
        normalized(|wi| {
            let shadowing = wi.z * root(wo.z) + wo.z * root(wi.z);
            if wi.z > 0.0 { distribution((wo + wi).normalize(), alpha) * wi.z / shadowing } else { 0.0 }
        })
    }

    /// The lobe that [`crate::scene::Environment::prefiltered`] averages.
    fn prefiltered(lobe: PrefilteredLobe) -> Vec<f32> {
        normalized(|wi| {
            let cosine = lobe.direction.dot(wi);
            match lobe.roughness {
                _ if cosine <= 0.0 => 0.0,
                1.0 => cosine / (cosine + 0.6),
                _ => lobe.density(wi),
            }
        })
    }

    /// The mean square of what two lobes see of lights that are alike over angles of 0.15, 0.5 and 1.5.
    fn square_error(a: &[f32], b: &[f32]) -> f64 {
        let directions = directions();
        let differences: Vec<f32> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let alike = |i: usize, j: usize| {
            let angle = libm::acosf(directions[i].dot(directions[j]).clamp(-1.0, 1.0));
            libm::expf(-angle / 0.15) + 2.0 * libm::expf(-angle / 0.5) + 2.0 * libm::expf(-angle / 1.5)
        };
        let count = differences.len();
        (0..count)
            .flat_map(|i| (0..count).map(move |j| (i, j)))
            .map(|(i, j)| f64::from(differences[i] * differences[j] * alike(i, j)))
            .sum()
    }

    #[test]
    fn two_lookups_have_less_than_half_the_error_of_one() {
        let (mut of_one, mut of_two) = (0.0, 0.0);
        for roughness in [0.35, 0.5, 0.65, 0.8, 1.0] {
            for cos_o in [0.94, 0.64, 0.34_f32] {
                let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
                let mirrored = Vec3::new(-wo.x, 0.0, wo.z);
                let lobe = reflected(wo, roughness * roughness);
                let one = PrefilteredLobe::new(mirrored, Vec3::Z, cos_o, roughness);
                of_one += square_error(&lobe, &prefiltered(one));
                let RoughLobe { narrow, broad_share } = RoughLobe::new(mirrored, Vec3::Z, cos_o, roughness);
                let broad = prefiltered(PrefilteredLobe { direction: Vec3::Z, roughness: 1.0 });
                let two: Vec<f32> = prefiltered(narrow)
                    .iter()
                    .zip(&broad)
                    .map(|(narrow, broad)| narrow * (1.0 - broad_share) + broad * broad_share)
                    .collect();
                of_two += square_error(&lobe, &two);
            }
        }
        assert!(of_two < 0.5 * of_one, "{of_two} of {of_one}");
    }

    #[test]
    fn densities_integrate_to_one() {
        for roughness in [0.3, 0.5, 0.7, 0.9, 1.0] {
            let lobe = PrefilteredLobe { direction: Vec3::Y, roughness };
            let count = 20_000;
            let sum: f32 = (0..count).map(|index| lobe.density(spiral_direction(index, count))).sum();
            let integral = sum * 4.0 * PI / count as f32;
            assert!((integral - 1.0).abs() < 0.03, "{roughness}: {integral}");
        }
    }
}
