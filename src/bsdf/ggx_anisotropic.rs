//! Anisotropic GGX: its roughness differs between two directions of the surface.
//!
//! Sources: Burley, "Physically Based Shading at Disney", 2012, appendix B.2 (D); Heitz 2014, section 5.4, and Heitz 2018, as in
//! [`super::ggx`]; `KHR_materials_anisotropy`. Directions are local: X is the direction of the larger α, +Z the normal.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::ggx;

/// Visible normals that represent a lobe for each time that its larger α is its smaller one, so that narrow lobes around them overlap.
const NORMALS_PER_WIDTH: f32 = 8.0;
/// The least of them, and the most.
const NORMALS: [usize; 2] = [16, 256];
/// Revolutions from one normal to the next along their spiral: the golden section.
const REVOLUTIONS: f32 = 0.618_034;

/// An anisotropic GGX lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AnisotropicGgx {
    /// α along X and along Y.
    pub(super) alpha: Vec2,
}

/// A direction of a lobe with its share of uniform light.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectedDirection {
    pub(super) wi: Vec3,
    pub(super) facet_cosine: f32,
    /// Share of uniform light, without the Fresnel factor.
    pub(super) weight: f32,
}

impl AnisotropicGgx {
    /// A lobe with the material's α along Y, and mix(α, 1, strength²) along X.
    pub(super) fn new(alpha: f32, strength: f32) -> Self {
        let share = strength * strength;
        Self { alpha: Vec2::new(alpha * (1.0 - share) + share, alpha) }
    }

    /// The same with both α scaled, down to that of a mirror.
    pub(super) fn narrowed(self, scale: f32) -> Self {
        Self { alpha: (self.alpha * scale).max(Vec2::splat(ggx::MIN_ALPHA)) }
    }

    fn scaled_by_alpha(self, direction: Vec3) -> Vec3 {
        Vec3::new(self.alpha.x * direction.x, self.alpha.y * direction.y, direction.z)
    }

    /// D(h); see [`ggx::distribution`].
    pub(super) fn distribution(self, half: Vec3) -> f32 {
        let (x, y) = (half.x / self.alpha.x, half.y / self.alpha.y);
        let slope = x * x + y * y + half.z * half.z;
        1.0 / (std::f32::consts::PI * self.alpha.x * self.alpha.y * slope * slope)
    }

    /// G2 / (4 cos θ_o cos θ_i). Both directions are above the surface.
    pub(super) fn visibility(self, wo: Vec3, wi: Vec3) -> f32 {
        0.5 / (wi.z * length(self.scaled_by_alpha(wo)) + wo.z * length(self.scaled_by_alpha(wi)))
    }

    /// See [`ggx::masking_root`].
    pub(super) fn masking_root(self, direction: Vec3) -> f32 {
        length(self.scaled_by_alpha(direction))
    }

    /// See [`ggx::reflection_pdf`].
    pub(super) fn reflection_pdf(self, wo: Vec3, half: Vec3) -> f32 {
        0.5 * self.distribution(half) / (wo.z + length(self.scaled_by_alpha(wo)))
    }

    /// See [`ggx::visible_normal`].
    pub(super) fn visible_normal(self, wo: Vec3, disk: Vec2) -> Vec3 {
        let view = self.scaled_by_alpha(wo);
        // A surface of α = 1 for the scaled view; its normals are scaled back.
        let normal = ggx::visible_normal(view.normalize(), 1.0, disk);
        self.scaled_by_alpha(normal).normalize_or(Vec3::Z)
    }

    /// The lobe towards `wo` as lobes that are as narrow in all directions as it is across, around directions that spread along its width alone.
    pub(super) fn narrow_lobes(self, wo: Vec3) -> impl Iterator<Item = ReflectedDirection> + use<> {
        let Vec2 { x, y } = self.alpha;
        // The widths of lobes with tails as long as these add up where they are convolved.
        let spread = Self { alpha: Vec2::new(x - y, 0.0).max(Vec2::splat(ggx::MIN_ALPHA)) };
        spread.reflected(wo, spiral_of(NORMALS_PER_WIDTH * x / y))
    }

    /// The lobe towards `wo` as a number of directions.
    pub(super) fn reflected(
        self,
        wo: Vec3,
        normals: &'static [(Vec2, f32)],
    ) -> impl Iterator<Item = ReflectedDirection> + use<> {
        let root_o = length(self.scaled_by_alpha(wo));
        normals.iter().filter_map(move |(point, share)| {
            let half = self.visible_normal(wo, *point);
            let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
            let wi = half * (2.0 * facet_cosine) - wo;
            if wi.z <= 0.0 {
                return None;
            }
            // G2 / G1(θ_o)
            let root_i = length(self.scaled_by_alpha(wi));
            let weight = share * wi.z * (wo.z + root_o) / (wi.z * root_o + wo.z * root_i);
            Some(ReflectedDirection { wi, facet_cosine, weight })
        })
    }
}

fn length(vector: Vec3) -> f32 {
    libm::sqrtf(vector.dot(vector))
}

/// [`disk_spiral`] of the next power of two of points, within [`NORMALS`].
fn spiral_of(count: f32) -> &'static [(Vec2, f32)] {
    const SIZES: usize = (NORMALS[1] / NORMALS[0]).ilog2() as usize + 1;
    static SPIRALS: [OnceLock<Vec<(Vec2, f32)>>; SIZES] = [const { OnceLock::new() }; SIZES];
    let count = (count.ceil() as usize).clamp(NORMALS[0], NORMALS[1]).next_power_of_two();
    let size = (count / NORMALS[0]).ilog2() as usize;
    SPIRALS[size].get_or_init(|| disk_spiral(NORMALS[0] << size))
}

/// Points of the unit disk and their shares of it, on a spiral that is denser towards the edge, where the long tail of the lobe is.
pub(super) fn disk_spiral(count: usize) -> Vec<(Vec2, f32)> {
    let point = |index: usize| {
        // Area 1 − s² for uniform s.
        let position = index as f32 + 0.5;
        let s = position / count as f32;
        let revolutions = position * REVOLUTIONS;
        (ggx::disk_point(Vec2::new(1.0 - s * s, revolutions - revolutions.floor())), 2.0 * s / count as f32)
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of light from near one direction over directions with shares.
    fn mean(lobe: impl Iterator<Item = (Vec3, f32)>, light: impl Fn(Vec3) -> f32) -> f32 {
        let (seen, shares) =
            lobe.fold((0.0, 0.0), |sum, (wi, share)| (sum.0 + light(wi) * share, sum.1 + share));
        seen / shares
    }

    #[test]
    fn narrow_lobes_together_see_what_the_lobe_sees() {
        let fine: &'static [(Vec2, f32)] = disk_spiral(4096).leak();
        for (roughness, strength) in [(0.2, 0.5), (0.3, 0.3), (0.3, 0.7), (0.5, 0.5), (0.5, 1.0)] {
            let ggx = AnisotropicGgx::new(roughness * roughness, strength);
            let across = AnisotropicGgx { alpha: Vec2::splat(ggx.alpha.y) };
            for wo in [Vec3::Z, Vec3::new(0.3, 0.1, 1.0), Vec3::new(0.1, 0.5, 1.0)].map(Vec3::normalize) {
                let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
                for beside in [Vec3::ZERO, Vec3::X * 0.4, Vec3::Y * 0.4] {
                    let source = (mirrored + beside).normalize();
                    let light = |wi: Vec3| libm::expf(8.0 * (wi.dot(source) - 1.0));
                    let of = |lobe: ReflectedDirection| (lobe.wi, lobe.weight);
                    let expected = mean(ggx.reflected(wo, fine).map(of), light);
                    // What a prefiltered environment holds: the lobe of a view along the normal
                    let prefiltered = |wi: Vec3| {
                        let (x, y) = wi.any_orthonormal_pair();
                        let world_from_lobe = glam::Mat3::from_cols(x, y, wi);
                        mean(across.reflected(Vec3::Z, fine).map(of), |local| light(world_from_lobe * local))
                    };
                    let found = mean(ggx.narrow_lobes(wo).map(of), prefiltered);
                    let case = format!("{roughness} {strength} {wo} {beside}");
                    assert!((found - expected).abs() < 0.05, "{case}: {found} is not {expected}");
                }
            }
        }
    }

    #[test]
    fn wide_lobes_have_more_narrow_ones() {
        let counts = [0.0, 1.0, 2.01, 6.0, 20.0, 1e6].map(|width| spiral_of(NORMALS_PER_WIDTH * width).len());
        assert_eq!(counts, [16, 16, 32, 64, 256, 256]);
    }
}
