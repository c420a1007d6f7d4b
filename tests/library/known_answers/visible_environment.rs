//! Light of the environment through windows, where paths sample what is seen of it.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use rayframe::scene::{BuiltInLight, Environment, Material, Primitive, Transmission};

use super::path::{floor, middle, square_form_factor, stage};
use crate::stage::{Stage, assert_close, lambert, rectangle};

/// A black box of half width 3 and height 2 around the middle of the floor, whose ceiling has a square hole of half width `hole`.
fn interior(samples: u32, hole: f32) -> Stage {
    let mut stage = stage(samples);
    stage.add(floor(3.0), lambert(Vec3::splat(0.5)));
    let black = Material { double_sided: true, ..lambert(Vec3::ZERO) };
    for wall in walls().into_iter().chain(ceiling(hole)) {
        stage.add(wall, black.clone());
    }
    stage
}

fn walls() -> [Primitive; 4] {
    let up = Vec3::Y * 2.0;
    [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z]
        .map(|side| rectangle(side * 3.0, Vec3::new(side.z, 0.0, side.x) * 3.0, up))
}

/// Four rectangles around the hole.
fn ceiling(hole: f32) -> [Primitive; 4] {
    let beside = (3.0 - hole) / 2.0;
    let middle = 3.0 - beside;
    [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| {
        let along = if side.x == 0.0 { Vec3::X * hole } else { Vec3::Z * 3.0 };
        rectangle(Vec3::Y * 2.0 + side * middle, side * beside, along)
    })
}

/// Radiance of the middle of the floor of [`interior`]: Σ L cos θ cos θ' / r² over the hole.
fn expected(environment: &Environment, hole: f32) -> Vec3 {
    const STEPS: i32 = 200;
    let step = 2.0 * hole / STEPS as f32;
    let at = |index: i32| (index as f32 + 0.5) * step - hole;
    let mut irradiance = Vec3::ZERO;
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let span = Vec3::new(at(i), 2.0, at(j));
        let direction = span.normalize();
        let cosine = direction.y;
        irradiance +=
            environment.radiance(direction) * (cosine * cosine * step * step / span.length_squared());
    }
    irradiance * (0.5 * FRAC_1_PI)
}

#[test]
fn a_small_window_lights_an_interior_by_its_form_factor() {
    // A cosine-distributed ray finds the smaller window once in 80 times: a standard error of 14 % for so many.
    for hole in [0.2, 1.0] {
        let mut stage = interior(4096, hole);
        stage.environment = Environment::Constant(Vec3::splat(4.0));
        let expected = 2.0 * square_form_factor(hole, 2.0);
        assert_close(middle(&stage), Vec3::splat(expected), 0.03 * expected);
    }
}

#[test]
fn windows_show_the_part_of_the_environment_behind_them() {
    for environment in [BuiltInLight::Studio, BuiltInLight::Outdoor].map(Environment::BuiltIn) {
        let mut stage = interior(16_384, 0.2);
        let expected = expected(&environment, 0.2);
        // Its key light is a light of its own.
        stage.settings.light_scale = 0.0;
        stage.environment = environment;
        assert_close(middle(&stage), expected, 0.02 * expected.max_element());
    }
}

#[test]
fn clear_panes_in_windows_tint_their_light() {
    // An index of 1 reflects nothing.
    let mut stage = interior(4096, 0.2);
    stage.environment = Environment::Constant(Vec3::splat(4.0));
    let pane = Material {
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        roughness: 0.0,
        double_sided: true,
        ..lambert(Vec3::splat(0.5))
    };
    stage.add(rectangle(Vec3::Y * 2.0, Vec3::Z * 0.2, Vec3::X * 0.2), pane);
    let expected = square_form_factor(0.2, 2.0);
    assert_close(middle(&stage), Vec3::splat(expected), 0.03 * expected);
}

#[test]
fn closed_interiors_are_dark() {
    let mut stage = interior(16, 0.0);
    stage.environment = Environment::Constant(Vec3::ONE);
    assert_close(middle(&stage), Vec3::ZERO, 0.0);
}
