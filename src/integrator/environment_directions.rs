//! Directions of shadow rays towards the environment, for surfaces that look its light up.
//!
//! Whitted's tree multiplies a looked-up light by an estimate of the share that arrives: a ratio of shadowed to unshadowed samples
//! (Heitz, Hill and McGuire, "Combining Analytic Direct Illumination and Stochastic Shadows", I3D 2018). Directions follow the
//! light that the lookup averages, so that the ratio is the mean visibility of the samples.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::whitted::local_frame;
use crate::scene::{Environment, LuminanceImage};

/// Directions among which one is chosen.
const CANDIDATES: u32 = 8;

/// Cosine and sine of the golden angle, by which candidates are turned from one to the next.
const GOLDEN_TURN: Vec2 = Vec2::new(-0.737_368_9, 0.675_490_3);

/// Directions by the luminance of an environment.
#[derive(Debug)]
pub(super) struct EnvironmentDirections {
    luminance: LuminanceImage,
}

impl EnvironmentDirections {
    /// Directions of an environment that is lit.
    pub(super) fn new(environment: &Environment) -> Self {
        Self { luminance: LuminanceImage::new(environment) }
    }

    /// A direction from which light reaches a diffuse surface; `None` where none does. The density is nearly that of the light times the cosine:
    /// of several cosine-distributed candidates, one is chosen by its luminance (Talbot, Cline and Egbert, "Importance Resampling
    /// for Global Illumination", 2005).
    pub(super) fn diffuse(&self, normal: Vec3, u: Vec2, u_choice: f32) -> Option<Vec3> {
        let world_from_local = local_frame(normal);
        let (sine, cosine) = libm::sincosf(u.y * TAU);
        let mut turn = Vec2::new(cosine, sine);
        let mut candidates = [(Vec3::ZERO, 0.0); CANDIDATES as usize];
        let mut sum = 0.0;
        for (stratum, candidate) in candidates.iter_mut().enumerate() {
            let radius_squared = (stratum as f32 + u.x) / CANDIDATES as f32;
            let across = turn * radius_squared.sqrt();
            let direction = world_from_local * across.extend((1.0 - radius_squared).sqrt());
            sum += self.luminance.at(direction);
            *candidate = (direction, sum);
            turn = GOLDEN_TURN.rotate(turn);
        }
        let chosen = candidates.iter().find(|(_, sum_to)| u_choice * sum < *sum_to);
        chosen.map(|(direction, _)| *direction)
    }
}

/// A direction of the lobe that prefiltered lookups average: GGX of `roughness` around the mirror direction, for a view along the normal, as far
/// as it is within 90° of that direction.
pub(super) fn glossy(mirrored: Vec3, roughness: f32, u: Vec2) -> Vec3 {
    let alpha = roughness * roughness;
    let u_x = u.x / (1.0 + alpha * alpha);
    let tangent_squared = alpha * alpha * u_x / (1.0 - u_x);
    let cosine = 1.0 / (1.0 + tangent_squared).sqrt();
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin_azimuth, cos_azimuth) = libm::sincosf(u.y * TAU);
    let half = local_frame(mirrored) * Vec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine);
    half * (2.0 * cosine) - mirrored
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::BuiltInLight;

    fn points(count: u32) -> impl Iterator<Item = (Vec2, f32)> {
        let fraction = |x: f32| x - x.floor();
        (0..count).map(move |i| {
            let i = i as f32 + 0.5;
            (Vec2::new(fraction(i * 0.754_877_7), fraction(i * 0.569_840_3)), fraction(i * 0.618_034))
        })
    }

    #[test]
    fn the_mean_of_the_directions_is_that_of_the_light() {
        // A sky that is bright on one side: E[wi] = ∫ L wi cos / ∫ L cos, by a fine grid.
        let environment = Environment::BuiltIn(BuiltInLight::Studio);
        let directions = EnvironmentDirections::new(&environment);
        for normal in [Vec3::Y, Vec3::X, Vec3::new(0.0, -0.6, 0.8)] {
            let (mut expected, mut light) = (Vec3::ZERO, 0.0);
            let frame = local_frame(normal);
            for (u, _) in points(20_000) {
                let (sine, cosine) = libm::sincosf(u.y * TAU);
                let radius = u.x.sqrt();
                let wi = frame * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).sqrt());
                let luminance = directions.luminance.at(wi);
                expected += wi * luminance;
                light += luminance;
            }
            expected /= light;
            let count = 4000;
            let mean: Vec3 =
                points(count).map(|(u, choice)| directions.diffuse(normal, u, choice).unwrap()).sum::<Vec3>()
                    / count as f32;
            // The candidates of one choice are few, so that bright directions are chosen a little too rarely.
            assert!((mean - expected).length() < 0.07, "{normal}: {mean} for {expected}");
        }
    }

    #[test]
    fn directions_are_unit_vectors_of_their_hemisphere_and_lobe() {
        let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ONE));
        let axis = Vec3::new(0.48, 0.6, -0.64);
        for (u, choice) in points(500) {
            let wi = directions.diffuse(axis, u, choice).unwrap();
            assert!((wi.length() - 1.0).abs() < 1e-5 && wi.dot(axis) >= 0.0);
            assert!((glossy(axis, 0.0, u) - axis).length() < 1e-6);
            for roughness in [0.5, 0.8, 1.0] {
                let wide = glossy(axis, roughness, u);
                assert!((wide.length() - 1.0).abs() < 1e-4 && wide.dot(axis) > -1e-5, "{wide}");
            }
        }
    }

    #[test]
    fn no_direction_leads_to_darkness() {
        let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ZERO));
        assert_eq!(directions.diffuse(Vec3::Y, Vec2::splat(0.5), 0.5), None);
    }
}
