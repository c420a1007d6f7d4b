//! The GGX distribution of microfacet normals, its masking, and the sampling of visible normals.
//!
//! Sources: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, equation 33 (D); Heitz,
//! "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", 2014, equation 99 (height-correlated G2); Heitz,
//! "Sampling the GGX Distribution of Visible Normals", 2018. Isotropic only. Directions are local, +Z along the normal.

use glam::{Vec2, Vec3};

use crate::geometry::sin_cos_of_turn;

/// Lowest α. Sharper lobes look like mirrors and exceed the precision of floats.
pub(super) const MIN_ALPHA: f32 = 0.002;

/// D(h), the density of normals over solid angle times cosine: ∫ D(h) cos θ_h dω = 1. `half` is a unit vector.
#[inline(always)]
pub(super) fn distribution(half: Vec3, alpha: f32) -> f32 {
    let alpha_squared = alpha * alpha;
    // cos² (α² − 1) + 1 in a form without cancellation for sharp lobes
    let slope = alpha_squared * half.z * half.z + half.x * half.x + half.y * half.y;
    alpha_squared / (std::f32::consts::PI * slope * slope)
}

/// √(α² + (1 − α²) cos²), the common part of masking and shadowing.
#[inline(always)]
pub(super) fn masking_root(cosine: f32, alpha: f32) -> f32 {
    let alpha_squared = alpha * alpha;
    (alpha_squared + (1.0 - alpha_squared) * cosine * cosine).sqrt()
}

/// G2 / (4 cos θ_o cos θ_i). Both cosines are positive.
#[inline(always)]
pub(super) fn visibility(cos_o: f32, cos_i: f32, alpha: f32) -> f32 {
    0.5 / (cos_i * masking_root(cos_o, alpha) + cos_o * masking_root(cos_i, alpha))
}

/// The density over solid angle of reflected directions whose half vectors are sampled by [`visible_normal`].
#[inline(always)]
pub(super) fn reflection_pdf(cos_o: f32, half: Vec3, alpha: f32) -> f32 {
    // G1 D (o·h) / cos θ_o, times the mirror's 1 / (4 o·h).
    0.5 * distribution(half, alpha) / (cos_o + masking_root(cos_o, alpha))
}

/// Maps the unit square to the unit disk.
pub(super) fn disk_point(u: Vec2) -> Vec2 {
    let radius = u.x.sqrt();
    let (sine, cosine) = sin_cos_of_turn(2.0 * std::f32::consts::PI * u.y);
    Vec2::new(radius * cosine, radius * sine)
}

/// Samples a microfacet normal that `wo` sees, by a uniform point of the unit disk (Heitz 2018, listing 1).
pub(super) fn visible_normal(wo: Vec3, alpha: f32, disk: Vec2) -> Vec3 {
    // Scale the view so that the surface becomes a hemisphere
    let view = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let horizontal_squared = view.x * view.x + view.y * view.y;
    let across = if horizontal_squared > 0.0 {
        Vec3::new(-view.y, view.x, 0.0) / horizontal_squared.sqrt()
    } else {
        Vec3::X
    };
    let upward = view.cross(across);
    // Compress the disk to the projected hemisphere
    let share = 0.5 * (1.0 + view.z);
    let y = (1.0 - share) * positive(1.0 - disk.x * disk.x).sqrt() + share * disk.y;
    let z = positive(1.0 - disk.x * disk.x - y * y).sqrt();
    let normal = across * disk.x + upward * y + view * z;
    // Scale back to the surface
    Vec3::new(alpha * normal.x, alpha * normal.y, positive(normal.z)).normalize_or(Vec3::Z)
}

pub(super) fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projected_normals_cover_the_surface_once() {
        // ∫ D cos dω with cos² = c, dω cos = π dc around the pole: ∫₀¹ D π dc = 1; sharp lobes live near c = 1.
        for alpha in [0.05_f32, 0.3, 1.0] {
            let steps = 200_000;
            let sum: f64 = (0..steps)
                .map(|step| {
                    let c = (step as f32 + 0.5) / steps as f32;
                    let half = Vec3::new((1.0 - c).sqrt(), 0.0, c.sqrt());
                    f64::from(distribution(half, alpha)) * std::f64::consts::PI / f64::from(steps)
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-3, "{alpha}: {sum}");
        }
    }

    #[test]
    fn masking_has_the_known_limits() {
        // A flat surface hides nothing: G2 = 1, so V = 1 / (4 cos cos).
        assert!((visibility(0.5, 0.25, 0.0) - 1.0 / (4.0 * 0.125)).abs() < 1e-5);
        // Along the normal G1 = 1 for any roughness, so V(1, 1) = 1/4.
        assert!((visibility(1.0, 1.0, 0.7) - 0.25).abs() < 1e-6);
        assert_eq!(visibility(0.3, 0.8, 0.4), visibility(0.8, 0.3, 0.4));
        // α = 1, cos = 0.5: Λ = (√(1 + tan²) − 1) / 2 = 1/2 each, G2 = 1 / (1 + 1/2 + 1/2) = 1/2, V = 0.5 / (4 · 0.25).
        assert!((visibility(0.5, 0.5, 1.0) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn sampled_normals_follow_the_visible_density() {
        // The mean of any function over sampled normals equals its integral against G1 D (o·h)⁺ / cos θ_o; here h.x and h.z.
        let (wo, alpha) = (Vec3::new(0.8, 0.0, 0.6), 0.6);
        let mut sampled = glam::DVec3::ZERO;
        let count = 300;
        for i in 0..count {
            for j in 0..count {
                let u = Vec2::new((i as f32 + 0.5) / count as f32, (j as f32 + 0.5) / count as f32);
                sampled += visible_normal(wo, alpha, disk_point(u)).as_dvec3() / f64::from(count * count);
            }
        }
        let mut integral = glam::DVec3::ZERO;
        let mut total = 0.0;
        for ring in 0..400 {
            for turn in 0..400 {
                let cosine = (ring as f32 + 0.5) / 400.0;
                let (sin_turn, cos_turn) =
                    libm::sincosf((turn as f32 + 0.5) / 400.0 * 2.0 * std::f32::consts::PI);
                let sine = (1.0 - cosine * cosine).sqrt();
                let half = Vec3::new(sine * cos_turn, sine * sin_turn, cosine);
                let seen = positive(wo.dot(half)) * 4.0;
                let weight = f64::from(reflection_pdf(wo.z, half, alpha) * seen) * 2.0 * std::f64::consts::PI
                    / 160_000.0;
                integral += half.as_dvec3() * weight;
                total += weight;
            }
        }
        assert!((total - 1.0).abs() < 2e-3, "{total}");
        assert!((sampled - integral).abs().max_element() < 3e-3, "{sampled} {integral}");
    }

    #[test]
    fn normals_are_unit_vectors_at_the_extremes() {
        for wo in [Vec3::Z, Vec3::X, Vec3::new(1.0, 0.0, 1e-30), Vec3::new(1e-30, 0.0, 1.0)] {
            for u in [Vec2::ZERO, Vec2::ONE, Vec2::new(1.0, 0.25), Vec2::new(0.5, 0.75)] {
                let normal = visible_normal(wo, 0.002, disk_point(u));
                assert!((normal.length() - 1.0).abs() < 1e-5 && normal.z >= 0.0, "{wo} {u} {normal}");
            }
        }
    }
}
