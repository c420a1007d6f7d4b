//! Mirrors and Fresnel's equations.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};
use rayframe::error::Result;
use rayframe::render::Integrator;
use rayframe::scene::{
    ClearCoat, Environment, EnvironmentImage, EnvironmentMap, Material, Projection, Transmission,
};

use crate::stage::{Stage, assert_close, black_gloss, cuboid, lambert, rectangle, unlit};

/// Unpolarised Fresnel reflectance with Snell refraction, in f64.
fn fresnel(cos_i: f64, n: f64) -> f32 {
    let sin_t2 = (1.0 - cos_i * cos_i) / (n * n);
    let cos_t = libm::sqrt(1.0 - sin_t2);
    let s = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    let p = (n * cos_i - cos_t) / (n * cos_i + cos_t);
    f64::midpoint(s * s, p * p) as f32
}

fn mirror(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), metallic: 1.0, roughness: 0.0, ..Material::default() }
}

/// A floor in the plane y = 0 that faces up.
fn floor(material: Material) -> Stage {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0), material);
    stage
}

#[test]
fn a_white_mirror_shows_the_panel_in_front_of_it() {
    // Seen at 45° from +X the mirror shows the panel at −X, 45° up.
    let mut stage = floor(mirror(Vec3::ONE));
    let panel = rectangle(Vec3::new(-2.0, 2.0, 0.0), Vec3::new(0.1, 0.1, 0.0), Vec3::Z * 0.1);
    stage.add(panel, unlit(Vec3::new(0.2, 0.5, 0.9)));
    assert_close(stage.look(Vec3::new(2.0, 2.0, 0.0), Vec3::ZERO), Vec3::new(0.2, 0.5, 0.9), 1e-6);
    // A little to the side it does not.
    assert_close(stage.look(Vec3::new(2.0, 2.0, 0.0), Vec3::Z * 0.5), Vec3::ZERO, 1e-6);
}

#[test]
fn a_coloured_mirror_tints_at_normal_incidence_and_whitens_by_schlick() {
    let gold = Vec3::new(1.0, 0.7, 0.3);
    let mut stage = floor(mirror(gold));
    stage.environment = Environment::Constant(Vec3::ONE);
    assert_close(stage.look(Vec3::Y, Vec3::ZERO), gold, 1e-5);
    // cos θ = 0.5: F = F0 + (1 − F0) · 0.5⁵.
    let eye = Vec3::new(libm::sqrtf(0.75), 0.5, 0.0);
    assert_close(stage.look(eye, Vec3::ZERO), gold + (Vec3::ONE - gold) / 32.0, 1e-5);
}

#[test]
fn dielectrics_follow_fresnel_from_normal_to_grazing() {
    for (ior, cos) in [(1.5, 1.0), (1.5, 0.5), (1.5, 0.1), (1.33, 0.7), (2.4, 0.3)] {
        let mut stage = floor(black_gloss(ior));
        stage.environment = Environment::Constant(Vec3::ONE);
        let eye = Vec3::new(libm::sqrtf(1.0 - cos * cos), cos, 0.0);
        let expected = fresnel(f64::from(cos), f64::from(ior));
        assert_close(stage.look(eye, Vec3::ZERO), Vec3::splat(expected), 1e-4);
    }
    // At normal incidence ((n − 1)/(n + 1))² = 0.04.
    assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-7);
}

#[test]
fn an_absurd_index_of_refraction_reflects_everything() {
    for ior in [1e10, 1e30, f32::MAX] {
        let mut stage = floor(black_gloss(ior));
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.add_light(rayframe::scene::LightKind::Directional, 1.0, Vec3::ZERO, Vec3::X);
        assert_close(stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO), Vec3::ONE, 1e-5);
    }
}

#[test]
fn depth_limits_the_bounces_between_two_mirrors() {
    // Parallel mirrors face each other along Y: the eye between them sees bounce after bounce until the limit, then black.
    // Each of the two outermost surfaces emits, so that the sum counts the bounces: 1 + 1 + … (depth + 1 terms).
    let glowing = Material { emissive: Vec3::ONE, ..mirror(Vec3::ONE) };
    let mut stage = floor(glowing.clone());
    stage.add(rectangle(Vec3::Y * 2.0, Vec3::X * 5.0, Vec3::Z * 5.0), glowing);
    for max_depth in [0, 1, 5] {
        stage.settings.max_depth = max_depth;
        let seen = stage.look(Vec3::new(0.3, 1.0, 0.2), Vec3::new(0.3, 0.0, 0.2));
        assert_close(seen, Vec3::splat(max_depth as f32 + 1.0), 1e-4);
    }
}

#[test]
fn weights_below_the_cut_off_are_black() {
    // F = 0.04 twice is 0.0016 > 1/1024; three times is 6.4e-5, which is cut off. Between two parallel glossy walls that
    // each emit 1: 1 + 0.04 + 0.0016.
    let glowing = Material { emissive: Vec3::ONE, ..black_gloss(1.5) };
    let mut stage = floor(glowing.clone());
    stage.add(rectangle(Vec3::Y * 2.0, Vec3::X * 5.0, Vec3::Z * 5.0), glowing);
    let seen = stage.look(Vec3::new(0.3, 1.0, 0.2), Vec3::new(0.3, 0.0, 0.2));
    assert_close(seen, Vec3::splat(1.0416), 2e-6);
}

#[test]
fn rough_lobes_neither_gain_nor_lose_energy_in_a_white_furnace() {
    for metallic in [0.0, 1.0] {
        for roughness in [0.0, 0.05, 0.2, 0.3, 0.5, 1.0] {
            let material =
                Material { base_color: Vec4::ONE, metallic, roughness, ior: 1.5, ..Material::default() };
            let mut stage = floor(material);
            stage.environment = Environment::Constant(Vec3::ONE);
            for cos in [1.0, 0.6, 0.2] {
                let eye = Vec3::new(libm::sqrtf(1.0 - cos * cos), cos, 0.0);
                let seen = stage.look(eye, Vec3::ZERO).truncate();
                let what = format!("metallic {metallic} roughness {roughness} cos {cos}: {seen}");
                // What facets scatter among themselves is given back.
                assert!((seen - Vec3::ONE).abs().max_element() < 1e-3, "{what}");
            }
        }
    }
}

/// Light that grows towards +X, from 0.1 to 1.9.
pub(super) fn slanted_light() -> Result<Environment> {
    let (width, height) = (128, 64);
    let radiance = |index: u32| {
        // +X lies to the right of the centre, which is −Z.
        let (column, row) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        let sine = libm::sinf(PI * row / height as f32);
        [1.0 + 0.9 * sine * libm::sinf(2.0 * PI * (column / width as f32 - 0.5)); 3]
    };
    let pixels = (0..width * height).map(radiance).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    Ok(Environment::Map(EnvironmentMap::new("slanted.hdr".as_ref(), image, 0.0)?))
}

/// A view of next to a single direction.
fn narrow() -> Projection {
    Projection::Perspective { fov_y_radians: 0.01, aspect_ratio: None, z_near: 0.0, z_far: None }
}

/// What a floor of `material` in slanted light shows to viewers at several angles on both sides, by Whitted's tree and by paths.
fn in_slanted_light(light: &Environment, material: &Material) -> Vec<(String, f32, f32)> {
    let mut stage = floor(material.clone());
    stage.environment = light.clone();
    stage.projection = narrow();
    let mut seen = Vec::new();
    for cos in [0.1, 0.3, 0.6, 0.9_f32] {
        for side in [-1.0, 1.0] {
            let eye = Vec3::new(side * libm::sqrtf(1.0 - cos * cos), cos, 0.0);
            (stage.settings.integrator, stage.settings.samples) = (Integrator::Whitted, 1);
            let looked_up = stage.look(eye, Vec3::ZERO).x;
            (stage.settings.integrator, stage.settings.samples) = (Integrator::Path, 1024);
            let by_paths = stage.look(eye, Vec3::ZERO).x;
            seen.push((format!("cos {cos}, side {side}"), looked_up, by_paths));
        }
    }
    seen
}

#[test]
fn rough_surfaces_look_light_up_where_their_lobes_lean() {
    let light = slanted_light().unwrap();
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    for (roughness, tolerance) in [(0.5, 0.16), (0.75, 0.1), (1.0, 0.03)] {
        let metal = Material { roughness, ..mirror(Vec3::ONE) };
        let pane = Material { metallic: 0.0, transmission, double_sided: true, ..metal.clone() };
        let clear_coat = ClearCoat {
            factor: 1.0,
            roughness,
            texture: None,
            roughness_texture: None,
            normal_texture: None,
        };
        let coated = Material { clear_coat: Some(clear_coat), ..lambert(Vec3::ZERO) };
        for (name, material) in [("metal", metal), ("pane", pane), ("coat", coated)] {
            for (view, seen, expected) in in_slanted_light(&light, &material) {
                let what = format!("{name}, roughness {roughness}, {view}: {seen} for {expected}");
                assert!((seen - expected).abs() < tolerance, "{what}");
            }
        }
    }
}

#[test]
fn satin_mirrors_and_panes_blur_edges_of_light() {
    // Light 1 where x > 0, whose edge is seen along the mirror direction of a view from above
    let (width, height) = (256, 128);
    let pixels =
        (0..width * height).map(|index| [f32::from(u8::from(index % width >= width / 2)); 3]).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    let mut stage = floor(mirror(Vec3::ONE));
    stage.projection = narrow();
    stage.environment = Environment::Map(EnvironmentMap::new("half.hdr".as_ref(), image, 0.0).unwrap());
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    for roughness in [0.0, 0.15, 0.2, 0.3, 0.4] {
        let metal = Material { roughness, ..mirror(Vec3::ONE) };
        let pane = Material { metallic: 0.0, transmission, double_sided: true, ..metal.clone() };
        for (name, material) in [("metal", metal), ("pane", pane)] {
            stage.scene.materials[0] = material;
            for degrees in [-20.0, -8.0, -3.0, 3.0, 8.0, 20.0_f32] {
                let eye = Vec3::new(libm::sinf(degrees.to_radians()), libm::cosf(degrees.to_radians()), 0.1);
                let seen =
                    [(Integrator::Whitted, 1), (Integrator::Path, 4096)].map(|(integrator, samples)| {
                        (stage.settings.integrator, stage.settings.samples) = (integrator, samples);
                        stage.look(eye, Vec3::ZERO).x
                    });
                let what = format!("{name}, roughness {roughness}, {degrees} degrees: {seen:?}");
                assert!((seen[0] - seen[1]).abs() < 0.08, "{what}");
            }
        }
    }
}

#[test]
fn a_lambert_wall_in_a_mirror_is_lit_like_one_seen_directly() {
    use rayframe::scene::LightKind;
    let mut stage = floor(mirror(Vec3::ONE));
    stage.add(rectangle(Vec3::X * -3.0, Vec3::Y * 5.0, Vec3::Z * 5.0), lambert(Vec3::splat(0.5)));
    stage.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::NEG_X);
    let direct = stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::new(-3.0, 1.0, 0.0));
    let mirrored = stage.look(Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO);
    assert_close(direct, Vec3::splat(1.5 / std::f32::consts::PI), 1e-5);
    assert_close(mirrored, direct.truncate(), 1e-5);
}

#[test]
fn rough_metals_show_what_is_around_them_without_an_environment() {
    // In a box of radiance 1 a white metal is invisible, at any roughness.
    for roughness in [0.2, 0.3, 0.5, 1.0] {
        let see = |is_coated: bool| {
            let mut stage = super::path::stage(4096);
            stage.settings.integrator = Integrator::Whitted;
            stage.add(
                cuboid(Vec3::ZERO, Vec3::splat(9.0)),
                Material { double_sided: true, ..unlit(Vec3::ONE) },
            );
            let clear_coat = is_coated.then_some(ClearCoat {
                factor: 0.0,
                texture: None,
                roughness: 0.0,
                roughness_texture: None,
                normal_texture: None,
            });
            let material = Material { metallic: 1.0, roughness, clear_coat, ..lambert(Vec3::ONE) };
            stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y), material);
            stage.look(Vec3::new(2.0, 0.0, 2.0), Vec3::ZERO)
        };
        // Hits are shaded in blocks, and one by one where there is a coat.
        for is_coated in [false, true] {
            assert_close(see(is_coated), Vec3::ONE, 0.01);
        }
    }
}

#[test]
fn grazing_views_of_rough_dielectrics_show_what_is_around_them_without_an_environment() {
    // No surface is a metal or glass.
    let mut stage = super::path::stage(4096);
    stage.settings.integrator = Integrator::Whitted;
    stage.add(cuboid(Vec3::ZERO, Vec3::splat(9.0)), Material { double_sided: true, ..unlit(Vec3::ONE) });
    let floor = Material { roughness: 0.3, ..black_gloss(1.5) };
    stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y), floor);
    let [steep, grazing] = [1.0, 0.02].map(|height| stage.look(Vec3::new(2.0, 0.0, height), Vec3::ZERO).x);
    assert!(steep < 0.1 && grazing > 0.3, "{steep} {grazing}");
}
