//! Directions and irradiances against integrals of the same light.

use super::*;
use fearless_simd::Level;

use crate::geometry::{Aabb, ActiveLanes, LANES};
use crate::integrator::occluders::OccluderBox;
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
            let luminance = directions.grid.luminance(wi);
            expected += wi * luminance;
            light += luminance;
        }
        expected /= light;
        let count = 4000;
        let mean: Vec3 = points(count)
            .map(|(u, choice)| directions.grid.diffuse(normal, u, choice).unwrap())
            .sum::<Vec3>()
            / count as f32;
        assert!((mean - expected).length() < 0.03, "{normal}: {mean} for {expected}");
    }
}

#[test]
fn both_ways_find_the_same_share_of_light_in_a_range() {
    let occluders = OccluderBox::new(Aabb { min: -Vec3::ONE, max: Vec3::ONE });
    let ranges = [
        (Vec3::new(3.0, -1.0, 0.5), Vec3::Y),
        (Vec3::new(-2.0, 0.0, 4.0), Vec3::new(0.48, 0.6, -0.64)),
        (Vec3::new(0.2, -4.0, 0.0), Vec3::new(0.6, 0.8, 0.0)),
    ]
    .map(|(point, normal)| occluders.range_from(point, normal).unwrap());
    let count = 4000;
    // The share of all light, and its mean direction
    let mean = |light: &RangeLight<'_>| {
        let (mut all, mut direction) = (0.0, Vec3::ZERO);
        for (u, _) in points(count) {
            let (wi, share) = light.sample(u);
            assert!(share <= light.max_share(), "{share} {}", light.max_share());
            all += share;
            direction += wi * share;
        }
        (all / count as f32, direction / all)
    };
    for light in [BuiltInLight::Studio, BuiltInLight::Dark, BuiltInLight::Outdoor] {
        let directions = EnvironmentDirections::new(&Environment::BuiltIn(light));
        for range in ranges {
            let irradiance = directions.grid.irradiance(range.normal());
            let by_cosine = directions.in_range(range, irradiance);
            assert!(matches!(by_cosine, RangeLight::ByCosine { .. }));
            let directions = directions.clone().with_receivers(range.normal());
            let by_light = directions.in_range(range, irradiance);
            assert!(matches!(by_light, RangeLight::ByLight(..)));
            let [(expected, direction), (share, by_light)] = [by_cosine, by_light].map(|light| mean(&light));
            assert!((share / expected - 1.0).abs() < 0.03, "{light:?}: {share} for {expected}");
            assert!(by_light.distance(direction) < 0.02, "{light:?}: {by_light} for {direction}");
        }
    }
}

#[test]
fn the_irradiance_is_that_of_the_cosine_lobe() {
    for environment in [Environment::Constant(Vec3::ONE), Environment::BuiltIn(BuiltInLight::Studio)] {
        let directions = EnvironmentDirections::new(&environment);
        for normal in [Vec3::Y, Vec3::X, Vec3::new(0.0, -0.6, 0.8), Vec3::new(0.48, 0.6, -0.64)] {
            let frame = local_frame(normal);
            let count = 20_000;
            let radiances = points(count).map(|(u, _)| {
                let (sine, cosine) = libm::sincosf(u.y * TAU);
                let radius = u.x.sqrt();
                let wi = frame * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).sqrt());
                f64::from(directions.grid.luminance(wi))
            });
            let expected = radiances.sum::<f64>() * std::f64::consts::PI / f64::from(count);
            let found = f64::from(directions.grid.irradiance(normal));
            // Interpolation between normals costs most where the studio's floor darkens.
            assert!((found / expected - 1.0).abs() < 0.03, "{normal}: {found} for {expected}");
        }
    }
}

#[test]
fn light_may_be_as_bright_and_as_dim_as_numbers() {
    let even = EnvironmentDirections::new(&Environment::Constant(Vec3::ONE));
    for radiance in [1e30, 1e-30] {
        let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::splat(radiance)));
        for (u, choice) in points(200) {
            let [found, expected] = [&directions, &even].map(|d| d.grid.diffuse(Vec3::Y, u, choice).unwrap());
            assert!(found.distance(expected) < 1e-3, "{radiance}: {found} for {expected}");
        }
        let irradiance = directions.grid.irradiance(Vec3::Y) / radiance;
        // Cells that the horizon cuts count by the mean of their directions, which takes 0.2 % away.
        assert!((irradiance / std::f32::consts::PI - 1.0).abs() < 3e-3, "{radiance}: {irradiance}");
    }
}

#[test]
fn directions_are_unit_vectors_of_their_hemisphere_and_lobe() {
    let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ONE));
    let axis = Vec3::new(0.48, 0.6, -0.64);
    for (u, choice) in points(500) {
        let wi = directions.grid.diffuse(axis, u, choice).unwrap();
        assert!((wi.length() - 1.0).abs() < 1e-5 && wi.dot(axis) >= 0.0);
        assert!((directions.glossy(axis, 0.0, (u, choice)) - axis).length() < 1e-6);
        for roughness in [0.5, 0.8, 1.0] {
            let wide = directions.glossy(axis, roughness, (u, choice));
            assert!((wide.length() - 1.0).abs() < 1e-4 && wide.dot(axis) > -1e-5, "{wide}");
        }
    }
}

/// [`EnvironmentDirections::glossy`], one direction after the other.
fn chosen_one_by_one(
    directions: &EnvironmentDirections,
    (mirrored, roughness): (Vec3, f32),
    u: Vec2,
    u_choice: f32,
) -> Vec3 {
    let alpha = roughness * roughness;
    let lobe_direction = |u: Vec2| {
        let u_x = u.x / (1.0 + alpha * alpha);
        let tangent_squared = alpha * alpha * u_x / (1.0 - u_x);
        let cosine = 1.0 / (1.0 + tangent_squared).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin_azimuth, cos_azimuth) = libm::sincosf(u.y * TAU);
        let half = local_frame(mirrored) * Vec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine);
        half * (2.0 * cosine) - mirrored
    };
    let mut candidates = [(mirrored, 0.0); CANDIDATES];
    let mut sum = 0.0;
    for (stratum, candidate) in candidates.iter_mut().enumerate() {
        let azimuth = u.y + stratum as f32 * GOLDEN_SHARE;
        let u = Vec2::new((stratum as f32 + u.x) / CANDIDATES as f32, azimuth - azimuth.floor());
        let direction = lobe_direction(u);
        sum += directions.grid.luminance(direction);
        *candidate = (direction, sum);
    }
    let chosen = candidates.iter().find(|(_, sum_to)| u_choice * sum < *sum_to);
    chosen.unwrap_or(&candidates[((u_choice * 4.0) as usize).min(3)]).0
}

#[test]
fn glossy_directions_in_lanes_have_the_bits_of_single_ones() {
    let directions = EnvironmentDirections::new(&Environment::BuiltIn(BuiltInLight::Studio));
    for (number, (u, choice)) in points(4000).enumerate() {
        let mirrored = crate::geometry::spiral_direction(number as u32, 4000);
        let roughness = (number % 101) as f32 / 100.0;
        let expected = chosen_one_by_one(&directions, (mirrored, roughness), u, choice);
        let found = directions.glossy(mirrored, roughness, (u, choice));
        assert_eq!(found.to_array().map(f32::to_bits), expected.to_array().map(f32::to_bits));
    }
}

#[test]
fn no_direction_leads_to_darkness() {
    let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ZERO));
    assert_eq!(directions.grid.diffuse(Vec3::Y, Vec2::splat(0.5), 0.5), None);
}

#[test]
fn glossy_directions_in_lanes_are_those_of_single_lobes() {
    for environment in [Environment::BuiltIn(BuiltInLight::Studio), Environment::Constant(Vec3::ZERO)] {
        let directions = EnvironmentDirections::new(&environment);
        let sampled: Vec<_> = points(32 * LANES as u32).collect();
        for (block, sampled) in sampled.chunks(LANES).enumerate() {
            let (mut axes, mut us) = (Vec3Lanes::default(), Vec2Lanes::default());
            let (mut roughness, mut randoms) = (F32Lanes::default(), F32Lanes::default());
            for (lane, (u, random)) in sampled.iter().enumerate() {
                axes.set(lane, LuminanceImage::direction_from_uv(Vec2::new(u.y, *random)));
                us.set(lane, *u);
                randoms[lane] = *random;
                roughness[lane] = (lane + block) as f32 / (LANES + 32) as f32;
            }
            let lanes = ActiveLanes::first(LANES).filtered(|lane| lane != block % LANES);
            for level in [Level::fallback(), Level::new()] {
                let mut found = Vec3Lanes::default();
                let lobes = LookupLanes { level, directions: &axes, lanes };
                directions.glossy_lanes(&lobes, &roughness, (&us, &randoms), &mut found);
                for lane in lanes {
                    let sampled = (us.get(lane), randoms[lane]);
                    let expected = directions.glossy(axes.get(lane), roughness[lane], sampled);
                    assert_eq!(found.get(lane), expected, "{block} {lane}");
                }
                assert_eq!(found.get(block % LANES), Vec3::ZERO);
            }
        }
    }
}
