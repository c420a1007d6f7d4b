//! Lamps and suns that shine through frosted glass.

use glam::{Quat, Vec3, Vec4};
use rayframe::render::{GlassShadows, Integrator};
use rayframe::scene::{
    DiffuseTransmission, Environment, LightKind, Material, Primitive, Transmission, Volume,
};

use super::environment_shadows::{TO_SUN, sunny};
use super::frosted_glass::{WALL, frosted, sphere};
use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle};

/// What a camera sees of frosted glass in the light of one lamp, without bounces.
fn by_a_lamp(
    integrator: Integrator,
    seen: &[(Primitive, Material)],
    lamp: Vec3,
    edit: impl Fn(&mut Stage),
) -> Vec3 {
    let mut stage = super::path::stage(4096);
    (stage.settings.integrator, stage.settings.max_depth) = (integrator, 0);
    for (primitive, material) in seen {
        stage.add(primitive.clone(), material.clone());
    }
    stage.add_light(LightKind::Point, 10.0, lamp, Vec3::NEG_Z);
    edit(&mut stage);
    stage.look(Vec3::new(0.3, 0.2, 4.0), Vec3::new(0.3, 0.2, 0.0)).truncate()
}

#[test]
fn volumes_glow_by_lamps_in_and_behind_them_as_paths_see_them() {
    let amber =
        Volume { thickness: 1.0, attenuation_distance: 2.0, attenuation_color: WALL.max(Vec3::splat(0.1)) };
    for roughness in [0.2, 0.5, 1.0] {
        let glass = Material { volume: Some(amber), ..frosted(roughness) };
        let air = Material { volume: Some(Volume::CLEAR), ior: 1.0, ..frosted(0.0) };
        let ball = [(sphere(1.0), glass.clone())];
        let shell = [(sphere(1.0), glass), (sphere(0.9), air)];
        for (seen, lamp) in
            [(&ball[..], Vec3::ZERO), (&shell[..], Vec3::ZERO), (&ball[..], Vec3::NEG_Z * 3.0)]
        {
            let see = |integrator| by_a_lamp(integrator, seen, lamp, |_| ());
            let (whitted, path) = (see(Integrator::Whitted), see(Integrator::Path));
            assert!(path.min_element() > 0.0);
            let off = (whitted / path - Vec3::ONE).abs().max_element();
            assert!(off < 1e-4, "{roughness}, lamp at {lamp}: {whitted} instead of {path}");
        }
    }
}

#[test]
fn lamps_show_once_through_several_frosted_surfaces() {
    // A sampled ray finds the far side, in the dark and in light of an environment.
    let volume = Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(0.6) };
    let pane = |z: f32| (rectangle(Vec3::Z * z, Vec3::X * 9.0, Vec3::Y * 9.0), frosted(0.6));
    for seen in [vec![(sphere(1.0), volume)], vec![pane(1.0), pane(0.0)]] {
        let lit = |integrator, light: f32, max_depth| {
            by_a_lamp(integrator, &seen, Vec3::NEG_Z * 3.0, |stage| {
                stage.environment = Environment::Constant(Vec3::splat(light));
                stage.settings.max_depth = max_depth;
            })
        };
        let expected = lit(Integrator::Path, 0.0, 0);
        for (light, max_depth) in [(0.0, 0), (0.0, 12), (1e-6, 12)] {
            let seen = lit(Integrator::Whitted, light, max_depth);
            assert!((seen / expected - Vec3::ONE).abs().max_element() < 2e-3, "{seen} instead of {expected}");
        }
    }
}

#[test]
fn frosted_lamps_show_in_mirrors_and_behind_clear_glass() {
    let glass = Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(0.6) };
    let globe = |z: f32| {
        let mut sphere = sphere(1.0);
        sphere.positions.iter_mut().for_each(|position| position.z += z);
        (sphere, glass.clone())
    };
    let see = |seen: &[(Primitive, Material)], lamp| {
        by_a_lamp(Integrator::Whitted, seen, lamp, |stage| stage.settings.max_depth = 8)
    };
    let alone = see(&[globe(0.0)], Vec3::ZERO);

    // A lossless slab transmits (1 - R) / (1 + R), with all reflections between its sides.
    let slab = cuboid(Vec3::Z * 2.0, Vec3::new(9.0, 9.0, 0.01));
    let clear = Material { volume: Some(Volume::CLEAR), ..frosted(0.0) };
    let behind = see(&[globe(0.0), (slab, clear)], Vec3::ZERO);
    assert!((behind / alone - 0.96 / 1.04).abs().max_element() < 1e-3, "{behind} of {alone}");

    // The mirror has the highlight of the lamp, too, which light reaches straight.
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..lambert(Vec3::ONE) };
    let wall = (rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0), mirror);
    let mirrored = see(&[globe(8.0), wall], Vec3::Z * 8.0);
    assert!((mirrored / alone - Vec3::ONE).abs().max_element() < 0.05, "{mirrored} instead of {alone}");
}

#[test]
fn lamps_in_a_frosted_volume_are_reflected_totally_within() {
    // Camera and lamp in a cube of glass, and its side at 65 degrees, beyond the critical angle of 42.
    let see = |integrator, roughness| {
        let mut stage = super::path::stage(4096);
        (stage.settings.integrator, stage.settings.max_depth) = (integrator, 1);
        stage.add(
            cuboid(Vec3::ZERO, Vec3::new(9.0, 1.0, 9.0)),
            Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(roughness) },
        );
        stage.add_light(LightKind::Point, 10.0, Vec3::X * 2.1, Vec3::NEG_Y);
        stage.look(Vec3::NEG_X * 2.1, Vec3::NEG_Y)
    };
    for roughness in [0.3, 0.5] {
        let expected = see(Integrator::Path, roughness).truncate();
        assert!(expected.x > 5.0);
        assert_close(see(Integrator::Whitted, roughness), expected, 0.08 * expected.x);
    }
}

#[test]
fn frosted_walls_that_a_lamp_lights_from_beside_show_through_others() {
    // The lamp is before the first pane and behind the second one, which is at a right angle to it.
    let pane = |u, v| (rectangle(Vec3::ZERO, u, v), frosted(0.6));
    let first = pane(Vec3::X * 9.0, Vec3::Y * 9.0);
    let mut second = pane(Vec3::Y * 9.0, Vec3::Z * 0.9);
    second.0.positions.iter_mut().for_each(|position| *position += Vec3::new(-0.5, 0.0, -1.0));
    let lamp = Vec3::new(-8.0, 0.0, 4.0);
    let see = |seen: &[(Primitive, Material)]| {
        by_a_lamp(Integrator::Whitted, seen, lamp, |stage| stage.settings.max_depth = 2).x
    };
    let (alone, both) = (see(std::slice::from_ref(&first)), see(&[first.clone(), second]));
    assert!(both > alone + 1e-3, "{both} with the second pane, {alone} without");
}

#[test]
fn glass_that_transmits_diffusely_keeps_that_light_behind_frosted_glass() {
    let pane = |z: f32, factor| {
        let through = DiffuseTransmission { factor, texture: None, color: Vec3::ONE, color_texture: None };
        let transmission = Some(Transmission { factor: 0.2, texture: None });
        let base_color = Vec4::new(0.5, 0.5, 0.5, 1.0);
        let glass =
            Material { transmission, diffuse_transmission: Some(through), base_color, ..frosted(0.6) };
        (rectangle(Vec3::Z * z, Vec3::X * 90.0, Vec3::Y * 90.0), glass)
    };
    let [whitted, path] = [Integrator::Whitted, Integrator::Path].map(|integrator| {
        let [without, with] = [0.0, 1.0].map(|factor| {
            let seen = [pane(0.2, 0.0), pane(0.0, factor)];
            by_a_lamp(integrator, &seen, Vec3::new(30.0, 0.0, -30.0), |stage| stage.settings.max_depth = 1).x
        });
        assert!(with > 5.0 * without && without > 0.0, "{integrator:?}: {with} {without}");
        with
    });
    assert!((whitted / path - 1.0).abs() < 0.01, "{whitted} {path}");
}

#[test]
fn opaque_glass_shadows_leave_lamps_to_the_last_frosted_surface() {
    let see = |lamp, glass_shadows| {
        let volume = Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(0.6) };
        by_a_lamp(Integrator::Whitted, &[(sphere(1.0), volume)], lamp, |stage| {
            (stage.settings.glass_shadows, stage.settings.max_depth) = (glass_shadows, 2);
        })
        .x
    };
    let within = [GlassShadows::Straight, GlassShadows::Opaque].map(|shadows| see(Vec3::ZERO, shadows));
    assert_eq!(within[0], within[1]);
    let behind = see(Vec3::NEG_Z * 3.0, GlassShadows::Opaque);
    assert!(behind > 1.0, "{behind}");
}

#[test]
fn suns_show_behind_a_frosted_volume_and_a_frosted_pane() {
    let sunny = sunny([20_000.0; 3]).unwrap();
    let side = TO_SUN.any_orthonormal_vector();
    let across = TO_SUN.cross(side);
    let volume = Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(0.5) };
    let pane = (rectangle(TO_SUN * 3.0, side * 90.0, across * 90.0), frosted(0.5));
    let see = |integrator, seen: &[(Primitive, Material)]| {
        let mut stage = super::path::stage(4096);
        (stage.settings.integrator, stage.settings.max_depth) = (integrator, 12);
        stage.environment = sunny.clone();
        for (primitive, material) in seen {
            stage.add(primitive.clone(), material.clone());
        }
        stage.look(TO_SUN * -4.0 + side * 0.4, side * 0.4).x
    };
    let ball = (sphere(1.0), volume);
    // Alone, the ball is looked up where it sends refracted rays, which is an estimate.
    for (seen, has_pane) in
        [(vec![ball.clone()], false), (vec![pane.clone()], true), (vec![ball, pane], true)]
    {
        let (whitted, path) = (see(Integrator::Whitted, &seen), see(Integrator::Path, &seen));
        let tolerance = if has_pane { 0.05 } else { 0.3 };
        assert!(path > 2.0 && (whitted / path - 1.0).abs() < tolerance, "{whitted} instead of {path}");
    }
}

#[test]
fn suns_behind_clear_glass_show_where_glass_stops_shadow_rays() {
    let sunny = sunny([20_000.0; 3]).unwrap();
    let side = TO_SUN.any_orthonormal_vector();
    let across = TO_SUN.cross(side);
    let see = |glass_shadows| {
        let mut stage = super::path::stage(1 << 14);
        stage.settings.integrator = Integrator::Whitted;
        (stage.settings.glass_shadows, stage.settings.max_depth) = (glass_shadows, 12);
        stage.environment = sunny.clone();
        stage.add(rectangle(Vec3::ZERO, side * 9.0, across * 9.0), frosted(0.3));
        let clear = Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(0.0) };
        let mut slab = cuboid(Vec3::Z, Vec3::new(9.0, 9.0, 0.1));
        let to_sun = Quat::from_rotation_arc(Vec3::Z, TO_SUN);
        slab.positions.iter_mut().for_each(|position| *position = to_sun * *position);
        stage.add(slab, clear);
        stage.look(-4.0 * TO_SUN, Vec3::ZERO).x
    };
    // Shadow rays pass the slab, or sampled rays find the sun behind it.
    let [straight, opaque] = [GlassShadows::Straight, GlassShadows::Opaque].map(see);
    assert!((opaque / straight - 1.0).abs() < 0.15, "{opaque} instead of {straight}");
}

#[test]
fn an_invisible_slab_below_a_frosted_lamp_changes_nothing() {
    // The floor has the lamp by its own shadow ray. A path that finds the frosted glass beyond the slab must not add it once more.
    let air = Material { volume: Some(Volume::CLEAR), ior: 1.0, ..frosted(0.0) };
    let sheet = Volume { thickness: 1.0, ..Volume::CLEAR };
    for shade in [frosted(0.6), Material { volume: Some(sheet), ..frosted(0.6) }] {
        let floor = |has_slab: bool| {
            let mut stage = super::path::stage(4096);
            stage.settings.max_depth = 16;
            stage.add(super::path::floor(2.0), lambert(Vec3::splat(0.8)));
            let sheet = if shade.volume.is_some() {
                cuboid(Vec3::Y * 2.0, Vec3::new(2.5, 0.05, 2.5))
            } else {
                rectangle(Vec3::Y * 2.0, Vec3::Z * 2.5, Vec3::X * 2.5)
            };
            stage.add(sheet, Material { double_sided: true, ..shade.clone() });
            if has_slab {
                stage.add(cuboid(Vec3::Y * 0.8, Vec3::new(3.0, 0.2, 3.0)), air.clone());
            }
            stage.add_light(LightKind::Point, 40.0, Vec3::Y * 4.0, Vec3::NEG_Y);
            super::path::middle(&stage)
        };
        let open = floor(false);
        assert!(open.x > 0.1);
        assert_close(floor(true), open.truncate(), 0.02 * open.x);
    }
}

#[test]
fn the_innermost_of_nested_volumes_absorbs_the_light_of_a_lamp_in_it() {
    // Half a metre in the inner volume, 0.3 m in the outer one, and the rest in vacuum.
    let (inner, outer) = (Vec3::new(0.8, 0.4, 0.6), Vec3::new(0.5, 0.9, 0.7));
    let volume = |color: Vec3| {
        let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: color };
        Material { volume: Some(volume), ior: 1.0, ..frosted(0.0) }
    };
    let absorbed = |distance: f32| move |channel: f32| libm::powf(channel, distance);
    let expected =
        Vec3::from(inner.to_array().map(absorbed(0.5))) * Vec3::from(outer.to_array().map(absorbed(0.3)));
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let lit = |is_nested: bool, is_catcher: bool| {
            let mut stage = super::path::stage(16);
            stage.settings.integrator = integrator;
            stage.settings.show_background = false;
            let floor = Material { is_shadow_catcher: is_catcher, ..lambert(Vec3::ONE) };
            stage.add(super::path::floor(5.0), floor);
            if is_nested {
                stage.add(cuboid(Vec3::Y * 4.0, Vec3::new(1.0, 0.5, 1.0)), volume(inner));
                stage.add(cuboid(Vec3::Y * 4.1, Vec3::new(2.0, 0.9, 2.0)), volume(outer));
            }
            stage.add_light(LightKind::Point, 50.0, Vec3::Y * 4.0, Vec3::NEG_Y);
            stage.look(Vec3::new(1e-3, 3.0, 0.0), Vec3::ZERO)
        };
        let share = lit(true, false).truncate() / lit(false, false).truncate();
        assert!(share.abs_diff_eq(expected, 2e-3), "{integrator:?}: {share} instead of {expected}");
        // Catchers catch the shadow as grey.
        let luminance = expected.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let alpha = lit(true, true).w;
        assert!(
            (1.0 - alpha - luminance).abs() < 0.01,
            "{integrator:?}: {alpha} instead of {}",
            1.0 - luminance
        );
    }
}
