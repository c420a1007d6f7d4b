//! The built-in lights against quadrature of their radiance, and values that their tables state.

use std::f32::consts::PI;

use super::*;

fn directions() -> impl Iterator<Item = Vec3> {
    (0..40).map(|index| {
        let height = 1.0 - 2.0 * (index as f32 + 0.5) / 40.0;
        let (sin_azimuth, cos_azimuth) = libm::sincosf(index as f32 * 2.4);
        let sine = (1.0 - height * height).sqrt();
        Vec3::new(sine * cos_azimuth, height, sine * sin_azimuth)
    })
}

/// Reference implementation: midpoints of bands around `direction`, denser near it, for any kernel of the cosine.
fn integrate(
    radiance: impl Fn(Vec3) -> Vec3,
    direction: Vec3,
    kernel: impl Fn(f64) -> f64,
) -> (glam::DVec3, f64) {
    let (east, north) = direction.any_orthonormal_pair();
    let (mut sum, mut total) = (glam::DVec3::ZERO, 0.0);
    for ring in 0..240 {
        // cos θ = 1 − 2 s², dω = 4 s ds dφ.
        let s = (f64::from(ring) + 0.5) / 240.0;
        let cosine = 1.0 - 2.0 * s * s;
        let sine = (1.0 - cosine * cosine).sqrt() as f32;
        let weight = kernel(cosine) * 4.0 * s / 240.0 * 2.0 * std::f64::consts::PI / 120.0;
        if weight <= 0.0 {
            continue;
        }
        for azimuth in 0..120 {
            let (sin_azimuth, cos_azimuth) = libm::sincosf(azimuth as f32 / 120.0 * 2.0 * PI);
            let across = east * (sine * cos_azimuth) + north * (sine * sin_azimuth);
            sum += radiance(direction * cosine as f32 + across).as_dvec3() * weight;
            total += weight;
        }
    }
    (sum, total)
}

fn brightest(light: BuiltInLight) -> f32 {
    let areas = light.design().areas.iter().map(|area| area.radiance.max_element());
    areas.fold(0.0, |a: f32, b| if a > b { a } else { b })
}

#[test]
fn areas_have_their_radiance_at_their_centres_and_the_backdrop_is_between_them() {
    // Directions as stated in docs/shading.md: the key box, the front, the left rim, and behind.
    let studio = |azimuth, elevation| BuiltInLight::Studio.radiance(direction(azimuth, elevation));
    assert_eq!(studio(-46.0, 44.0), Vec3::new(3.6, 3.5, 3.32));
    assert!((studio(10.0, 0.0) - Vec3::splat(0.06)).length() < 1e-6);
    assert_eq!(studio(-135.0, 20.0), Vec3::splat(4.0));
    let behind = direction(180.0, 0.0);
    assert_eq!(BuiltInLight::Studio.radiance(behind), Vec3::new(0.26, 0.265, 0.27));
    assert_eq!(BuiltInLight::Studio.backdrop(behind), Vec3::new(0.26, 0.265, 0.27));
    // Halfway between centre and edge to both sides, and beyond both edges.
    let rim = |azimuth| studio(azimuth, 20.0);
    assert!((rim(-140.0) - rim(-130.0)).length() < 1e-5 && (rim(-140.0).x - 4.0).abs() < 1e-5);
    assert!(rim(-150.0).x < 1.0 && rim(-120.0).x < 1.0);
}

#[test]
fn directions_are_those_of_orbits() {
    for ((azimuth, elevation), expected) in
        [((0.0, 0.0), Vec3::Z), ((90.0, 0.0), Vec3::X), ((0.0, 90.0), Vec3::Y), ((180.0, 0.0), Vec3::NEG_Z)]
    {
        assert!((direction(azimuth, elevation) - expected).length() < 1e-6);
    }
}

#[test]
fn radiance_is_positive_and_smooth() {
    for light in BuiltInLight::ALL {
        let mut last = light.radiance(Vec3::Z);
        for step in 0..=3600 {
            let found = light.radiance(direction(step as f32 * 0.1, 25.0));
            assert!(found.min_element() > 0.0, "{light:?} {step}: {found}");
            // The smoothest edge rises by 1.5 / width; a tenth of a degree moves by 1/50 of an edge of 6°.
            assert!((found - last).abs().max_element() < 0.05 * brightest(light), "{light:?} {step}");
            last = found;
        }
    }
}

#[test]
fn the_energy_of_a_rectangle_is_its_solid_angle_for_any_width_of_lookups() {
    let design = designs::area(30.0, 20.0, [40.0, 60.0], 4.0, [1.0; 3]);
    let area = Area::new(&design);
    // Ω = 4 arctan(a b / √(1 + a² + b²)) for half-widths a and b at a distance of one.
    let [a, b] = [libm::tan(20_f64.to_radians()), libm::tan(30_f64.to_radians())];
    let solid_angle = 4.0 * libm::atan(a * b / (1.0 + a * a + b * b).sqrt());
    for (width, tolerance) in [(0.0, 0.01), (0.1, 0.01), (0.3, 0.02)] {
        let seen = |direction| match width {
            0.0 => area.over(Vec3::ZERO, direction),
            _ => area.mean_over_square(Vec3::ZERO, direction, width),
        };
        let (sum, _) = integrate(seen, direction(25.0, 25.0), |_| 1.0);
        assert!((sum.x / solid_angle - 1.0).abs() < tolerance, "{width}: {} for {solid_angle}", sum.x);
    }
}

#[test]
fn wide_lookups_agree_with_many_point_lookups() {
    for light in BuiltInLight::ALL {
        for towards in directions() {
            let (u, v) = towards.any_orthonormal_pair();
            for (a, b) in [(u * 0.1, v * 0.1), (u * 0.2 + v * 0.05, v * 0.02)] {
                let mut mean = Vec3::ZERO;
                for index in 0..400 {
                    let offset = |index: i32| (index as f32 + 0.5) / 20.0 - 0.5;
                    let point = towards + a * offset(index % 20) + b * offset(index / 20);
                    mean += light.radiance(point.normalize()) / 400.0;
                }
                let found = light.radiance_over(towards, [a, b]);
                let error = (found - mean).abs().max_element() / brightest(light);
                assert!(error < 0.03, "{light:?} {towards}: {found} for {mean}");
            }
        }
    }
}

#[test]
fn infinite_and_undefined_differentials_are_harmless() {
    for light in BuiltInLight::ALL {
        for towards in directions() {
            for size in [f32::INFINITY, f32::NAN, 1e30, 0.0] {
                let found = light.radiance_over(towards, [Vec3::splat(size), Vec3::Y]);
                assert!(found.is_finite() && found.max_element() <= brightest(light), "{light:?} {found}");
            }
            assert_eq!(light.radiance_over(towards, [Vec3::ZERO; 2]), light.radiance(towards));
        }
    }
}

#[test]
fn irradiance_agrees_with_quadrature() {
    for light in BuiltInLight::ALL {
        let most = light.irradiance(Vec3::Y).max_element() + light.irradiance(Vec3::Z).max_element();
        for normal in directions() {
            let lobe = |cosine: f64| if cosine > 0.0 { cosine } else { 0.0 };
            let expected = integrate(|towards| light.radiance(towards), normal, lobe).0.as_vec3();
            let found = light.irradiance(normal);
            let error = (found - expected).abs().max_element() / most;
            assert!(error < 0.015, "{light:?} {normal}: {found} for {expected}");
        }
    }
}

#[test]
fn prefiltered_agrees_with_quadrature() {
    for light in BuiltInLight::ALL {
        for (roughness, tolerance) in [(0.25_f32, 0.05), (0.5, 0.02), (0.75, 0.015), (1.0, 0.015)] {
            let a2 = f64::from(roughness).powi(4);
            for towards in directions() {
                let (sum, total) = integrate(
                    |towards| light.radiance(towards),
                    towards,
                    |cosine| {
                        let slope = f64::midpoint(1.0, cosine) * (a2 - 1.0) + 1.0;
                        match cosine {
                            _ if cosine <= 0.0 => 0.0,
                            _ if roughness == 1.0 => roughest_weight(cosine),
                            _ => a2 / (slope * slope) * cosine,
                        }
                    },
                );
                let (found, expected) = (light.prefiltered(towards, roughness), (sum / total).as_vec3());
                let error = (found - expected).abs().max_element() / brightest(light);
                assert!(error < tolerance, "{light:?} {roughness} {towards}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn a_smooth_lobe_gives_the_radiance() {
    for light in BuiltInLight::ALL {
        for towards in directions() {
            assert_eq!(light.prefiltered(towards, 0.0), light.radiance(towards));
            let error = (light.prefiltered(towards, 1e-4) - light.radiance(towards)).abs().max_element();
            assert!(error < 0.001 * brightest(light));
        }
    }
}

#[test]
fn lights_are_told_apart() {
    let [studio, softbox, outdoor, dark] = BuiltInLight::ALL;
    let [above, front] = [Vec3::Y, Vec3::Z];
    // Even light differs little between directions; rims leave the front dark.
    let evenness = |light: BuiltInLight| light.irradiance(front).y / light.irradiance(above).y;
    assert!(evenness(softbox) > 0.5);
    assert!(dark.irradiance(front).y < 0.5 * studio.irradiance(front).y);
    assert!(dark.irradiance(direction(180.0, 0.0)).y > dark.irradiance(front).y);
    // The sky is blue, the ground warm.
    assert!(outdoor.backdrop(above).z > outdoor.backdrop(above).x);
    assert!(outdoor.backdrop(Vec3::NEG_Y).x > outdoor.backdrop(Vec3::NEG_Y).z);
}
