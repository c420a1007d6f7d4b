//! Reflection by GGX facets, sampled without most of the directions that point below the surface.
//!
//! Source: Eto, Tokuyoshi, "Bounded VNDF Sampling for Smith-GGX Reflections", SIGGRAPH Asia 2023, Technical Communications. The view is scaled so that the
//! facets become a hemisphere. There the directions that are reflected at visible normals are uniform in a spherical cap (Dupuy, Benyoub, "Sampling Visible GGX Normals with
//! Spherical Caps", HPG 2023). The cap ends where no lower direction is reflected above the surface. Directions are local, +Z along the normal.

use glam::{Vec2, Vec3};

use super::ggx;

/// Cosine to the end of the cap, below the horizon, over that of the scaled view: k of the source's equation 5. `least_alpha` is the smaller α.
#[inline(always)]
fn cap_end(cos_o: f32, least_alpha: f32) -> f32 {
    let alpha_squared = least_alpha * least_alpha;
    let along = 1.0 + ggx::positive(1.0 - cos_o * cos_o).sqrt();
    (1.0 - alpha_squared) * (along * along) / (along * along + alpha_squared * cos_o * cos_o)
}

/// Samples a direction that is reflected at a visible normal, by a uniform point of the unit disk; `None` below the surface. `alpha` is that along X and along Y.
pub(super) fn reflected(wo: Vec3, alpha: Vec2, disk: Vec2) -> Option<Vec3> {
    let scaled = |direction: Vec3| Vec3::new(alpha.x * direction.x, alpha.y * direction.y, direction.z);
    let view = scaled(wo).normalize();
    // The cap's heights are uniform, and so are squared radii of the disk.
    let cap_height = 1.0 + cap_end(wo.z, alpha.min_element()) * view.z;
    let height = 1.0 - cap_height * disk.length_squared();
    let stretch = ggx::positive(cap_height * (1.0 + height)).sqrt();
    let half = scaled(view + (disk * stretch).extend(height)).normalize_or(Vec3::Z);
    let wi = half * (2.0 * wo.dot(half)) - wo;
    (wi.z > 0.0).then(|| wi.normalize())
}

/// The density over solid angle of [`reflected`], by the distribution of normals at the half vector and the root of the masking towards the view.
#[inline(always)]
pub(super) fn pdf((distribution, masking_root): (f32, f32), cos_o: f32, least_alpha: f32) -> f32 {
    0.5 * distribution / (cap_end(cos_o, least_alpha) * cos_o + masking_root)
}

/// D V cos θ_i over the density: the weight of a direction of an isotropic lobe, without its Fresnel factor. `cos_i` is positive, `cos_o` may be 0.
pub(super) fn weight(cos_o: f32, cos_i: f32, alpha: f32) -> f32 {
    let root_o = ggx::masking_root(cos_o, alpha);
    let cap = cap_end(cos_o, alpha) * cos_o + root_o;
    cos_i * cap / (cos_i * root_o + cos_o * ggx::masking_root(cos_i, alpha))
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use glam::DVec3;

    use super::*;
    use crate::bsdf::specular_lobe::SpecularLobe;

    const SIDE: u32 = 512;

    /// The points of a grid in the unit square.
    fn grid() -> impl Iterator<Item = Vec2> {
        let at = |index: u32| (index as f32 + 0.5) / SIDE as f32;
        (0..SIDE * SIDE).map(move |index| Vec2::new(at(index % SIDE), at(index / SIDE)))
    }

    fn lobes() -> impl Iterator<Item = (SpecularLobe, Vec3)> {
        let lobes = [(0.3, None), (0.7, None), (1.0, None), (0.5, Some(0.8)), (0.8, Some(0.5))];
        let lobes = lobes.map(|(roughness, strength)| SpecularLobe::new(roughness, strength));
        let views =
            [(0.05, 0.3), (0.5, 2.0), (0.9, -1.0), (1.0, 0.0)].map(|(cosine, azimuth): (f32, f32)| {
                let sine = (1.0 - cosine * cosine).sqrt();
                Vec3::new(sine * libm::cosf(azimuth), sine * libm::sinf(azimuth), cosine)
            });
        lobes.into_iter().flat_map(move |lobe| views.map(|view| (lobe, view)))
    }

    #[test]
    fn sampled_directions_follow_their_density() {
        for (lobe, wo) in lobes() {
            let directions = grid().filter_map(|u| lobe.reflected(wo, ggx::disk_point(u)));
            let count = f64::from(SIDE * SIDE);
            let (mut above, mut sampled) = (0.0, DVec3::ZERO);
            for wi in directions {
                (above, sampled) = (above + 1.0 / count, sampled + wi.as_dvec3() / count);
            }
            // The same sums over the hemisphere, by the density.
            let (mut share, mut integral) = (0.0, DVec3::ZERO);
            for u in grid() {
                // Cells of half vectors of density D cos θ: slopes from 0 to ∞, scaled by α
                let slope = (u.x / (1.0 - u.x)).sqrt();
                let (sin_turn, cos_turn) = libm::sincosf(2.0 * PI * u.y);
                let alpha = lobe.anisotropic.map_or(Vec2::splat(lobe.alpha), |ggx| ggx.alpha);
                let half = Vec3::new(alpha.x * slope * cos_turn, alpha.y * slope * sin_turn, 1.0).normalize();
                let facet_cosine = wo.dot(half);
                let wi = half * (2.0 * facet_cosine) - wo;
                if facet_cosine > 0.0 && wi.z > 0.0 {
                    // That of the cell, times 4 o·h for mirrored directions
                    let distribution = lobe.anisotropic.map_or_else(
                        || ggx::distribution(half, lobe.alpha),
                        |anisotropic| anisotropic.distribution(half),
                    );
                    let solid_angle = 4.0 * facet_cosine / (distribution * half.z);
                    let weight = f64::from(lobe.reflected_pdf(wo, half) * solid_angle) / count;
                    (share, integral) = (share + weight, integral + wi.as_dvec3() * weight);
                }
            }
            assert!((share - above).abs() < 0.01, "{lobe:?} {wo}: {share} {above}");
            assert!((integral - sampled).abs().max_element() < 0.01, "{lobe:?} {wo}: {integral} {sampled}");
        }
    }

    #[test]
    fn albedos_are_those_of_visible_normals() {
        for (lobe, wo) in lobes() {
            let of_direction = |wi: Vec3, pdf: &dyn Fn(Vec3) -> f32| {
                let half = (wo + wi).normalize();
                f64::from(lobe.eval(wo, wi, half) * wi.z / pdf(half)) / f64::from(SIDE * SIDE)
            };
            let bounded = grid().filter_map(|u| lobe.reflected(wo, ggx::disk_point(u)));
            let bounded: f64 = bounded.map(|wi| of_direction(wi, &|half| lobe.reflected_pdf(wo, half))).sum();
            let visible = grid().filter_map(|u| {
                let half = lobe.visible_normal(wo, ggx::disk_point(u));
                let wi = half * (2.0 * wo.dot(half)) - wo;
                (wi.z > 0.0).then(|| of_direction(wi, &|half| lobe.reflection_pdf(wo, half)))
            });
            let visible: f64 = visible.sum();
            assert!((bounded - visible).abs() < 2e-3, "{lobe:?} {wo}: {bounded} {visible}");
        }
    }

    #[test]
    fn rough_lobes_seen_along_their_normal_lose_no_sample() {
        let lobe = SpecularLobe::new(1.0, None);
        let mut heaviest = 0.0_f32;
        for u in grid() {
            let wi = lobe.reflected(Vec3::Z, ggx::disk_point(u)).expect("above the surface");
            heaviest = heaviest.max(weight(1.0, wi.z, 1.0));
        }
        // Visible normals reflect half of their directions below, so that the others weigh up to 1. With α = 1 and the view along the normal, G2 is 2 cos / (1 + cos)
        // and a sample weighs half of that.
        assert!((heaviest - 0.5).abs() < 1e-3, "{heaviest}");
    }

    #[test]
    fn directions_are_unit_vectors_at_the_extremes() {
        for wo in [Vec3::Z, Vec3::X, Vec3::new(1.0, 0.0, 1e-30), Vec3::new(1e-30, 0.0, 1.0)] {
            for u in [Vec2::ZERO, Vec2::ONE, Vec2::new(1.0, 0.25), Vec2::new(0.5, 0.75)] {
                for alpha in [0.002, 1.0] {
                    if let Some(wi) = reflected(wo, Vec2::splat(alpha), ggx::disk_point(u)) {
                        assert!((wi.length() - 1.0).abs() < 1e-5 && wi.z > 0.0, "{wo} {u} {wi}");
                    }
                }
            }
        }
    }
}
