//! Shadows of the environment in Whitted's tree.

use std::f64::consts::PI;

use glam::{Vec2, Vec3};
use rayframe::error::Result;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{
    AlphaMode, Environment, EnvironmentImage, EnvironmentMap, Ground, Material, Primitive, Transmission,
};

use super::path::{floor, middle, square_form_factor};
use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle};

/// A stage in uniform light, of one narrow pixel with `samples` samples.
pub(super) fn stage(samples: u32) -> Stage {
    let mut stage = super::path::stage(samples);
    stage.settings.integrator = Integrator::Whitted;
    stage.environment = Environment::Constant(Vec3::ONE);
    stage
}

#[test]
fn a_square_hides_its_form_factor() {
    for half_width in [0.2, 1.0, 5.0] {
        let mut stage = stage(4096);
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
        let above = rectangle(Vec3::Y, Vec3::Z * half_width, Vec3::X * half_width);
        stage.add(above, lambert(Vec3::ZERO));
        // What hides the light reflects 0.5 / (2 − 0.5) of it.
        let expected = 0.5 * (1.0 - square_form_factor(half_width, 1.0) * (1.0 - 1.0 / 3.0));
        assert_close(middle(&stage), Vec3::splat(expected), 0.004);
        // Several rays at once, and none.
        stage.settings.samples = 256;
        stage.settings.env_samples = EnvSamples::Fixed(16);
        assert_close(middle(&stage), Vec3::splat(expected), 0.004);
        stage.settings.env_samples = EnvSamples::Fixed(0);
        assert_close(middle(&stage), Vec3::splat(0.5), 1e-6);
    }
}

#[test]
fn light_that_nothing_hides_has_no_noise() {
    let mut stage = stage(1);
    stage.add(cuboid(Vec3::ZERO, Vec3::ONE), lambert(Vec3::new(0.8, 0.5, 0.2)));
    for env_samples in [EnvSamples::Auto, EnvSamples::Fixed(3)] {
        stage.settings.env_samples = env_samples;
        assert_close(middle(&stage), Vec3::new(0.8, 0.5, 0.2), 1e-6);
    }
}

#[test]
fn walls_hide_what_rough_metals_mirror() {
    // The wall stands beyond the point that is seen. A few directions of the lobe lead away from it.
    let metal = Material { metallic: 1.0, roughness: 0.5, ..lambert(Vec3::splat(0.5)) };
    let seen = |has_wall: bool| {
        let mut stage = stage(1024);
        stage.add(floor(5.0), metal.clone());
        if has_wall {
            let wall = rectangle(Vec3::new(0.0, 0.0, -0.5), Vec3::X * 50.0, Vec3::Y * 50.0);
            stage.add(wall, lambert(Vec3::ZERO));
        }
        middle(&stage).x
    };
    let (open, walled) = (seen(false), seen(true));
    let share = walled / open;
    assert!((open - 0.5).abs() < 0.02, "{open}");
    assert!((0.01..0.07).contains(&share), "{walled} of {open}");
}

#[test]
fn the_ground_and_its_shadow_follow_the_same_form_factor() {
    // A wide square fills most of the sky. In the directions of a small one each ray decides about little light, and `Auto` traces few.
    for (half_width, tolerance, of_auto) in [(1.0, 0.005, 0.005), (0.3, 0.002, 0.002), (0.1, 2e-4, 6e-4)] {
        let mut stage = stage(4096);
        stage.settings.show_background = false;
        stage.settings.ground = Some(Ground { up: Vec3::Y, height: 0.0, is_mirror: false });
        stage.add(rectangle(Vec3::Y, Vec3::Z * half_width, Vec3::X * half_width), lambert(Vec3::ONE));
        let expected = square_form_factor(half_width, 1.0);
        for (env_samples, samples, tolerance) in [
            (EnvSamples::Auto, 32_768, of_auto),
            (EnvSamples::Fixed(1), 4096, tolerance),
            (EnvSamples::Fixed(16), 256, tolerance),
        ] {
            (stage.settings.env_samples, stage.settings.samples) = (env_samples, samples);
            let seen = middle(&stage);
            assert!((seen.w - expected).abs() < tolerance, "{env_samples:?}: {seen} for {expected}");
            assert_eq!(seen.truncate(), Vec3::ZERO);
        }
    }
}

/// A sky of radiance 20 within 15° of the zenith, and dark elsewhere.
fn window_above() -> Result<Environment> {
    window(false)
}

/// The same, or around the nadir.
pub(super) fn window(is_below: bool) -> Result<Environment> {
    let (width, height) = (1024, 512);
    let row = |row: u32| if f64::from(row) < f64::from(height) * 15.0 / 180.0 { [20.0; 3] } else { [0.0; 3] };
    let mut pixels: Vec<[f32; 3]> = (0..width * height).map(|index| row(index / width)).collect();
    if is_below {
        pixels.reverse();
    }
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    Ok(Environment::Map(EnvironmentMap::new("window.hdr".as_ref(), image, 0.0)?))
}

/// Black cards one metre above a point, and the share of the light of [`window_above`] that each hides there.
fn cards() -> [(Primitive, f32); 4] {
    let card = |edge: f32| rectangle(Vec3::new(edge + 1.0, 1.0, 0.0), Vec3::Z * 2.0, Vec3::X);
    let [edge_within, edge_beyond] = [-20.0_f32, 20.0].map(|degrees| libm::tanf(degrees.to_radians()));
    let small = rectangle(Vec3::Y, Vec3::Z * 0.4, Vec3::X * 0.4);
    [(card(edge_within), 1.0), (card(0.0), 0.5), (card(edge_beyond), 0.0), (small, 1.0)]
}

#[test]
fn light_from_a_window_casts_sharp_shadows_on_the_ground() {
    for (index, (card, hidden)) in cards().into_iter().enumerate() {
        let mut stage = stage(4096);
        stage.environment = window_above().unwrap();
        stage.settings.show_background = false;
        stage.settings.ground = Some(Ground { up: Vec3::Y, height: 0.0, is_mirror: false });
        stage.add(card, lambert(Vec3::ZERO));
        for env_samples in [EnvSamples::Auto, EnvSamples::Fixed(1)] {
            stage.settings.env_samples = env_samples;
            let seen = middle(&stage);
            assert!((seen.w - hidden).abs() < 0.02, "card {index}, {env_samples:?}: {seen} for {hidden}");
        }
    }
}

/// A dark sky with two lamps of these half angles in degrees and radiances: 20° from the zenith towards +X, and 74° towards −X. Also the share of the
/// irradiance on the ground that the first lamp has.
fn two_lamps(lamps: [(f64, f64); 2]) -> Result<(Environment, f32)> {
    const TILTS: [f64; 2] = [20.0, -74.0];
    let (width, height) = (1024, 512);
    let (mut pixels, mut irradiances) = (Vec::new(), [0.0; 2]);
    for index in 0..width * height {
        let polar = PI * (f64::from(index / width) + 0.5) / f64::from(height);
        let azimuth = 2.0 * PI * ((f64::from(index % width) + 0.5) / f64::from(width) - 0.5);
        let (x, y) = (libm::sin(polar) * libm::sin(azimuth), libm::cos(polar));
        let mut pixel = 0.0;
        for ((half_angle, radiance), (tilt, irradiance)) in
            lamps.into_iter().zip(TILTS.into_iter().zip(&mut irradiances))
        {
            let (sine, cosine) = libm::sincos(f64::to_radians(tilt));
            if x * sine + y * cosine > libm::cos(half_angle.to_radians()) {
                pixel += radiance;
                // By the cosine and the solid angle of the pixel
                *irradiance += radiance * y * libm::sin(polar);
            }
        }
        pixels.push([pixel as f32; 3]);
    }
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    let share = irradiances[0] / (irradiances[0] + irradiances[1]);
    Ok((Environment::Map(EnvironmentMap::new("lamps.hdr".as_ref(), image, 0.0)?), share as f32))
}

#[test]
fn each_lamp_of_a_sky_casts_its_share_of_the_shadow_on_the_ground() {
    let above = rectangle(Vec3::new(0.4, 1.0, 0.0), Vec3::Z * 0.45, Vec3::X * 0.45);
    let beside = rectangle(Vec3::new(-1.0, 0.35, 0.0), Vec3::Z * 0.4, Vec3::Y * 0.35);
    // Wide lamps, and a sun beside a wide lamp.
    for lamps in [[(12.0, 2.0), (12.0, 20.0)], [(1.0, 500.0), (12.0, 20.0)]] {
        let (sky, share) = two_lamps(lamps).unwrap();
        for (card, hidden) in [(&above, share), (&beside, 1.0 - share)] {
            for integrator in [Integrator::Whitted, Integrator::Path] {
                let mut stage = stage(4096);
                stage.settings.integrator = integrator;
                stage.environment = sky.clone();
                stage.settings.show_background = false;
                stage.settings.ground = Some(Ground { up: Vec3::Y, height: 0.0, is_mirror: false });
                stage.add(card.clone(), Material { double_sided: true, ..lambert(Vec3::ZERO) });
                let seen = middle(&stage);
                assert!((seen.w - hidden).abs() < 0.02, "{lamps:?}, {integrator:?}: {seen} for {hidden}");
            }
        }
    }
}

#[test]
fn light_from_a_window_casts_sharp_shadows_on_surfaces() {
    let sine = libm::sinf(15.0_f32.to_radians());
    for (index, (card, hidden)) in cards().into_iter().enumerate() {
        let mut stage = stage(4096);
        stage.environment = window_above().unwrap();
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
        stage.add(card, lambert(Vec3::ZERO));
        // What hides the light reflects a third of the mean of all directions.
        let mean = 10.0 * (1.0 - libm::cosf(15.0_f32.to_radians()));
        let seen = middle(&stage).x / 0.5;
        let (share, reflected) = (seen / (20.0 * sine * sine), mean / 3.0 / (20.0 * sine * sine));
        let expected = 1.0 - hidden * (1.0 - reflected);
        assert!((share - expected).abs() < 0.02, "card {index}: {share} for {expected}");
    }
}

#[test]
fn automatic_shadows_leave_closed_spaces_lit() {
    let mut stage = stage(16);
    let mut inside = cuboid(Vec3::ZERO, Vec3::splat(3.0));
    for triangle in &mut inside.triangles {
        triangle.swap(1, 2);
    }
    stage.add(inside, lambert(Vec3::splat(0.5)));
    assert_close(middle(&stage), Vec3::splat(0.5), 1e-6);
    stage.settings.env_samples = EnvSamples::Fixed(1);
    // No light comes in.
    assert_close(middle(&stage), Vec3::ZERO, 1e-6);
}

/// A wide wall beside the seen point of a wide floor of albedo `floor_albedo`.
fn beside_a_wall(stage: &mut Stage, floor_albedo: f32, color: Vec3) {
    beside_a_wall_of(stage, floor_albedo, lambert(color));
}

fn beside_a_wall_of(stage: &mut Stage, floor_albedo: f32, material: Material) {
    stage.add(floor(500.0), lambert(Vec3::splat(floor_albedo)));
    let mut wall = rectangle(Vec3::new(0.0, 200.0, -0.5), Vec3::X * 500.0, Vec3::Y * 200.0);
    wall.uvs = vec![vec![Vec2::ZERO; 4]];
    stage.add(wall, material);
}

/// The radiance of that floor in a sky of radiance 1, where a share of the wall is seen from it. Half of the sky is behind the wall, and half of it behind the floor
/// for the wall: E_floor = 1/2 + color E_wall / 2 and E_wall = 1/2 + floor_albedo E_floor / 2.
fn light_beside_a_wall(floor_albedo: f32, color: Vec3, seen_share: f32) -> Vec3 {
    let wall = (0.5 + 0.25 * floor_albedo) / (Vec3::ONE - color * (0.25 * floor_albedo));
    (Vec3::ONE + color * wall * seen_share) * (0.5 * floor_albedo)
}

#[test]
fn the_colors_of_occluders_bleed() {
    let color = Vec3::new(0.9, 0.4, 0.0);
    let expected = |floor_albedo: f32| light_beside_a_wall(floor_albedo, color, 1.0);
    for (env_samples, samples) in
        [(EnvSamples::Auto, 4096), (EnvSamples::Fixed(1), 4096), (EnvSamples::Fixed(16), 256)]
    {
        let mut stage = stage(samples);
        stage.settings.env_samples = env_samples;
        beside_a_wall(&mut stage, 0.5, color);
        assert_close(middle(&stage), expected(0.5), 0.01);
        stage.settings.integrator = Integrator::Path;
        assert_close(middle(&stage), expected(0.5), 0.013);
    }
    // On white floors the lookup is what was estimated for the wall, too.
    let mut stage = stage(4096);
    beside_a_wall(&mut stage, 1.0, color);
    assert_close(middle(&stage), expected(1.0), 0.03);
}

#[test]
fn walls_that_are_no_glass_where_they_are_hit_bleed_as_others_do() {
    // The material is glass elsewhere: its texture of the transmission is 0.
    let color = Vec3::new(0.9, 0.4, 0.0);
    let light = |is_glass_elsewhere: bool| {
        let mut stage = stage(64);
        let mut material = lambert(color);
        if is_glass_elsewhere {
            let texture = Some(stage.add_texel([0, 0, 0, 255]));
            material.transmission = Some(Transmission { factor: 1.0, texture });
        }
        beside_a_wall_of(&mut stage, 0.5, material);
        middle(&stage)
    };
    assert_close(light(true), light(false).truncate(), 1e-6);
}

#[test]
fn transparent_surfaces_dim_the_light_of_occluders() {
    // A small black pane beside the seen point covers half of the wall, and hides next to nothing of the sky from that.
    let color = Vec3::new(0.9, 0.4, 0.0);
    let seen = |integrator: Integrator| {
        let mut stage = stage(4096);
        stage.settings.integrator = integrator;
        beside_a_wall(&mut stage, 0.5, color);
        let pane = rectangle(Vec3::new(0.0, 0.05, -2e-3), Vec3::X * 0.1, Vec3::Y * 0.05);
        let black = Material { base_color: glam::Vec4::new(0.0, 0.0, 0.0, 0.5), ..lambert(Vec3::ZERO) };
        stage.add(pane, Material { alpha_mode: AlphaMode::Blend, double_sided: true, ..black });
        middle(&stage)
    };
    let expected = light_beside_a_wall(0.5, color, 0.5);
    assert_close(seen(Integrator::Whitted), expected, 0.012);
    assert_close(seen(Integrator::Path), expected, 0.01);
}

#[test]
fn the_back_of_single_sided_occluders_is_not_lit() {
    // A bright wall stands behind one that is seen from its back.
    let seen = |has_second_wall: bool| {
        let mut stage = stage(1024);
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.add(floor(500.0), lambert(Vec3::splat(0.5)));
        let first = rectangle(Vec3::new(0.0, 200.0, -0.5), Vec3::Y * 200.0, Vec3::X * 500.0);
        stage.add(first, lambert(Vec3::ONE));
        if has_second_wall {
            let second = rectangle(Vec3::new(0.0, 200.0, -1.0), Vec3::X * 500.0, Vec3::Y * 200.0);
            stage.add(second, lambert(Vec3::X));
        }
        middle(&stage)
    };
    // Half of the sky is hidden, by what reflects 0.5 / (2 − 0.5) of it.
    assert_close(seen(false), Vec3::splat(0.5 * (0.5 + 0.5 / 3.0)), 0.004);
    assert_eq!(seen(true), seen(false));
}

/// The direction to the sun of [`sunny`]: 10° above the horizon and 60° from the wall's normal.
pub(super) const TO_SUN: Vec3 = Vec3::new(0.852_87, 0.173_65, 0.492_40);

/// A sun of one degree on a dim sky.
pub(super) fn sunny(sun: [f32; 3]) -> Result<Environment> {
    let (width, height) = (1024, 512);
    let pixel = |index: u32| {
        let [u, v] = [index % width, index / width].map(|texel| f64::from(texel) + 0.5);
        let degrees = [u * 360.0 / f64::from(width) - 300.0, v * 180.0 / f64::from(height) - 80.0];
        if degrees.iter().all(|degrees| degrees.abs() < 0.5) { sun } else { [0.2; 3] }
    };
    let pixels = (0..width * height).map(pixel).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    Ok(Environment::Map(EnvironmentMap::new("sun.hdr".as_ref(), image, 0.0)?))
}

/// Light that a wall of albedo 0.6 reflects to the floor under [`sunny`]. `has_screen` has a far screen before the sun.
fn reflected_by_a_wall(sunny: &Environment, has_screen: bool, integrator: Integrator) -> Vec3 {
    let light = |wall: f32| {
        let mut stage = stage(4096);
        stage.environment = sunny.clone();
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.settings.integrator = integrator;
        // A dark floor reflects no more light of the sun to the wall.
        beside_a_wall(&mut stage, 0.02, Vec3::splat(wall));
        if has_screen {
            let screen = rectangle(TO_SUN * 300.0, Vec3::new(-25.0, 0.0, 43.3), Vec3::Y * 50.0);
            stage.add(screen, lambert(Vec3::ZERO));
        }
        middle(&stage).truncate()
    };
    light(0.6) - light(0.0)
}

#[test]
fn occluders_reflect_the_light_of_suns() {
    let sunny = sunny([20_000.0; 3]).unwrap();
    let [whitted, path] = [Integrator::Whitted, Integrator::Path]
        .map(|integrator| reflected_by_a_wall(&sunny, false, integrator).x);
    assert!(path > 0.004, "{path}");
    assert!((whitted / path - 1.0).abs() < 0.05, "{whitted} of {path}");
}

#[test]
fn occluders_have_the_color_of_the_light_that_reaches_them() {
    let orange = sunny([20_000.0, 5000.0, 0.0]).unwrap();
    let lit = reflected_by_a_wall(&orange, false, Integrator::Whitted);
    assert!(lit.x > 2.0 * lit.y && lit.y > 2.0 * lit.z, "{lit}");
    let shaded = reflected_by_a_wall(&orange, true, Integrator::Whitted);
    let path = reflected_by_a_wall(&orange, true, Integrator::Path);
    // The far parts of wall and floor, which the sun reaches, add some red.
    assert!((shaded.z / path.z - 1.0).abs() < 0.05, "{shaded} of {path}");
    assert!(shaded.x < 1.2 * shaded.z && path.x < 1.5 * path.z, "{shaded} of {path}");
}

/// What tints the light hides nothing that would reflect in its place.
#[test]
fn tinted_panes_dim_the_light_and_veils_hide_a_part_of_it() {
    let tint = Vec3::new(1.0, 0.05, 0.0);
    let dyed = Material { base_color: tint.extend(1.0), ..super::glass::glass(1.0, None) };
    let black = Material { base_color: Vec3::ZERO.extend(0.5), ..lambert(Vec3::ZERO) };
    let veil = Material { alpha_mode: AlphaMode::Blend, double_sided: true, ..black };
    // A white floor, whose hidden light is estimated as if nothing hid any, and a grey one, of whose light a third is.
    for (pane, color, expected) in [
        (&dyed, 1.0, tint),
        (&dyed, 0.5, tint * 0.5),
        (&veil, 1.0, Vec3::ONE),
        (&veil, 0.5, Vec3::splat(0.5 * (0.5 + 0.5 / 3.0))),
    ] {
        let mut stage = stage(1024);
        stage.settings.env_samples = EnvSamples::Fixed(1);
        stage.add(floor(5.0), lambert(Vec3::splat(color)));
        stage.add(rectangle(Vec3::Y, Vec3::Z * 200.0, Vec3::X * 200.0), pane.clone());
        assert_close(middle(&stage), expected, 0.002);
    }
}
