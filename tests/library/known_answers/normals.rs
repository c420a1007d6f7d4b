//! Normal maps and vertex normals, outward and inside out.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec4};
use rayframe::render::Integrator;
use rayframe::scene::{ClearCoat, LightKind, Material, NormalTexture, Primitive};

use crate::stage::{Stage, assert_close, lambert, rectangle};

/// Texel of a normal that leans to +X and more to +Y.
const TEXEL: [u8; 4] = [166, 204, 217, 255];

fn texel_normal() -> Vec3 {
    let [x, y, z, _] = TEXEL.map(|code| 2.0 * f32::from(code) / 255.0 - 1.0);
    Vec3::new(x, y, z).normalize()
}

/// A square in the plane z = 0 that faces +Z; the image is upright on it, so v grows towards −Y.
fn square() -> Primitive {
    let uvs = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)];
    Primitive { uvs: vec![uvs.to_vec()], ..rectangle(Vec3::ZERO, Vec3::X, Vec3::Y) }
}

/// Radiance of the normal-mapped square towards `eye`, lit along ±(0.48, 0.6, 0.64) from the side of the eye.
fn lit(primitive: Primitive, eye: Vec3, to_light: Vec3) -> Vec4 {
    let mut stage = Stage::new();
    let texture = stage.add_texel(TEXEL);
    let normal_texture = Some(NormalTexture { texture, scale: 1.0 });
    stage.add(primitive, Material { normal_texture, double_sided: true, ..lambert(Vec3::ONE) });
    stage.add_light(LightKind::Directional, PI, Vec3::ZERO, -to_light);
    stage.look(eye, Vec3::new(0.1, 0.2, 0.0))
}

const TO_LIGHT: Vec3 = Vec3::new(0.48, 0.6, 0.64);

#[test]
fn a_normal_map_leans_right_and_up_with_and_without_tangents() {
    let expected = Vec3::splat(texel_normal().dot(TO_LIGHT));
    let tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    for primitive in [square(), Primitive { tangents, ..square() }] {
        assert_close(lit(primitive, Vec3::new(0.1, 0.2, 3.0), TO_LIGHT), expected, 1e-5);
    }
}

#[test]
fn the_back_of_a_normal_map_shows_the_reversed_normal() {
    let tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    let primitive = Primitive { tangents, ..square() };
    let expected = Vec3::splat(texel_normal().dot(TO_LIGHT));
    assert_close(lit(primitive, Vec3::new(0.1, 0.2, -3.0), -TO_LIGHT), expected, 1e-5);
}

#[test]
fn inside_out_normals_turn_with_their_map() {
    // Authored N = −Z with T = +X, so B = N × T = −Y: the mapped normal (x, −y, −z) looks away and is reversed.
    let tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    let primitive = Primitive { tangents, normals: Some(vec![Vec3::NEG_Z; 4]), ..square() };
    let normal = texel_normal() * Vec3::new(-1.0, 1.0, 1.0);
    let expected = Vec3::splat(normal.dot(TO_LIGHT));
    assert_close(lit(primitive, Vec3::new(0.1, 0.2, 3.0), TO_LIGHT), expected, 1e-5);
}

#[test]
fn a_dent_with_inside_out_normals_does_not_shadow_itself() {
    // The normals of a dent lean inwards; all are stored reversed. In the middle they cancel to the square's own.
    let lean = |x: f32, y: f32| Vec3::new(0.3 * x, 0.3 * y, -1.0).normalize();
    let normals = vec![lean(-1.0, -1.0), lean(1.0, -1.0), lean(1.0, 1.0), lean(-1.0, 1.0)];
    let mut stage = Stage::new();
    stage.add(Primitive { normals: Some(normals), ..square() }, lambert(Vec3::ONE));
    stage.add_light(LightKind::Directional, PI, Vec3::ZERO, Vec3::NEG_Z);
    assert_close(stage.look(Vec3::Z * 3.0, Vec3::ZERO), Vec3::ONE, 1e-5);
}

#[test]
fn hard_edges_of_inside_out_meshes_are_lit_as_the_rest() {
    // A cap whose normals are smoothed over its edge: far from the reversed normal of a mesh that is stored inside out.
    let leaning = Vec3::new(0.65, 0.0, 0.76).normalize();
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let look = |normal: Vec3, is_inside_out| {
            let mut stage = Stage::new();
            stage.settings.integrator = integrator;
            let primitive = Primitive { normals: Some(vec![normal; 4]), is_inside_out, ..square() };
            stage.add(primitive, lambert(Vec3::ONE));
            stage.add_light(LightKind::Directional, PI, Vec3::ZERO, -TO_LIGHT);
            stage.look(Vec3::new(0.1, 0.2, 3.0), Vec3::new(0.1, 0.2, 0.0))
        };
        assert_close(look(-leaning, true), Vec3::splat(leaning.dot(TO_LIGHT)), 1e-5);
        assert_eq!(look(-leaning, true), look(leaning, false));
        assert_ne!(look(-leaning, false), look(leaning, false));
    }
}

#[test]
fn upright_normals_light_leaning_cards_alike() {
    // Cards that face +Z under a sun, as grass is stored: normals point up, whichever way the card leans.
    let look = |up: Vec3, integrator| {
        let mut stage = Stage::new();
        stage.settings.integrator = integrator;
        let material = Material { double_sided: true, ..lambert(Vec3::ONE) };
        stage.add(Primitive { normals: Some(vec![up.normalize(); 4]), ..square() }, material);
        stage.add_light(LightKind::Directional, PI, Vec3::ZERO, Vec3::NEG_Y);
        stage.look(Vec3::new(0.1, 0.7, 3.0), Vec3::new(0.1, 0.2, 0.0)).x
    };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let [back, front, far] = [0.01, -0.01, -0.7].map(|z| look(Vec3::new(0.0, 1.0, z), integrator));
        assert!((back - front).abs() < 0.02 && front > 0.7, "{integrator:?}: {back} {front}");
        assert!(far > 0.5, "{integrator:?}: {far}");
    }
}

#[test]
fn smooth_meshes_have_smooth_terminators() {
    // A tube of six sides. The light is 100° from the normal of the side that is seen, and 100° − atan(tan 30° / 2) from the normal
    // that is interpolated three quarters along it.
    let half = libm::tanf(PI / 6.0);
    let around = |angle: f32| Vec3::new(libm::sinf(angle), libm::cosf(angle), 0.0);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut stage = Stage::new();
        stage.settings.integrator = integrator;
        for side in 0..6 {
            let angle = side as f32 * PI / 3.0;
            let normals = [-1.0, 1.0, 1.0, -1.0].map(|end| around(angle + end * PI / 6.0)).to_vec();
            let across = around(angle + PI / 2.0) * half;
            let plane = rectangle(around(angle), across, Vec3::NEG_Z * 5.0);
            stage.add(Primitive { normals: Some(normals), ..plane }, lambert(Vec3::ONE));
        }
        let to_light = around(100.0_f32.to_radians());
        stage.add_light(LightKind::Directional, PI, Vec3::ZERO, -to_light);
        let expected = libm::cosf(100.0_f32.to_radians() - libm::atanf(0.5 * half));
        let seen = Vec3::new(0.5 * half, 1.0, 0.0);
        assert_close(stage.look(seen + Vec3::Y * 3.0, seen), Vec3::splat(expected), 1e-4);
        // A coat takes a few per cent of the light.
        for material in &mut stage.scene.materials {
            material.clear_coat = Some(ClearCoat {
                factor: 1.0,
                texture: None,
                roughness: 0.1,
                roughness_texture: None,
                normal_texture: None,
            });
        }
        let coated = stage.look(seen + Vec3::Y * 3.0, seen).x;
        assert!((0.8 * expected..expected).contains(&coated), "{integrator:?}: {coated} of {expected}");
    }
}
