//! Refraction, total internal reflection, absorption, and shadows under glass.

use glam::{Vec3, Vec4};
use rayframe::film::PixelWindow;
use rayframe::integrator::{GlassShadows, Integrator};
use rayframe::scene::{Anisotropy, Environment, LightKind, Material, Projection, Transmission, Volume};

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

pub(super) fn glass(ior: f32, volume: Option<Volume>) -> Material {
    Material {
        base_color: Vec4::ONE,
        metallic: 0.0,
        roughness: 0.0,
        ior,
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        volume,
        ..Material::default()
    }
}

/// A floor that is black for x < 0 and emits for x > 0.
fn split_floor(stage: &mut Stage) {
    let half = |center_x: f32| rectangle(Vec3::new(center_x, 0.0, 0.0), Vec3::Z * 9.0, Vec3::X * 4.0);
    stage.add(half(-4.0), unlit(Vec3::ZERO));
    stage.add(half(4.0), unlit(Vec3::ONE));
}

#[test]
fn a_slab_shifts_a_slanted_ray_by_snells_law() {
    // A ray at 45° through a slab of thickness d = 1 and n = 1.5 leaves parallel to itself, moved along the slab by
    // d · (tan 45° − tan θt), sin θt = sin 45° / 1.5, that is 0.4655 for n = 1.5.
    let sin_t = libm::sqrtf(0.5) / 1.5;
    let shift = 1.0 - sin_t / libm::sqrtf(1.0 - sin_t * sin_t);
    assert!((shift - 0.465_5).abs() < 1e-4);
    let mut stage = Stage::new();
    split_floor(&mut stage);
    stage.add(cuboid(Vec3::Y * 2.0, Vec3::new(6.0, 0.5, 6.0)), glass(1.5, Some(Volume::CLEAR)));

    // Without the slab, this ray would reach the floor at `aim`; it travels towards −X, so the slab moves it to aim + shift.
    let reaches = |aim: f32| stage.look(Vec3::new(aim + 4.0, 4.0, 0.0), Vec3::new(aim, 0.0, 0.0)).x;
    let (dark, bright) = (reaches(-shift - 0.01), reaches(-shift + 0.01));
    assert!(dark < 0.1 && bright > 0.8, "{dark} {bright}");
}

#[test]
fn rough_glass_of_index_one_does_not_blur() {
    // Microfacets of index 1 neither refract nor reflect: the floor is as sharp and bright as without the glass.
    let brushed = Some(Anisotropy { strength: 0.7, rotation_radians: 0.3, texture: None });
    for (volume, anisotropy) in [(None, None), (Some(Volume::CLEAR), None), (None, brushed)] {
        let mut stage = Stage::new();
        split_floor(&mut stage);
        let rough = Material { roughness: 0.8, anisotropy, ..glass(1.0, volume) };
        stage.add(cuboid(Vec3::Y * 2.0, Vec3::new(6.0, 0.5, 6.0)), rough);
        for aim in [-0.01, 0.01] {
            let seen = stage.look(Vec3::new(aim, 4.0, 0.0), Vec3::new(aim, 0.0, 0.0));
            assert_close(seen, if aim < 0.0 { Vec3::ZERO } else { Vec3::ONE }, 1e-4);
        }
    }
}

#[test]
fn a_thin_wall_does_not_bend_light() {
    let mut stage = Stage::new();
    split_floor(&mut stage);
    let pane = rectangle(Vec3::Y * 2.0, Vec3::Z * 6.0, Vec3::X * 6.0);
    stage.add(pane, Material { base_color: Vec4::new(0.9, 0.5, 0.2, 1.0), ..glass(1.5, None) });
    let reaches = |aim: f32| stage.look(Vec3::new(aim, 4.0, 0.0), Vec3::new(aim, 0.0, 0.0));
    assert_close(reaches(-0.01), Vec3::ZERO, 1e-6);
    // Straight down: 1 − F = 0.96 of the base colour passes.
    assert_close(reaches(0.01), Vec3::new(0.9, 0.5, 0.2) * 0.96, 1e-5);
}

#[test]
fn absorption_follows_beer_and_lambert() {
    // n = 1 neither refracts nor reflects: with colour c at 0.5 m, c³ is left after 1.5 m.
    let color = Vec3::new(0.9, 0.5, 0.2);
    let volume = Volume { thickness: 1.0, attenuation_distance: 0.5, attenuation_color: color };
    let mut stage = Stage::new();
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.add(cuboid(Vec3::ZERO, Vec3::new(4.0, 0.75, 4.0)), glass(1.0, Some(volume)));
    let seen = stage.look(Vec3::Y * 3.0, Vec3::ZERO);
    assert_close(seen, color * color * color, 1e-5);
}

#[test]
fn a_camera_inside_a_volume_is_attenuated_over_the_remaining_distance() {
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5) };
    let mut stage = Stage::new();
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.add(cuboid(Vec3::ZERO, Vec3::splat(4.0)), glass(1.0, Some(volume)));
    // Three metres to the face: 1/8.
    assert_close(stage.look(Vec3::X, Vec3::X * 4.0), Vec3::splat(0.125), 1e-5);
}

#[test]
fn parallel_rays_that_start_beside_a_volume_are_outside() {
    // The camera is in the centre of a block of 2 m. Of three pixels 2 m apart, only the middle one starts inside.
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5) };
    let mut stage = Stage::new();
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.projection = Projection::Orthographic { x_mag: 3.0, y_mag: 1.0, z_near: 0.0, z_far: 100.0 };
    stage.settings.resolution = (3, 1);
    stage.add(cuboid(Vec3::ZERO, Vec3::ONE), glass(1.0, Some(volume)));
    for (column, expected) in [(0, 1.0), (1, 0.5), (2, 1.0)] {
        stage.settings.window = PixelWindow { x0: column, y0: 0, x1: column + 1, y1: 1 };
        assert_close(stage.look(Vec3::ZERO, Vec3::NEG_Z), Vec3::splat(expected), 1e-5);
    }
}

#[test]
fn rays_inside_glass_are_totally_reflected_beyond_the_critical_angle() {
    // The critical angle of n = 1.5 is 41.8°. The eye inside the block looks at its top. A ball of radiance 1 lies
    // at the mirrored point inside; outside there is nothing.
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::new(20.0, 2.0, 20.0)), glass(1.5, Some(Volume::CLEAR)));
    stage.add(cuboid(Vec3::new(3.0, 0.5, 0.0), Vec3::splat(0.3)), unlit(Vec3::ONE));
    // From (−3, 0.5) to the top (0, 2): 63° from the normal: all is reflected.
    assert_close(stage.look(Vec3::new(-3.0, 0.5, 0.0), Vec3::new(0.0, 2.0, 0.0)), Vec3::ONE, 1e-5);

    // At 21.8° inside (tan = 0.4), sin θt = 1.5 · sin 21.8°, and F is reflected.
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::new(20.0, 2.0, 20.0)), glass(1.5, Some(Volume::CLEAR)));
    stage.add(cuboid(Vec3::new(0.6, 0.5, 0.0), Vec3::splat(0.2)), unlit(Vec3::ONE));
    let cos_i = 1.5 / libm::sqrt(1.5 * 1.5 + 0.36);
    let sin_t = 1.5 * libm::sqrt(1.0 - cos_i * cos_i);
    let cos_t = libm::sqrt(1.0 - sin_t * sin_t);
    let s = (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t);
    let p = (cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t);
    let expected = f64::midpoint(s * s, p * p) as f32;
    let seen = stage.look(Vec3::new(-0.6, 0.5, 0.0), Vec3::new(0.0, 2.0, 0.0));
    assert_close(seen, Vec3::splat(expected), 1e-4);
}

#[test]
fn a_glass_block_in_a_white_furnace_disappears() {
    // Reflected and refracted shares sum to one at every interface. Only the depth limit and the weight cut-off lose light.
    let mut stage = Stage::new();
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.settings.max_depth = 30;
    stage.add(cuboid(Vec3::ZERO, Vec3::ONE), glass(1.5, Some(Volume::CLEAR)));
    let seen = stage.look(Vec3::new(3.0, 2.5, 2.0), Vec3::new(0.1, 0.2, 0.0));
    assert_close(seen, Vec3::ONE, 0.01);
}

#[test]
fn coincident_faces_of_equal_media_are_one_block() {
    // Two half blocks of the same glass that touch in the plane y = 0 absorb like one block: no Fresnel loss and no refraction in between.
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5) };
    let one = {
        let mut stage = Stage::new();
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.settings.max_depth = 2;
        stage.add(cuboid(Vec3::ZERO, Vec3::new(3.0, 1.0, 3.0)), glass(1.5, Some(volume)));
        stage.look(Vec3::new(0.4, 5.0, 0.3), Vec3::new(0.2, 0.0, 0.1))
    };
    let two = {
        let mut stage = Stage::new();
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.settings.max_depth = 3;
        for y in [-0.5, 0.5] {
            stage.add(cuboid(Vec3::Y * y, Vec3::new(3.0, 0.5, 3.0)), glass(1.5, Some(volume)));
        }
        stage.look(Vec3::new(0.4, 5.0, 0.3), Vec3::new(0.2, 0.0, 0.1))
    };
    // One more bounce adds one more internal reflection, 0.04 · 0.96² · 2⁻⁶ at most.
    assert_close(two, one.truncate(), 2e-3);
}

#[test]
fn glass_shadows_are_coloured_or_black() {
    // Light falls straight down through a box of 1 m: (0.96 · base)² · c, where c is reached at 1 m.
    let color = Vec3::new(0.9, 0.6, 0.3);
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: color };
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), lambert(Vec3::ONE));
    stage.add(cuboid(Vec3::Y * 2.0, Vec3::splat(0.5)), glass(1.5, Some(volume)));
    stage.add_light(LightKind::Directional, std::f32::consts::PI, Vec3::ZERO, Vec3::NEG_Y);
    let floor = |stage: &Stage| stage.look(Vec3::new(3.0, 1.0, 0.0), Vec3::ZERO);
    assert_close(floor(&stage), color * (0.96 * 0.96), 1e-4);
    stage.settings.glass_shadows = GlassShadows::Opaque;
    assert_close(floor(&stage), Vec3::ZERO, 0.0);
}

#[test]
fn volumes_absorb_the_light_of_lamps_inside_them() {
    // Camera and wall in water, and a lamp at four metres from the wall: light goes two metres to the camera. A bubble absorbs nothing, on the way of the
    // light or around the lamp.
    let color = Vec3::new(0.9, 0.3, 0.05);
    let water = Volume { thickness: 1.0, attenuation_distance: 4.0, attenuation_color: color };
    let see = |integrator, volume, bubble: Option<f32>| {
        let mut stage = super::path::stage(16);
        stage.settings.integrator = integrator;
        stage.add(cuboid(Vec3::ZERO, Vec3::splat(9.0)), glass(1.0, Some(volume)));
        stage.add(rectangle(Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 5.0), lambert(Vec3::ONE));
        if let Some(z) = bubble {
            stage.add(cuboid(Vec3::Z * z, Vec3::new(0.3, 0.3, 0.5)), glass(1.0, Some(Volume::CLEAR)));
        }
        stage.add_light(LightKind::Point, 10.0, Vec3::Z * 4.0, Vec3::NEG_Z);
        stage.look(Vec3::new(1.2, 0.0, 1.6), Vec3::ZERO).truncate()
    };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        for (bubble, in_water) in [(None, 4.0), (Some(3.0), 3.0), (Some(4.0), 3.5)] {
            let clear = see(integrator, Volume::CLEAR, bubble);
            let lit = see(integrator, water, bubble);
            let expected = clear * color.powf((in_water + 2.0) / 4.0);
            let off = (lit - expected).abs().max_element() / clear.x;
            assert!(off < 2e-3, "{integrator:?}, bubble at {bubble:?}: {lit} instead of {expected}");
        }
    }
}
