//! Shadows of the environment on surfaces that face its dark side.

use glam::Vec3;
use rayframe::render::EnvSamples;
use rayframe::scene::{Environment, EnvironmentImage, EnvironmentMap};

use super::environment_shadows::{stage, window};
use super::path::{floor, middle, square_form_factor};
use crate::stage::{assert_close, lambert, rectangle};

#[test]
fn surfaces_that_face_away_from_all_light_get_what_lit_sides_reflect() {
    // The light comes from below, where the floor hides it from the card above.
    let mean = 10.0 * (1.0 - libm::cosf(15.0_f32.to_radians()));
    for half_width in [0.5, 2.0] {
        let seen = |card: Option<[Vec3; 2]>| {
            let mut stage = stage(4096);
            stage.environment = window(true).unwrap();
            stage.settings.env_samples = EnvSamples::Fixed(1);
            stage.settings.show_background = false;
            stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
            if let Some([u, v]) = card {
                stage.add(rectangle(Vec3::Y, u * half_width, v * half_width), lambert(Vec3::ONE));
            }
            middle(&stage)
        };
        assert_close(seen(None), Vec3::ZERO, 1e-6);
        // Towards the floor, the card faces the light.
        let hidden = square_form_factor(half_width, 1.0);
        assert_close(seen(Some([Vec3::X, Vec3::Z])), Vec3::splat(0.5 * mean / 3.0 * hidden), 0.003);
        // Its back reflects nothing.
        assert_close(seen(Some([Vec3::Z, Vec3::X])), Vec3::ZERO, 1e-6);
    }
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
