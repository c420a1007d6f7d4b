//! Studio environment: neutral procedural light for scenes without a light of their own.
//!
//! The radiance is a sum of parts, each rotationally symmetric about an axis: a backdrop that brightens from the floor to the
//! ceiling, a warm softbox overhead to the left, and a cool fill light from the right. Cosine and GGX lobes are symmetric about
//! their axes as well, so the integrals of a part depend on one angle only. Small tables hold them, computed once by a fixed
//! quadrature. The automatic camera looks along −Z, so left is −X and front is +Z.

use std::f32::consts::PI;
use std::sync::OnceLock;

use glam::Vec3;

use super::key_light::KeyLight;

/// Table steps of the cosine between axis and direction, from −1 to 1.
const COSINE_STEPS: usize = 128;

/// Table steps of roughness from 0 to 1.
const ROUGHNESS_STEPS: usize = 8;

/// One symmetric part: radiance is `color` times a function of the cosine to `axis`.
struct Part {
    axis: Vec3,
    color: Vec3,
    profile: fn(f32) -> f32,
}

/// Exposure that the studio is made for, in stops.
pub(super) const EXPOSURE_EV: f32 = 0.0;

/// The parts of the studio. The backdrop goes from 0.12 at the floor over 0.29 at the horizon to 0.5 at the ceiling.
const PARTS: [Part; 3] = [
    Part {
        axis: Vec3::Y,
        color: Vec3::new(0.97, 1.0, 1.03),
        profile: |height| {
            0.12 + 0.26 * smooth_step(-0.35, 0.25, height) + 0.12 * smooth_step(0.0, 1.0, height)
        },
    },
    // The softbox: 2.4 within 20° of its axis, nothing beyond 38°. The axis is (−0.3, 0.9, 0.3) / |·|.
    Part {
        axis: Vec3::new(-0.301_511_35, 0.904_534, 0.301_511_35),
        color: Vec3::new(2.4, 2.3, 2.2),
        profile: |cosine| smooth_step(0.788_010_8, 0.939_692_6, cosine),
    },
    // The fill: 0.55 on its axis, nothing beyond 50°. The axis is (0.85, 0.3, 0.45) / |·|.
    Part {
        axis: Vec3::new(0.843_695_8, 0.297_775, 0.446_662_5),
        color: Vec3::new(0.5, 0.53, 0.55),
        profile: |cosine| smooth_step(0.642_787_6, 1.0, cosine),
    },
];

/// Warm key light from the left, above and in front of the subject. Its direction is (−0.45, 0.75, 0.6) / |·|.
pub(super) fn key_light() -> KeyLight {
    KeyLight {
        direction_to_light: Vec3::new(-0.424_264_07, 0.707_106_77, 0.565_685_45),
        irradiance: Vec3::new(3.0, 2.88, 2.7),
    }
}

pub(super) fn radiance(direction: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for part in &PARTS {
        sum += part.color * (part.profile)(part.axis.dot(direction));
    }
    sum
}

pub(super) fn irradiance(normal: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (part, table) in PARTS.iter().zip(tables()) {
        sum += part.color * interpolate(&table.irradiance, part.axis.dot(normal));
    }
    sum
}

pub(super) fn prefiltered(direction: Vec3, roughness: f32) -> Vec3 {
    let step = roughness.clamp(0.0, 1.0) * ROUGHNESS_STEPS as f32;
    let below = (step as usize).min(ROUGHNESS_STEPS - 1);
    let share = step - below as f32;
    let mut sum = Vec3::ZERO;
    for (part, table) in PARTS.iter().zip(tables()) {
        let cosine = part.axis.dot(direction);
        let sharper = match below {
            0 => (part.profile)(cosine),
            _ => interpolate(&table.prefiltered[below - 1], cosine),
        };
        let rougher = interpolate(&table.prefiltered[below], cosine);
        sum += part.color * (sharper * (1.0 - share) + rougher * share);
    }
    sum
}

type Row = [f32; COSINE_STEPS + 1];

/// Integrals of one part's profile, indexed by the cosine between its axis and the lobe's.
struct PartTables {
    irradiance: Row,
    /// Roughness 1/8, 2/8, … 1.
    prefiltered: [Row; ROUGHNESS_STEPS],
}

fn tables() -> &'static [PartTables; 3] {
    static TABLES: OnceLock<[PartTables; 3]> = OnceLock::new();
    TABLES.get_or_init(|| {
        PARTS.map(|part| PartTables {
            irradiance: lobe_row(part.profile, &cosine_lobe(), PI),
            prefiltered: std::array::from_fn(|index| {
                let roughness = (index + 1) as f32 / ROUGHNESS_STEPS as f32;
                lobe_row(part.profile, &ggx_lobe(roughness * roughness), 1.0)
            }),
        })
    })
}

fn interpolate(row: &Row, cosine: f32) -> f32 {
    let step = (cosine.clamp(-1.0, 1.0) + 1.0) * (COSINE_STEPS as f32 * 0.5);
    let below = (step as usize).min(COSINE_STEPS - 1);
    let share = step - below as f32;
    row[below] * (1.0 - share) + row[below + 1] * share
}

/// Rings of a lobe around its axis, as pairs of the cosine to the axis and the weight.
type Lobe = [(f32, f32); 64];

/// Cosine lobe: midpoints of equal shares of ∫ cos θ dω.
fn cosine_lobe() -> Lobe {
    std::array::from_fn(|index| ((1.0 - (index as f32 + 0.5) / 64.0).sqrt(), 1.0))
}

/// GGX lobe: midpoints of equal shares of D cos θ_h, reflected at the half vector with the view along the axis, weighted by
/// cosine.
fn ggx_lobe(alpha: f32) -> Lobe {
    std::array::from_fn(|index| {
        let share = (index as f32 + 0.5) / 64.0;
        let tan_squared = alpha * alpha * share / (1.0 - share);
        let cosine = (1.0 - tan_squared) / (1.0 + tan_squared);
        (cosine, if cosine > 0.0 { cosine } else { 0.0 })
    })
}

/// The lobe's mean of the profile times `scale`, for all cosines between the two axes.
fn lobe_row(profile: fn(f32) -> f32, lobe: &Lobe, scale: f32) -> Row {
    const AZIMUTHS: usize = 24;
    let azimuth_cosines: [f32; AZIMUTHS] =
        std::array::from_fn(|index| libm::cosf((index as f32 + 0.5) / AZIMUTHS as f32 * PI));
    let total: f32 = lobe.iter().map(|(_, weight)| weight).sum();
    std::array::from_fn(|index| {
        let cosine = index as f32 * (2.0 / COSINE_STEPS as f32) - 1.0;
        let sine = positive(1.0 - cosine * cosine).sqrt();
        let mut sum = 0.0;
        for (ring_cosine, weight) in lobe {
            let across = sine * positive(1.0 - ring_cosine * ring_cosine).sqrt();
            let ring: f32 =
                azimuth_cosines.iter().map(|azimuth| profile(cosine * ring_cosine + across * azimuth)).sum();
            sum += ring * weight;
        }
        sum * scale / (total * AZIMUTHS as f32)
    })
}

fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

/// Hermite smoothstep from 0 at `low` to 1 at `high`.
fn smooth_step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference implementation: the whole sphere on a fine grid around `direction`, for any kernel of the cosine.
    fn integrate(direction: Vec3, kernel: impl Fn(f64) -> f64) -> (Vec3, f64) {
        let (east, north) = direction.any_orthonormal_pair();
        let (mut sum, mut total) = (glam::DVec3::ZERO, 0.0);
        for ring in 0..600 {
            // Denser near the axis: cos θ = 1 − s², dω = 2 s ds dφ.
            let s = (f64::from(ring) + 0.5) / 600.0;
            let cosine = 1.0 - s * s;
            let sine = (1.0 - cosine * cosine).sqrt() as f32;
            let weight = kernel(cosine) * 2.0 * s / 600.0 * 2.0 * std::f64::consts::PI / 60.0;
            for azimuth in 0..60 {
                let (sin_azimuth, cos_azimuth) = libm::sincosf(azimuth as f32 / 60.0 * 2.0 * PI);
                let towards =
                    direction * cosine as f32 + east * (sine * cos_azimuth) + north * (sine * sin_azimuth);
                sum += radiance(towards).as_dvec3() * weight;
                total += weight;
            }
        }
        (sum.as_vec3(), total)
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..60).map(|index| {
            let height = 1.0 - 2.0 * (index as f32 + 0.5) / 60.0;
            let (sin_azimuth, cos_azimuth) = libm::sincosf(index as f32 * 2.4);
            let sine = (1.0 - height * height).sqrt();
            Vec3::new(sine * cos_azimuth, height, sine * sin_azimuth)
        })
    }

    #[test]
    fn axes_are_unit_vectors_and_colors_positive() {
        for part in &PARTS {
            assert!((part.axis.length() - 1.0).abs() < 1e-6);
        }
        for direction in directions() {
            assert!(radiance(direction).min_element() > 0.1);
        }
    }

    #[test]
    fn irradiance_agrees_with_quadrature() {
        for normal in directions() {
            let (expected, _) = integrate(normal, |cosine| cosine);
            let found = irradiance(normal);
            assert!((found - expected).abs().max_element() < 0.005, "{normal}: {found} for {expected}");
        }
    }

    #[test]
    fn prefiltered_agrees_with_quadrature() {
        for roughness in [0.25_f32, 0.5, 0.75, 1.0] {
            let a2 = f64::from(roughness).powi(4);
            for direction in directions() {
                let (sum, total) = integrate(direction, |cosine| {
                    let slope = f64::midpoint(1.0, cosine) * (a2 - 1.0) + 1.0;
                    a2 / (slope * slope) * cosine
                });
                let (found, expected) = (prefiltered(direction, roughness), sum / total as f32);
                let error = (found - expected).abs().max_element();
                assert!(error < 0.015, "{roughness} {direction}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn a_smooth_lobe_gives_the_radiance() {
        for direction in directions() {
            assert_eq!(prefiltered(direction, 0.0), radiance(direction));
            assert!((prefiltered(direction, 1e-4) - radiance(direction)).abs().max_element() < 0.01);
        }
    }

    #[test]
    fn the_ceiling_is_brighter_than_the_floor() {
        assert!(radiance(Vec3::Y).y > 4.0 * radiance(Vec3::NEG_Y).y);
        assert!(irradiance(Vec3::Y).y > 2.0 * irradiance(Vec3::NEG_Y).y);
    }
}
