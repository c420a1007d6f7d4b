//! A Lambert wall under punctual lights in closed form: L = ρ/π · E.

use std::f32::consts::PI;

use glam::Vec3;
use rayframe::scene::{Environment, LightKind};

use crate::stage::{Stage, assert_close, lambert, rectangle, unlit};

const ALBEDO: Vec3 = Vec3::new(0.8, 0.4, 0.2);

/// A wall in the plane z = 0 that faces +Z.
fn wall() -> Stage {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 5.0), lambert(ALBEDO));
    stage
}

fn look_at_wall(stage: &Stage) -> glam::Vec4 {
    stage.look(Vec3::new(1.0, 1.0, 4.0), Vec3::ZERO)
}

#[test]
fn point_light() {
    // From (3, 0, 4): d² = 25, cos θ = 4/5, so E = 100 cd · 0.8 / 25 = 3.2 lux.
    let mut stage = wall();
    stage.add_light(LightKind::Point, 100.0, Vec3::new(3.0, 0.0, 4.0), Vec3::NEG_Y);
    assert_close(look_at_wall(&stage), ALBEDO * 3.2 / PI, 1e-5);
}

#[test]
fn directional_light() {
    // 2 lux at 60° from the normal: E = 2 · cos 60° = 1.
    let mut stage = wall();
    let direction = Vec3::new(libm::sinf(PI / 3.0), 0.0, -0.5);
    stage.add_light(LightKind::Directional, 2.0, Vec3::ZERO, direction);
    assert_close(look_at_wall(&stage), ALBEDO / PI, 1e-5);
}

#[test]
fn spot_light_between_its_cones() {
    // The point lies 0.4 rad off the axis of a light straight above at 2 m. The ramp is
    // ((cos 0.4 − cos 0.6) / (cos 0.2 − cos 0.6))², and E = 10 cd / 4 · ramp.
    let (inner, outer, off) = (0.2_f32, 0.6_f32, 0.4_f32);
    let ramp = (libm::cosf(off) - libm::cosf(outer)) / (libm::cosf(inner) - libm::cosf(outer));
    let kind = LightKind::Spot { inner_cone_radians: inner, outer_cone_radians: outer };
    let mut stage = wall();
    let axis = Vec3::new(libm::sinf(off), 0.0, -libm::cosf(off));
    stage.add_light(kind, 10.0, Vec3::new(0.0, 0.0, 2.0), axis);
    assert_close(look_at_wall(&stage), ALBEDO * (2.5 * ramp * ramp / PI), 1e-5);
}

#[test]
fn lights_add_up_and_light_scale_multiplies_them() {
    let mut stage = wall();
    stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::NEG_Z);
    stage.add_light(LightKind::Directional, 2.0, Vec3::ZERO, Vec3::NEG_Z);
    stage.settings.light_scale = 0.5;
    assert_close(look_at_wall(&stage), ALBEDO * 1.5 / PI, 1e-5);
}

#[test]
fn light_from_behind_does_not_contribute() {
    let mut stage = wall();
    stage.add_light(LightKind::Directional, 5.0, Vec3::ZERO, Vec3::Z);
    stage.add_light(LightKind::Point, 5.0, Vec3::new(0.0, 0.0, -1.0), Vec3::Z);
    assert_close(look_at_wall(&stage), Vec3::ZERO, 0.0);
}

#[test]
fn a_blocker_casts_a_shadow_from_either_side() {
    for flip in [1.0, -1.0] {
        let mut stage = wall();
        stage.add_light(LightKind::Point, 50.0, Vec3::new(0.0, 0.0, 3.0), Vec3::NEG_Z);
        stage.add_light(LightKind::Directional, 50.0, Vec3::ZERO, Vec3::NEG_Z);
        let half = Vec3::new(0.2, 0.0, 0.0);
        stage.add(rectangle(Vec3::new(0.0, 0.0, 1.0), half * flip, Vec3::Y * 0.2), lambert(Vec3::ONE));
        assert_close(look_at_wall(&stage), Vec3::ZERO, 0.0);
    }
}

#[test]
fn unlit_surfaces_cast_shadows_and_receive_none() {
    let mut stage = wall();
    stage.add_light(LightKind::Directional, 5.0, Vec3::ZERO, Vec3::NEG_Z);
    stage.add(rectangle(Vec3::new(0.0, 0.0, 1.0), Vec3::X * 0.2, Vec3::Y * 0.2), unlit(Vec3::splat(0.3)));
    assert_close(look_at_wall(&stage), Vec3::ZERO, 0.0);
    assert_close(stage.look(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO), Vec3::splat(0.3), 1e-6);
}

#[test]
fn a_constant_environment_lights_by_its_integral() {
    // E = π L, so L_out = ρ/π · π L = ρ L: the white furnace.
    let mut stage = wall();
    stage.environment = Environment::Constant(Vec3::new(1.0, 2.0, 0.5));
    assert_close(look_at_wall(&stage), ALBEDO * Vec3::new(1.0, 2.0, 0.5), 1e-5);
}

#[test]
fn the_background_is_visible_or_left_out() {
    let mut stage = wall();
    stage.environment = Environment::Constant(Vec3::splat(0.25));
    let away = |stage: &Stage| stage.look(Vec3::new(0.0, 0.0, 4.0), Vec3::new(0.0, 0.0, 9.0));
    assert_eq!(away(&stage), Vec3::splat(0.25).extend(1.0));
    stage.settings.show_background = false;
    assert_eq!(away(&stage), glam::Vec4::ZERO);
}
