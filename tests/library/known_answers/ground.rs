//! The ground: where shadows land, how opaque they are, and mirror images in premultiplied form.

use glam::{Vec3, Vec4};
use rayframe::framing::ground_below;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{
    AlphaMode, AnimationTarget, Environment, Ground, LightKind, Material, NodeIndex, Scene, SelectedCamera,
    ViewRequest,
};

use crate::stage::{Stage, animate, assert_close, cuboid, lambert, rectangle, select_all, unlit};

/// Gap below the lowest point, as a share of the framed diagonal.
const GAP: f32 = 1.0 / 32_768.0;

fn plane(height: f32, is_mirror: bool) -> Ground {
    Ground { up: Vec3::Y, height, is_mirror }
}

/// A cube of 1 m that floats 1 m above a ground at 0, and a sun that shines along (1, −1, 0).
fn floating_cube() -> Stage {
    let mut stage = Stage::new();
    stage.settings.show_background = false;
    stage.settings.ground = Some(plane(0.0, false));
    stage.add(cuboid(Vec3::Y * 1.5, Vec3::splat(0.5)), lambert(Vec3::ONE));
    stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0));
    stage
}

/// What is seen at a point of the ground from the side.
fn seen_at(stage: &Stage, x: f32, z: f32) -> Vec4 {
    stage.look(Vec3::new(x, 1.0, z + 20.0), Vec3::new(x, 0.0, z))
}

#[test]
fn a_shadow_lands_where_the_light_takes_it() {
    // Of corners at (±0.5, 1 to 2, ±0.5), moved by their heights along x: from 0.5 to 2.5, |z| up to 0.5.
    let stage = floating_cube();
    for (x, z, alpha) in [
        (0.49, 0.0, 0.0),
        (0.51, 0.0, 1.0),
        (2.49, 0.0, 1.0),
        (2.51, 0.0, 0.0),
        (1.5, 0.49, 1.0),
        (1.5, 0.51, 0.0),
        (400.0, 0.0, 0.0),
    ] {
        assert_eq!(seen_at(&stage, x, z), Vec4::new(0.0, 0.0, 0.0, alpha), "{x} {z}");
    }
    // From below it is invisible.
    assert_eq!(stage.look(Vec3::new(1.5, -1.0, 9.0), Vec3::new(1.5, 0.0, 0.0)), Vec4::ZERO);
}

#[test]
fn the_environment_brightens_shadows() {
    let mut stage = floating_cube();
    // The sun gives cos 45° and the environment π.
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.settings.env_samples = EnvSamples::Fixed(0);
    let sun = 0.5_f32.sqrt();
    let alpha = seen_at(&stage, 1.5, 0.0).w;
    assert!((alpha - sun / (sun + std::f32::consts::PI)).abs() < 1e-5, "{alpha}");
    assert_eq!(seen_at(&stage, 3.0, 0.0), Vec4::ZERO);
}

#[test]
fn mirror_images_are_premultiplied_and_leave_the_environment_out() {
    let mut stage = Stage::new();
    stage.settings.show_background = false;
    stage.settings.ground = Some(plane(0.0, true));
    stage.environment = Environment::Constant(Vec3::ONE);
    // Without the card's own shadow
    stage.settings.env_samples = EnvSamples::Fixed(0);
    let color = Vec3::new(0.25, 0.5, 2.0);
    stage.add(rectangle(Vec3::new(0.0, 1.0, 0.0), Vec3::X * 0.4, Vec3::Y * 0.4), unlit(color));
    // At 45° onto an index of 1.5: F = 0.0502399 by Fresnel's equations.
    let reflectance = 0.050_239_9;
    let seen = stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0));
    assert_close(seen, color * reflectance, 1e-5);
    assert!((seen.w - reflectance).abs() < 1e-5, "{seen}");
    // Beside the card the ground mirrors the environment alone.
    assert_eq!(stage.look(Vec3::new(3.0, 1.0, 2.0), Vec3::new(3.0, 0.0, 1.0)), Vec4::ZERO);
    // Over a visible background, the card's image replaces its share of it.
    stage.settings.show_background = true;
    let seen = stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0));
    assert_close(seen, Vec3::splat(1.0 - reflectance) + color * reflectance, 1e-5);
    // Without the mirror there is none.
    stage.settings.ground = Some(plane(0.0, false));
    assert_close(stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0)), Vec3::ONE, 0.0);
}

#[test]
fn no_shadow_is_caught_twice() {
    let mut stage = floating_cube();
    let catcher = Material { is_shadow_catcher: true, ..lambert(Vec3::ONE) };
    stage.add(rectangle(Vec3::Y * 0.01, Vec3::Z * 9.0, Vec3::X * 9.0), catcher);
    // A second light of the same strength from above leaves half of the light in the first one's shadow.
    stage.add_light(LightKind::Directional, 0.5_f32.sqrt(), Vec3::ZERO, Vec3::NEG_Y);
    assert!((seen_at(&stage, 1.5, 0.0).w - 0.5).abs() < 1e-5);
}

#[test]
fn mirror_images_lie_over_the_shadows_on_a_catcher() {
    let color = Vec3::new(0.25, 0.5, 2.0);
    // One light whose shadow of the card falls on the floor at (0, 0, 1), and half of the light in it where there is another.
    for (integrator, others, shadow) in [
        (Integrator::Whitted, 0, 1.0),
        (Integrator::Whitted, 1, 0.5),
        (Integrator::Path, 0, 1.0),
        (Integrator::Path, 1, 0.5),
    ] {
        let mut stage = Stage::new();
        stage.settings.show_background = false;
        stage.settings.integrator = integrator;
        stage.settings.ground = Some(plane(-1e-5, true));
        stage.add(rectangle(Vec3::Y, Vec3::X * 0.4, Vec3::Y * 0.4), unlit(color));
        stage.add_light(LightKind::Directional, 2.0_f32.sqrt(), Vec3::ZERO, Vec3::new(0.0, -1.0, 1.0));
        for _ in 0..others {
            stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::NEG_Y);
        }
        let catcher = Material { is_shadow_catcher: true, double_sided: true, ..lambert(Vec3::ONE) };
        stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), catcher);
        let seen = stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0));
        // As below 45° on the ground alone
        let reflectance = 0.050_239_9;
        assert_close(seen, color * reflectance, 1e-4);
        let alpha = 1.0 - (1.0 - shadow) * (1.0 - reflectance);
        assert!((seen.w - alpha).abs() < 1e-4, "{integrator:?} {shadow}: {seen}");
    }
}

#[test]
fn a_table_hides_the_mirror_images_of_the_ground() {
    // A card above a table above the ground, whose mirror image of the card would be seen through the middle of the table.
    let reflectance = 0.050_239_9;
    let table = Material { is_shadow_catcher: true, double_sided: true, ..lambert(Vec3::ONE) };
    let fading = |alpha| Material {
        alpha_mode: AlphaMode::Blend,
        base_color: Vec4::ONE.with_w(alpha),
        ..table.clone()
    };
    for (height, catcher, share) in [
        (0.5, table.clone(), 0.0),
        (0.5, fading(0.25), 0.75),
        (0.1, table.clone(), 0.0),
        // A carpet
        (0.001, table.clone(), 1.0),
    ] {
        for integrator in [Integrator::Whitted, Integrator::Path] {
            let mut stage = Stage::new();
            stage.settings.show_background = false;
            stage.settings.integrator = integrator;
            stage.settings.ground = Some(plane(0.0, true));
            stage.add(rectangle(Vec3::Y, Vec3::X * 0.4, Vec3::Y * 0.4), unlit(Vec3::ONE));
            stage.add(rectangle(Vec3::new(0.0, height, 2.0), Vec3::Z * 1.9, Vec3::X), catcher.clone());
            let seen = stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0));
            let expected = Vec3::splat(reflectance * share);
            assert_close(seen, expected, 1e-4);
            assert!((seen.w - expected.x).abs() < 1e-4, "{height} {integrator:?}: {seen}");
        }
    }
}

#[test]
fn mirror_images_hold_no_shadows_on_catchers() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut stage = Stage::new();
        stage.settings.show_background = false;
        stage.settings.integrator = integrator;
        stage.settings.ground = Some(plane(0.0, true));
        stage.add(rectangle(Vec3::Y, Vec3::X * 0.4, Vec3::Y * 0.4), unlit(Vec3::ONE));
        // A catcher in front of the card, in the shadow of another card behind the camera
        let catcher = Material { is_shadow_catcher: true, double_sided: true, ..lambert(Vec3::ONE) };
        stage.add(rectangle(Vec3::new(0.0, 0.8, 0.2), Vec3::X * 0.1, Vec3::Y * 0.1), catcher);
        stage.add(rectangle(Vec3::new(0.0, 0.8, 3.0), Vec3::X * 0.4, Vec3::Y * 0.4), unlit(Vec3::ONE));
        stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::NEG_Z);
        let seen = stage.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.0, 1.0));
        let reflectance = 0.050_239_9;
        assert_close(seen, Vec3::splat(reflectance), 1e-4);
        assert!((seen.w - reflectance).abs() < 1e-4, "{integrator:?}: {seen}");
    }
}

#[expect(clippy::unwrap_used, reason = "a helper of tests")]
fn ground_of(scene: &Scene, up: Option<Vec3>) -> f32 {
    let view = ViewRequest { up, ..ViewRequest::default() };
    ground_below(scene, &select_all(scene, SelectedCamera::Auto), &view, false).unwrap().height
}

#[track_caller]
fn assert_height(height: f32, lowest: f32, diagonal: f32) {
    let expected = lowest - diagonal * GAP;
    assert!((height - expected).abs() < 1e-6, "{height} is not {expected}");
}

#[test]
fn the_ground_lies_just_below_the_lowest_point() {
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 1.0, 1.5)), lambert(Vec3::ONE));
    let diagonal = 14.0_f32.sqrt();
    assert_height(ground_of(&stage.scene, None), 1.0, diagonal);
    assert_height(ground_of(&stage.scene, Some(Vec3::Z)), 1.5, diagonal);
    assert_height(ground_of(&stage.scene, Some(Vec3::NEG_X * 2.0)), -1.5, diagonal);
    // Far from the origin the gap covers the rounding of coordinates.
    let mut far = Stage::new();
    far.add(cuboid(Vec3::new(0.0, 1e5, 0.0), Vec3::splat(0.5)), lambert(Vec3::ONE));
    assert!(ground_of(&far.scene, None) < 99_999.5 - 0.05);
    let empty = Scene::default();
    assert_eq!(
        ground_below(&empty, &select_all(&empty, SelectedCamera::Auto), &ViewRequest::default(), true),
        None
    );
}

#[test]
fn the_ground_lies_below_the_whole_animation() {
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::splat(0.5)), lambert(Vec3::ONE));
    let target = AnimationTarget::Translation(NodeIndex(0));
    animate(&mut stage.scene, target, &[0.0, 1.0, 0.0], &[0.0, -2.0, 0.0]);
    // From 1.5 down to −2.5.
    assert_height(ground_of(&stage.scene, None), -2.5, 18.0_f32.sqrt());
}

/// A cube of 1 m around the origin and a floor that reaches `reach` to each side.
fn cube_over_floor(height: f32, reach: f32) -> Stage {
    let mut stage = Stage::new();
    let mut cube = cuboid(Vec3::ZERO, Vec3::splat(0.5));
    // Backdrops have few of the triangles.
    cube.triangles = cube.triangles.repeat(4);
    stage.add(cube, lambert(Vec3::ONE));
    stage.add(rectangle(Vec3::Y * height, Vec3::Z * reach, Vec3::X * reach), lambert(Vec3::ONE));
    stage
}

#[test]
fn a_floor_of_its_own_lies_above_the_ground() {
    for (floor, lowest) in [(-0.6, -0.6), (-0.5, -0.5), (-0.4, -0.5), (-40.0, -0.5)] {
        assert_height(ground_of(&cube_over_floor(floor, 20.0).scene, None), lowest, 3.0_f32.sqrt());
    }
    // The gap below a floor of 4 km covers the rounding of its corners, 2⁻²⁰ of 2 km, and no ground shows through it.
    let mut wide = cube_over_floor(-0.5, 2048.0);
    assert_eq!(ground_of(&wide.scene, None), -0.5 - 1.0 / 512.0);
    wide.settings.show_background = false;
    wide.settings.ground = Some(plane(ground_of(&wide.scene, None), false));
    wide.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0));
    for distance in [3.0, 30.0, 300.0, 1500.0] {
        let seen = wide.look(Vec3::new(0.0, 1.0, 2.0), Vec3::new(distance, -0.5, 1.0));
        assert_close(seen, Vec3::splat(0.5_f32.sqrt() / std::f32::consts::PI), 1e-5);
    }
}
