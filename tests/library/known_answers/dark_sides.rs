//! Shadows of the environment on surfaces that face its dark side.

use glam::Vec3;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{Environment, EnvironmentImage, EnvironmentMap};

use super::environment_shadows::{stage, window};
use super::path::{floor, middle};
use crate::stage::{assert_close, lambert, rectangle};

#[test]
fn surfaces_that_face_away_from_all_light_get_what_lit_sides_reflect() {
    // The light comes from below. It passes a small floor on its way to the wide card above.
    let seen = |floor_half_width: f32, card: Option<[Vec3; 2]>, integrator: Integrator| {
        let mut stage = stage(4096);
        stage.environment = window(true).unwrap();
        stage.settings.integrator = integrator;
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.settings.show_background = false;
        stage.add(floor(floor_half_width), lambert(Vec3::splat(0.5)));
        if let Some([u, v]) = card {
            stage.add(rectangle(Vec3::Y, u * 2.0, v * 2.0), lambert(Vec3::ONE));
        }
        middle(&stage)
    };
    let whitted = |half_width, card| seen(half_width, card, Integrator::Whitted);
    let (towards, away) = ([Vec3::X, Vec3::Z], [Vec3::Z, Vec3::X]);
    assert_close(whitted(0.3, None), Vec3::ZERO, 1e-6);
    // Towards the floor, the card faces the light.
    let (lit, path) = (whitted(0.3, Some(towards)).x, seen(0.3, Some(towards), Integrator::Path).x);
    assert!(path > 0.02 && (lit / path - 1.0).abs() < 0.1, "{lit} of {path}");
    // A wide floor hides nearly all of the light from it, and its back reflects nothing.
    let (lit, path) = (whitted(5.0, Some(towards)).x, seen(5.0, Some(towards), Integrator::Path).x);
    assert!(path < 2e-4 && (lit - path).abs() < 1e-4, "{lit} of {path}");
    assert_close(whitted(0.3, Some(away)), Vec3::ZERO, 1e-6);
}

#[test]
fn what_hides_the_dark_side_of_an_environment_does_not_light_it() {
    // Red light comes from below, blue light from above, green light from everywhere.
    let (width, height) = (256, 128);
    let pixel = |index: u32| if index / width < height / 2 { [0.1, 1.0, 1.0] } else { [1.0, 1.0, 0.1] };
    let pixels = (0..width * height).map(pixel).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    let sides = Environment::Map(EnvironmentMap::new("sides.hdr".as_ref(), image, 0.0).unwrap());
    let seen = |has_wall: bool| {
        let mut stage = stage(1024);
        stage.environment = sides.clone();
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.add(floor(500.0), lambert(Vec3::splat(0.5)));
        if has_wall {
            // From its back it has the estimate alone.
            let wall = rectangle(Vec3::new(0.0, 200.0, -0.5), Vec3::Y * 200.0, Vec3::X * 500.0);
            stage.add(wall, lambert(Vec3::ONE));
        }
        middle(&stage).truncate()
    };
    let (open, hidden) = (seen(false), seen(true));
    // The wall hides half of the sky and reflects a third of the mean radiance: 0.55 of red and blue light, 1 of green light.
    assert!((hidden.x / open.x - 1.0).abs() < 0.01, "{hidden} {open}");
    assert!((hidden.y / open.y - (0.5 + 0.5 / 3.0)).abs() < 0.01, "{hidden} {open}");
    assert!((hidden.z / open.z - (0.5 + 0.5 * 0.55 / 3.0)).abs() < 0.01, "{hidden} {open}");
}
