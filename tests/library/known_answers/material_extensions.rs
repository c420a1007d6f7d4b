//! Clearcoat, diffuse transmission, anisotropy and dispersion.

use glam::Vec3;
use rayframe::render::Integrator;
use rayframe::scene::{
    Anisotropy, ClearCoat, DiffuseTransmission, Environment, LightKind, Material, Sheen, Transmission, Volume,
};

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

/// Unpolarised Fresnel reflectance of index n, with Snell refraction.
fn fresnel(cos_i: f64, n: f64) -> f32 {
    let cos_t = libm::sqrt(1.0 - (1.0 - cos_i * cos_i) / (n * n));
    let s = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    let p = (n * cos_i - cos_t) / (n * cos_i + cos_t);
    f64::midpoint(s * s, p * p) as f32
}

fn floor(material: Material) -> Stage {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0), material);
    stage
}

fn coated(factor: f32, base: Material) -> Material {
    let coat =
        ClearCoat { factor, texture: None, roughness: 0.0, roughness_texture: None, normal_texture: None };
    Material { clear_coat: Some(coat), ..base }
}

#[test]
fn a_smooth_coat_mirrors_objects_over_a_rough_base() {
    // Seen at 45°: the coat reflects factor · F of the panel and dims the emission of the base by 1 − factor · F.
    let glow = Vec3::new(0.0, 0.0, 0.5);
    let base = Material { emissive: glow, ..lambert(Vec3::ZERO) };
    for factor in [1.0, 0.5] {
        let mut stage = floor(coated(factor, base.clone()));
        let panel = rectangle(Vec3::new(-2.0, 2.0, 0.0), Vec3::new(0.1, 0.1, 0.0), Vec3::Z * 0.1);
        stage.add(panel, unlit(Vec3::new(0.8, 0.4, 0.0)));
        let share = factor * fresnel(0.5_f64.sqrt(), 1.5);
        let expected = Vec3::new(0.8, 0.4, 0.0) * share + glow * (1.0 - share);
        assert_close(stage.look(Vec3::new(2.0, 2.0, 0.0), Vec3::ZERO), expected, 1e-5);
    }
}

#[test]
fn a_coat_dims_lights_on_the_base_by_the_view_direction_alone() {
    // A light at 60°, seen head-on: base / π · cos 60° · (1 − 0.04); the coat's own highlight is elsewhere.
    let mut stage = floor(coated(1.0, lambert(Vec3::splat(0.5))));
    let direction = Vec3::new(-(0.75_f32.sqrt()), -0.5, 0.0);
    stage.add_light(LightKind::Directional, 2.0, Vec3::ZERO, direction);
    let expected = 0.5 / std::f32::consts::PI * 2.0 * 0.5 * 0.96;
    assert_close(stage.look(Vec3::Y, Vec3::ZERO), Vec3::splat(expected), 1e-5);
}

#[test]
fn material_extensions_never_gain_energy_in_a_white_furnace() {
    let sheen = Sheen { color: Vec3::ONE, color_texture: None, roughness: 0.5, roughness_texture: None };
    let through = DiffuseTransmission { factor: 0.4, texture: None, color: Vec3::ONE, color_texture: None };
    let white = Material { metallic: 0.0, ..Material::default() };
    for (roughness, material) in [
        (0.0, coated(1.0, white.clone())),
        (0.6, coated(0.7, white.clone())),
        (1.0, Material { sheen: Some(sheen), ..white.clone() }),
        (0.3, Material { diffuse_transmission: Some(through), ..white.clone() }),
        (0.5, coated(1.0, Material { sheen: Some(sheen), diffuse_transmission: Some(through), ..white })),
    ] {
        let mut stage = floor(Material { roughness, ..material });
        stage.environment = Environment::Constant(Vec3::ONE);
        for cos in [1.0, 0.6, 0.2] {
            let eye = Vec3::new(libm::sqrtf(1.0 - cos * cos), cos, 0.0);
            // Smooth coats lose nothing: dielectrics transmit to the base what they do not reflect.
            assert_close(stage.look(eye, Vec3::ZERO), Vec3::ONE, 1e-3);
        }
    }
}

#[test]
fn light_from_behind_shows_through_paper() {
    // Lambert of colour c and factor f under E lux from behind: f · c · E cos θ / π; from the front (1 − f) · base · E cos θ / π.
    let color = Vec3::new(0.2, 0.6, 1.0);
    let through = DiffuseTransmission { factor: 0.75, texture: None, color, color_texture: None };
    let paper =
        Material { diffuse_transmission: Some(through), double_sided: true, ..lambert(Vec3::splat(0.8)) };
    let mut behind = floor(paper.clone());
    behind.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::Y);
    let unit = 3.0 / std::f32::consts::PI;
    assert_close(behind.look(Vec3::Y, Vec3::ZERO), color * (0.75 * unit), 1e-5);
    let mut front = floor(paper);
    front.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::NEG_Y);
    assert_close(front.look(Vec3::Y, Vec3::ZERO), Vec3::splat(0.8 * 0.25 * unit), 1e-5);
    // An occluder in between removes it.
    behind.add(rectangle(Vec3::NEG_Y, Vec3::X, Vec3::Z), lambert(Vec3::ONE));
    assert_close(behind.look(Vec3::Y, Vec3::ZERO), Vec3::ZERO, 1e-6);
}

#[test]
fn an_anisotropic_mirror_of_uniform_light_is_uniform() {
    let anisotropy = Some(Anisotropy { strength: 0.5, rotation_radians: 0.0, texture: None });
    let metal = Material { roughness: 0.05, anisotropy, ..Material::default() };
    let mut stage = Stage::new();
    let mut primitive = rectangle(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0);
    primitive.uvs =
        vec![[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| glam::Vec2::new(u, v)).to_vec()];
    stage.add(primitive, metal);
    stage.environment = Environment::Constant(Vec3::ONE);
    let seen = stage.look(Vec3::new(0.5, 1.0, 0.2), Vec3::ZERO).truncate();
    assert!(seen.max_element() <= 1.001 && seen.min_element() > 0.999, "{seen}");
}

/// A slab of glass, 1 m thick, whose index is 1.5 ± 0.5 · 0.025 · dispersion.
fn dispersive_slab(dispersion: f32) -> Stage {
    let glass = Material {
        metallic: 0.0,
        roughness: 0.0,
        ior: 1.5,
        dispersion,
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        volume: Some(Volume::CLEAR),
        ..Material::default()
    };
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::new(20.0, 0.5, 20.0)), glass);
    stage
}

#[test]
fn colours_leave_a_dispersive_slab_at_separate_points() {
    // At 45° a ray is moved by d · (1 − tan θ_t) along the surface, with sin θ_t = sin 45° / n. The green one leaves at −0.5 + …
    let dispersion = 8.0;
    let exit = |n: f32| {
        let sin = 0.5_f32.sqrt() / n;
        -0.5 + 1.0 - sin / libm::sqrtf(1.0 - sin * sin)
    };
    let half = 0.5 * 0.025 * dispersion;
    let [red, green, blue] = [1.5 - half, 1.5, 1.5 + half].map(exit);
    assert!(blue > green && green > red && blue - red > 0.05);
    // Beyond the slab only a narrow strip emits, where one colour arrives: x = exit − 0.5 on the plane y = −1.
    for (place, channel) in [(red, 0), (green, 1), (blue, 2)] {
        let mut stage = dispersive_slab(dispersion);
        let strip = rectangle(Vec3::new(place - 0.5, -1.0, 0.0), Vec3::X * 0.005, Vec3::Z);
        stage.add(strip, unlit(Vec3::ONE));
        // Enters at (0.5, 0.5) going down and to −X.
        let seen = stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.5, 0.5, 0.0)).truncate();
        for other in 0..3 {
            if other == channel {
                let n = [1.5 - half, 1.5, 1.5 + half][other];
                let left = 1.0 - fresnel(0.5_f64.sqrt(), f64::from(n));
                assert!((seen[other] - left * left).abs() < 1e-4, "{channel}: {seen}");
            } else {
                assert!(seen[other] < 1e-4, "{channel}: {seen}");
            }
        }
    }
}

#[test]
fn dispersion_in_uniform_light_is_neutral() {
    let mut stage = dispersive_slab(4.0);
    stage.environment = Environment::Constant(Vec3::ONE);
    // All bounces up to the depth limit: nothing is absorbed.
    stage.settings.max_depth = 24;
    assert_close(stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.5, 0.5, 0.0)), Vec3::ONE, 2e-3);
}

#[test]
fn a_clamp_above_all_light_leaves_dispersive_glass_as_it_is() {
    // A path of one channel stands for three, with three times the light.
    let mut stage = dispersive_slab(4.0);
    stage.environment = Environment::Constant(Vec3::ONE);
    (stage.settings.integrator, stage.settings.samples) = (Integrator::Path, 256);
    let seen = |stage: &Stage| stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.5, 0.5, 0.0));
    let free = seen(&stage);
    stage.settings.path.clamp_indirect = 1.01;
    assert_eq!(seen(&stage), free);
    stage.settings.path.clamp_indirect = 0.5;
    assert!(seen(&stage).y < 0.7 * free.y);
}
