//! Rounding: scenes far from the origin, distant cameras and lights, and coincident faces.

use std::f32::consts::PI;

use glam::Vec3;
use rayframe::scene::{Environment, LightKind, Material, Transmission, Volume};

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

/// Half edges of a square whose normal leans in all three axes.
fn slanted() -> (Vec3, Vec3, Vec3) {
    let normal = Vec3::new(0.48, 0.64, 0.6);
    let u = Vec3::new(0.8, -0.6, 0.0);
    (u, normal.cross(u), normal)
}

#[test]
fn a_light_as_far_as_a_sun_leaves_no_speckles() {
    // 1e12 cd from 1e6 m straight above is 1 lux; L = E / π.
    let (u, v, normal) = slanted();
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, u * 9.0, v * 9.0), lambert(Vec3::ONE));
    stage.add_light(LightKind::Point, 1e12, normal * 1e6, -normal);
    for step in 0..40 {
        let target = u * (step as f32 * 0.173 - 3.1) + v * (step as f32 * 0.119 - 2.3);
        assert_close(stage.look(target + normal * 3.0 + u, target), Vec3::splat(1.0 / PI), 1e-4);
    }
}

#[test]
fn surfaces_far_from_the_origin_do_not_shadow_or_reflect_themselves() {
    let (u, v, normal) = slanted();
    for center in [Vec3::ZERO, Vec3::new(1e4, -2e4, 3e4), Vec3::splat(1e6)] {
        let mut stage = Stage::new();
        // One lux along the normal, and a mirror that reflects the environment alone.
        let half = Material { metallic: 0.5, roughness: 0.0, ..lambert(Vec3::ONE) };
        stage.add(rectangle(center, u * 4096.0, v * 4096.0), half);
        stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, -normal);
        stage.environment = Environment::Constant(Vec3::splat(0.25));
        for step in 0..40 {
            let target = center + u * (step as f32 * 17.3 - 301.0) + v * (step as f32 * 11.9 - 230.0);
            let eye = target + normal * 64.0 + u * 48.0;
            // Half Lambert: 0.5 · (1 / π + 0.25); half white mirror: 0.5 · 0.25.
            let expected = 0.5 / PI + 0.25;
            assert_close(stage.look(eye, target), Vec3::splat(expected), 1e-3);
        }
    }
}

#[test]
fn a_far_eye_does_not_bring_light_under_a_lid() {
    // A lid 4 mm above the floor, single-sided and facing down, is invisible from above but occludes the light. The floor is as
    // dark from a distance of 20 km as from close by.
    for height in [2.0, 20_000.0] {
        let mut stage = Stage::new();
        stage.add(rectangle(Vec3::ZERO, Vec3::Z * 900.0, Vec3::X * 900.0), lambert(Vec3::ONE));
        stage.add(rectangle(Vec3::Y * 0.004, Vec3::X * 90.0, Vec3::Z * 90.0), lambert(Vec3::ONE));
        stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::NEG_Y);
        let eye = Vec3::new(1.0, height, 2.0);
        assert_close(stage.look(eye, Vec3::new(1.5, 0.0, 2.0)), Vec3::ZERO, 0.0);
    }
}

#[test]
fn a_ray_through_an_edge_of_glass_enters_once() {
    // The ray hits the diagonal between the two triangles of the top, then leaves through the middle of one at the bottom:
    // √(4 + 0.5² + 0.25²) metres of n = 1 with c left a metre, and nothing from there on.
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5) };
    let mut stage = Stage::new();
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.add(cuboid(Vec3::ZERO, Vec3::new(4.0, 1.0, 4.0)), glass(Some(volume)));
    let through = Vec3::new(0.5, -2.0, 0.25);
    let seen = stage.look(Vec3::Y - through, Vec3::Y);
    assert_close(seen, Vec3::splat(libm::powf(0.5, through.length())), 1e-5);
}

fn glass(volume: Option<Volume>) -> Material {
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    Material { roughness: 0.0, transmission, volume, double_sided: true, ..lambert(Vec3::ONE) }
}

#[test]
fn a_surface_in_contact_with_glass_is_visible_through_it() {
    // n = 1 reflects nothing. The emissive floor coincides with the pane or the bottom of the block, whichever comes first in
    // the file; behind it there is a darker one.
    let clear = Volume::CLEAR;
    for volume in [None, Some(clear)] {
        for glass_first in [true, false] {
            let mut stage = Stage::new();
            let floor = rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0);
            let body = match volume {
                Some(_) => cuboid(Vec3::Y, Vec3::ONE),
                None => rectangle(Vec3::ZERO, Vec3::Z, Vec3::X),
            };
            if glass_first {
                stage.add(body, glass(volume));
                stage.add(floor, unlit(Vec3::splat(0.75)));
            } else {
                stage.add(floor, unlit(Vec3::splat(0.75)));
                stage.add(body, glass(volume));
            }
            stage.add(rectangle(Vec3::NEG_Y, Vec3::Z * 4.0, Vec3::X * 4.0), unlit(Vec3::splat(0.125)));
            let seen = stage.look(Vec3::new(0.4, 5.0, 0.3), Vec3::new(0.2, 0.0, 0.1));
            assert_close(seen, Vec3::splat(0.75), 1e-5);
        }
    }
}

#[test]
fn directional_light_is_attenuated_inside_a_volume() {
    // A white floor lies inside a block of n = 1, 1 m below its top: c is left of the light, and again on the way to the eye
    // that looks straight down. Directional and point light agree.
    let color = Vec3::new(0.9, 0.6, 0.3);
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: color };
    for kind in [LightKind::Directional, LightKind::Point] {
        let mut stage = Stage::new();
        stage.add(cuboid(Vec3::ZERO, Vec3::new(5.0, 1.0, 5.0)), glass(Some(volume)));
        stage.add(rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0), lambert(Vec3::ONE));
        let intensity = if kind == LightKind::Point { PI * 100.0 } else { PI };
        stage.add_light(kind, intensity, Vec3::Y * 10.0, Vec3::NEG_Y);
        let seen = stage.look(Vec3::Y * 5.0 + Vec3::X * 1e-3, Vec3::X * 1e-3);
        assert_close(seen, color * color, 1e-4);
    }
}
