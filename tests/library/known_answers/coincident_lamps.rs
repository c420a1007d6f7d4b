//! Emissive surfaces that lie exactly on others, by the path integrator.

use glam::{Vec3, Vec4};
use rayframe::scene::{AlphaMode, DiffuseTransmission, Material, Primitive};

use super::path::{floor, middle, square_form_factor, stage};
use crate::stage::{assert_close, lambert, rectangle};

const BLACK: Vec4 = Vec4::new(0.0, 0.0, 0.0, 1.0);

/// A square lamp above the floor whose front faces down.
fn square() -> Primitive {
    rectangle(Vec3::Y, Vec3::X, Vec3::Z)
}

/// The same corners, of which each triangle lists another one first.
fn rotated() -> Primitive {
    let triangles = square().triangles.into_iter().map(|[a, b, c]| [b, c, a]).collect();
    Primitive { triangles, ..square() }
}

/// The same corners with the front facing up.
fn turned() -> Primitive {
    let triangles = square().triangles.into_iter().map(|[a, b, c]| [b, a, c]).collect();
    Primitive { triangles, ..square() }
}

fn lamp() -> Material {
    Material { emissive: Vec3::splat(3.0), ..lambert(Vec3::ZERO) }
}

fn two_sided(material: Material) -> Material {
    Material { double_sided: true, ..material }
}

/// A black lamp of this alpha.
fn blended(alpha: f32) -> Material {
    Material { alpha_mode: AlphaMode::Blend, base_color: BLACK.with_w(alpha), ..lamp() }
}

/// Asserts how much of the light of one lamp arrives on the floor below surfaces, which are listed in this order.
#[track_caller]
fn assert_light(surfaces: &[(Primitive, Material)], share: f32) {
    let mut stage = stage(4096);
    stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
    for (primitive, material) in surfaces {
        stage.add(primitive.clone(), material.clone());
    }
    let lit = 0.5 * 3.0 * square_form_factor(1.0, 1.0);
    assert_close(middle(&stage), Vec3::splat(share * lit), 0.015 * lit * share);
}

#[test]
fn copies_of_a_lamp_light_once_whatever_the_order_of_their_corners() {
    let masked = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..lamp() };
    assert_light(&[(square(), lamp()), (rotated(), lamp())], 1.0);
    assert_light(&[(square(), two_sided(lamp())), (turned(), two_sided(lamp()))], 1.0);
    assert_light(&[(turned(), two_sided(lamp())), (rotated(), lamp())], 1.0);
    assert_light(&[(square(), masked.clone()), (square(), masked)], 1.0);
}

#[test]
fn lamps_under_an_earlier_opaque_surface_are_dark_on_its_side() {
    let black = || lambert(Vec3::ZERO);
    assert_light(&[(rotated(), black()), (square(), lamp())], 0.0);
    assert_light(&[(square(), black()), (square(), two_sided(lamp()))], 0.0);
    assert_light(&[(turned(), two_sided(black())), (square(), lamp())], 0.0);
    // Below, rays pass the back of the cover.
    assert_light(&[(turned(), black()), (square(), lamp())], 1.0);
    assert_light(&[(turned(), black()), (square(), two_sided(lamp()))], 1.0);
    assert_light(&[(square(), lamp()), (square(), black())], 1.0);
    // Two covers that face apart
    assert_light(&[(square(), black()), (turned(), black()), (square(), two_sided(lamp()))], 0.0);
}

#[test]
fn lamps_under_blended_ones_count_by_what_these_let_pass() {
    assert_light(&[(square(), blended(0.5)), (rotated(), blended(0.5))], 0.75);
    assert_light(&[(square(), blended(0.5)), (rotated(), lamp())], 1.0);
    let film = Material { emissive: Vec3::ZERO, ..blended(0.25) };
    assert_light(&[(turned(), two_sided(film.clone())), (square(), lamp())], 0.75);
    assert_light(&[(turned(), film), (square(), lamp())], 1.0);
}

#[test]
fn covers_hide_by_their_alpha_at_the_same_point_in_any_order() {
    // The middle of the floor sees no two corners of the lamp alike.
    let moved = |square: Primitive| Primitive {
        positions: square.positions.iter().map(|corner| *corner + Vec3::new(0.8, 0.0, 0.3)).collect(),
        ..square
    };
    // A film that is opaque at one corner
    let light = |square: Primitive, opaque: usize| {
        let mut colors = vec![Vec4::ONE.with_w(0.0); square.positions.len()];
        colors[opaque].w = 1.0;
        let cover = Primitive { colors: Some(colors), ..moved(square) };
        let film = Material { emissive: Vec3::ZERO, ..two_sided(blended(1.0)) };
        let mut stage = stage(4096);
        stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
        stage.add(cover, film);
        stage.add(moved(self::square()), lamp());
        middle(&stage).x
    };
    for opaque in 0..4 {
        let expected = light(square(), opaque);
        for square in [rotated(), turned()] {
            let light = light(square, opaque);
            assert!((light / expected - 1.0).abs() < 0.01, "corner {opaque}: {light} {expected}");
        }
    }
    let lights = [0, 1, 2, 3].map(|opaque| light(square(), opaque));
    let [least, most] = [f32::min, f32::max].map(|of| lights.into_iter().reduce(of).unwrap());
    assert!(most > 1.05 * least, "{lights:?}");
}

#[test]
fn copies_of_paper_that_shines_light_once() {
    // Each of them gave way to the other for ever.
    let factor = DiffuseTransmission { factor: 0.5, texture: None, color: Vec3::ZERO, color_texture: None };
    let paper = || Material { diffuse_transmission: Some(factor), ..two_sided(lamp()) };
    assert_light(&[(square(), paper()), (square(), paper()), (turned(), paper())], 1.0);
}
