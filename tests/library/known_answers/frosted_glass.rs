//! What stands behind frosted glass and paper.

use glam::{Vec3, Vec4};
use rayframe::film::PixelWindow;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{
    AlphaMode, Anisotropy, ClearCoat, DiffuseTransmission, Environment, Material, Primitive, Projection,
    Transmission, Volume,
};
use scene_builder::shapes::TriangleMesh;

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

/// Half the width of what is seen: it hides next to nothing of the environment from the wall.
const HALF_WIDTH: f32 = 0.02;

/// What a camera sees in uniform light where something small stands before a wide wall of `color`.
fn before_a_wall(color: Vec3, seen: (Primitive, Material), edit: impl Fn(&mut Stage)) -> Vec4 {
    let mut stage = super::path::stage(4096);
    stage.settings.integrator = Integrator::Whitted;
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.add(rectangle(Vec3::NEG_Z, Vec3::X * 500.0, Vec3::Y * 500.0), lambert(color));
    stage.add(seen.0, seen.1);
    edit(&mut stage);
    stage.look(Vec3::new(0.2, 0.1, 1.0), Vec3::ZERO)
}

fn sheet() -> Primitive {
    rectangle(Vec3::ZERO, Vec3::X * HALF_WIDTH, Vec3::Y * HALF_WIDTH)
}

pub(super) fn sphere(radius: f32) -> Primitive {
    let TriangleMesh { positions, normals, indices, .. } = scene_builder::shapes::ico_sphere(radius, 3);
    let triangles = indices.chunks(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
    Primitive { positions, triangles, normals: Some(normals), ..sheet() }
}

pub(super) fn frosted(roughness: f32) -> Material {
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    Material { roughness, ior: 1.5, transmission, double_sided: true, ..lambert(Vec3::ONE) }
}

pub(super) const WALL: Vec3 = Vec3::new(0.9, 0.4, 0.0);

#[test]
fn walls_show_through_frosted_panes() {
    for roughness in [0.05, 0.3, 0.6] {
        for env_samples in [EnvSamples::Auto, EnvSamples::Fixed(1)] {
            let see = |color| {
                before_a_wall(color, (sheet(), frosted(roughness)), |stage| {
                    stage.settings.env_samples = env_samples;
                })
            };
            // What the pane mirrors, and all light of a white wall: a lossless pane in uniform light is invisible.
            let (mirrored, all) = (see(Vec3::ZERO).truncate(), see(Vec3::ONE));
            assert!((0.03..0.1).contains(&mirrored.x), "{roughness}: {mirrored}");
            assert_close(all, Vec3::ONE, 0.01);
            assert_close(see(WALL), mirrored + (Vec3::ONE - mirrored) * WALL, 0.01);
        }
    }
}

#[test]
fn walls_show_through_coated_frosted_panes_as_paths_see_them() {
    let coat = ClearCoat {
        factor: 1.0,
        texture: None,
        roughness: 0.0,
        roughness_texture: None,
        normal_texture: None,
    };
    for roughness in [0.3, 0.6] {
        let see = |integrator| {
            let coated = Material { clear_coat: Some(coat), ..frosted(roughness) };
            before_a_wall(WALL, (sheet(), coated), |stage| stage.settings.integrator = integrator)
        };
        assert_close(see(Integrator::Whitted), see(Integrator::Path).truncate(), 0.01);
    }
}

#[test]
fn a_blended_frosted_pane_covers_its_share_of_the_wall() {
    let see = |alpha: f32, alpha_mode| {
        let color = Vec3::new(0.8, 0.9, 1.0).extend(alpha);
        let pane = Material { base_color: color, alpha_mode, ..frosted(0.4) };
        before_a_wall(WALL, (sheet(), pane), |_| ()).truncate()
    };
    let pane = see(1.0, AlphaMode::Opaque);
    assert!((pane - WALL).abs().max_element() > 0.03, "{pane}");
    for alpha in [0.25, 0.75] {
        let blended = see(alpha, AlphaMode::Blend);
        let expected = pane * alpha + WALL * (1.0 - alpha);
        assert!((blended - expected).abs().max_element() < 0.01, "{alpha}: {blended} instead of {expected}");
    }
}

#[test]
fn walls_show_through_frosted_slabs_as_paths_see_them() {
    let volume = Volume { thickness: 0.01, ..Volume::CLEAR };
    for roughness in [0.2, 0.5] {
        let see = |integrator| {
            let slab = cuboid(Vec3::ZERO, Vec3::new(HALF_WIDTH, HALF_WIDTH, 0.003));
            let material = Material { volume: Some(volume), ..frosted(roughness) };
            before_a_wall(WALL, (slab, material), |stage| {
                stage.settings.integrator = integrator;
                stage.settings.max_depth = 12;
            })
        };
        assert_close(see(Integrator::Whitted), see(Integrator::Path).truncate(), 0.04);
    }
}

#[test]
fn walls_show_through_paper() {
    let color = Vec3::new(0.5, 0.8, 1.0);
    let through = DiffuseTransmission { factor: 0.75, texture: None, color, color_texture: None };
    let paper =
        Material { diffuse_transmission: Some(through), double_sided: true, ..lambert(Vec3::splat(0.8)) };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let seen = before_a_wall(WALL, (sheet(), paper.clone()), |stage| {
            stage.settings.integrator = integrator;
        });
        assert_close(seen, color * WALL * 0.75 + 0.8 * 0.25, 0.01);
    }
}

#[test]
fn frosted_slabs_blur_the_environment_as_paths_do() {
    let light = super::reflection::slanted_light().unwrap();
    for ior in [1.15, 1.33, 1.5] {
        let volume = Some(Volume { thickness: 0.01, ..Volume::CLEAR });
        let material = Material { volume, ior, ..frosted(0.5) };
        let see = |integrator, side: f32| {
            let mut stage = super::path::stage(1024);
            (stage.settings.integrator, stage.settings.max_depth) = (integrator, 12);
            stage.environment = light.clone();
            stage.add(cuboid(Vec3::ZERO, Vec3::new(1.0, 0.01, 1.0)), material.clone());
            stage.look(Vec3::new(side, 1.0, 0.0), Vec3::ZERO)
        };
        for side in [-1.0, 0.0, 1.0] {
            assert_close(see(Integrator::Whitted, side), see(Integrator::Path, side).truncate(), 0.06);
        }
    }
}

#[test]
fn frosted_volumes_colour_what_no_shadow_ray_follows() {
    // The colour after the thickness of the slab, which a lookup without shadow rays crosses nearly straight.
    let color = Vec3::new(0.9, 0.5, 0.2);
    let volume = Volume { thickness: 0.1, attenuation_distance: 0.1, attenuation_color: color };
    let material = Material { volume: Some(volume), ..frosted(0.6) };
    let see = |integrator, volume: Volume| {
        let mut stage = super::path::stage(1024);
        (stage.settings.integrator, stage.settings.max_depth) = (integrator, 12);
        stage.settings.env_samples = EnvSamples::Fixed(0);
        stage.environment = Environment::Constant(Vec3::ONE);
        let material = Material { volume: Some(volume), ..material.clone() };
        stage.add(cuboid(Vec3::ZERO, Vec3::new(2.0, 0.05, 2.0)), material);
        stage.look(Vec3::new(0.0, 1.0, 0.01), Vec3::ZERO)
    };
    let clear = see(Integrator::Whitted, Volume::CLEAR);
    assert_close(clear, Vec3::ONE, 0.01);
    let seen = see(Integrator::Whitted, volume);
    assert_close(seen, 0.04 + 0.96 * color, 0.02);
    assert_close(seen, see(Integrator::Path, volume).truncate(), 0.1);
}

#[test]
fn looked_up_light_inside_a_volume_crosses_it() {
    // Camera and wall in water that is open or two metres deep before the wall, in light that is looked up without shadow rays.
    let color = Vec3::new(0.9, 0.5, 0.2);
    let volume = Volume { thickness: 1.0, attenuation_distance: 2.0, attenuation_color: color };
    let water = Material { volume: Some(volume), ior: 1.0, roughness: 0.0, ..frosted(0.0) };
    let see = |is_closed: bool| {
        let mut stage = super::path::stage(4);
        stage.settings.integrator = Integrator::Whitted;
        stage.settings.env_samples = EnvSamples::Fixed(0);
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.add(rectangle(Vec3::ZERO, Vec3::X * 0.5, Vec3::Y * 0.5), lambert(Vec3::ONE));
        if is_closed {
            stage.add(cuboid(Vec3::Z * 0.5, Vec3::new(4.0, 4.0, 1.5)), water.clone());
        }
        stage.look(Vec3::new(0.0, 0.01, 1.0), Vec3::ZERO)
    };
    assert_close(see(false), Vec3::ONE, 0.01);
    // One metre to the camera.
    assert_close(see(true), color * color.powf(0.5), 0.01);
}

#[test]
fn the_deepest_frosted_glass_looks_the_environment_up() {
    let mut stage = super::path::stage(16);
    (stage.settings.integrator, stage.settings.max_depth) = (Integrator::Whitted, 0);
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.add(sheet(), frosted(0.5));
    assert_close(stage.look(Vec3::Z, Vec3::ZERO), Vec3::ONE, 0.01);
}

/// A frosted volume in `environment`, seen by Whitted's tree, with glossy samples or none.
fn volume(shape: Primitive, material: Material, environment: &Environment, glossy_samples: u32) -> Stage {
    let mut stage = super::path::stage(4096);
    (stage.settings.integrator, stage.settings.max_depth) = (Integrator::Whitted, 32);
    stage.settings.glossy_samples = glossy_samples;
    stage.environment = environment.clone();
    stage.add(shape, Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..material });
    stage
}

#[test]
fn lossless_frosted_volumes_are_invisible_in_uniform_light() {
    // Light that facets reflect within stays there until it leaves.
    for (roughness, glossy_samples, tolerance) in [
        (0.3, 0, 0.02),
        (0.6, 0, 0.06),
        (0.8, 0, 0.015),
        (1.0, 0, 0.015),
        (0.3, 1, 0.015),
        (0.6, 1, 0.015),
        (1.0, 1, 0.015),
    ] {
        for shape in [cuboid(Vec3::ZERO, Vec3::splat(0.5)), sphere(0.5)] {
            let uniform = Environment::Constant(Vec3::ONE);
            let stage = volume(shape, frosted(roughness), &uniform, glossy_samples);
            assert_close(stage.look(Vec3::new(0.3, 0.5, 1.0), Vec3::ZERO), Vec3::ONE, tolerance);
        }
    }
}

#[test]
fn smoother_volumes_lose_little_light_and_lookups_without_shadows_none() {
    // `docs/shading.md` has the first two numbers.
    for (roughness, env_samples, expected) in [
        (0.5, EnvSamples::Auto, 0.98),
        (0.6, EnvSamples::Auto, 0.96),
        (0.6, EnvSamples::Fixed(0), 1.0),
        (1.0, EnvSamples::Fixed(0), 1.0),
    ] {
        let mut stage = volume(sphere(0.5), frosted(roughness), &Environment::Constant(Vec3::ONE), 0);
        stage.settings.env_samples = env_samples;
        stage.settings.resolution = (24, 24);
        stage.settings.window = PixelWindow::full(24, 24);
        stage.settings.samples = 64;
        stage.projection = Projection::Orthographic { x_mag: 0.35, y_mag: 0.35, z_near: 0.01, z_far: 10.0 };
        let film = stage.render(Vec3::new(0.3, 0.5, 2.0), Vec3::ZERO);
        let mean = film.pixels.iter().map(|pixel| pixel[0]).sum::<f32>() / film.pixels.len() as f32;
        assert!((mean - expected).abs() < 0.01, "{roughness}: {mean} instead of {expected}");
    }
}

#[test]
fn facets_that_hardly_bend_light_let_it_pass() {
    let anisotropy = Some(Anisotropy { strength: 0.5, rotation_radians: 0.0, texture: None });
    for (ior, anisotropy) in [(1.015, None), (1.015, anisotropy), (1.5, anisotropy)] {
        for glossy_samples in [0, 1] {
            let (uniform, material) =
                (Environment::Constant(Vec3::ONE), Material { ior, anisotropy, ..frosted(0.9) });
            let stage = volume(sphere(0.5), material, &uniform, glossy_samples);
            assert_close(stage.look(Vec3::new(0.3, 0.5, 1.0), Vec3::ZERO), Vec3::ONE, 0.02);
        }
    }
}

#[test]
fn dispersive_frosted_volumes_are_invisible_in_uniform_light() {
    for glossy_samples in [0, 1] {
        let material = Material { dispersion: 5.0, ..frosted(0.9) };
        let stage = volume(sphere(0.5), material, &Environment::Constant(Vec3::ONE), glossy_samples);
        assert_close(stage.look(Vec3::new(0.3, 0.5, 1.0), Vec3::ZERO), Vec3::ONE, 0.03);
    }
}

#[test]
fn rough_volumes_show_the_side_of_the_light_as_paths_do() {
    let light = super::reflection::slanted_light().unwrap();
    for roughness in [0.7, 1.0] {
        for side in [-1.0, 1.0] {
            let look = |stage: &Stage| stage.look(Vec3::new(side, 0.1, 0.0), Vec3::ZERO);
            let [plain, glossy] =
                [0, 1].map(|samples| volume(sphere(0.5), frosted(roughness), &light, samples));
            let mut paths = volume(sphere(0.5), frosted(roughness), &light, 0);
            paths.settings.integrator = Integrator::Path;
            let by_paths = look(&paths).truncate();
            assert_close(look(&plain), by_paths, 0.09);
            assert_close(look(&glossy), by_paths, 0.02);
        }
    }
}

#[test]
fn what_stands_behind_frosted_glass_shows_in_the_dark_and_in_closed_spaces() {
    for volume in [None, Some(Volume { thickness: 1.0, ..Volume::CLEAR })] {
        let pane = match volume {
            None => rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0),
            Some(_) => cuboid(Vec3::ZERO, Vec3::new(9.0, 9.0, 0.01)),
        };
        let see = |integrator, roughness, around: &(Primitive, Material), environment| {
            let mut stage = super::path::stage(4096);
            (stage.settings.integrator, stage.settings.max_depth) = (integrator, 12);
            stage.environment = environment;
            stage.add(around.0.clone(), around.1.clone());
            stage.add(pane.clone(), Material { volume, ..frosted(roughness) });
            stage.look(Vec3::new(0.3, 0.2, 4.0), Vec3::ZERO).truncate()
        };
        let wall = (rectangle(Vec3::NEG_Z, Vec3::X * 50.0, Vec3::Y * 50.0), unlit(WALL));
        let enclosure =
            (cuboid(Vec3::ZERO, Vec3::splat(10.0)), Material { double_sided: true, ..unlit(WALL) });
        for roughness in [0.2, 0.5, 0.9] {
            // Whitted's tree looks up what a closed space hides where light is reflected.
            for (around, environment, tolerance) in [
                (&wall, Environment::None, 0.02),
                (&enclosure, Environment::Constant(Vec3::splat(0.5)), 0.06),
            ] {
                let [whitted, path] = [Integrator::Whitted, Integrator::Path]
                    .map(|integrator| see(integrator, roughness, around, environment.clone()));
                let off = (whitted - path).abs().max_element();
                assert!(off < tolerance, "{roughness}, {environment:?}: {whitted} instead of {path}");
            }
        }
    }
}

#[test]
fn lossless_frosted_volumes_are_invisible_in_a_bright_box_without_an_environment() {
    for roughness in [0.2, 0.39, 0.41, 0.5, 0.6, 0.8] {
        let mut stage = super::path::stage(4096);
        (stage.settings.integrator, stage.settings.max_depth) = (Integrator::Whitted, 32);
        let glass =
            Material { volume: Some(Volume { thickness: 1.0, ..Volume::CLEAR }), ..frosted(roughness) };
        stage.add(sphere(1.0), glass);
        let walls = cuboid(Vec3::ZERO, Vec3::splat(10.0));
        stage.add(walls, Material { double_sided: true, ..unlit(Vec3::ONE) });
        for x in [0.0, 0.7] {
            // From outside, and from inside, where the far side reflects totally
            let outside = stage.look(Vec3::new(x, 0.0, 4.0), Vec3::X * x).x;
            let eye = Vec3::new(x, 0.1, 0.2);
            let inside = stage.look(eye, eye - Vec3::Z + Vec3::X * 0.4).x;
            let least = if roughness < 0.3 { 0.75 } else { 0.98 };
            assert!((0.94..1.01).contains(&outside), "{roughness}, {x}: {outside}");
            assert!((least..1.03).contains(&inside), "{roughness}, {x}: {inside}");
        }
    }
}

#[test]
fn the_roughest_panes_show_no_edges_of_what_stands_behind_them() {
    let see = |integrator, x: f32| {
        let mut stage = super::path::stage(4096);
        (stage.settings.integrator, stage.settings.max_depth) = (integrator, 4);
        let half_wall = rectangle(Vec3::new(-50.0, 0.0, -1.0), Vec3::X * 50.0, Vec3::Y * 50.0);
        stage.add(half_wall, unlit(Vec3::ONE));
        stage.add(sheet(), frosted(1.0));
        stage.look(Vec3::new(x, 0.0, 1.0), Vec3::X * x).x
    };
    for x in [-0.01, 0.01] {
        let [whitted, path] = [Integrator::Whitted, Integrator::Path].map(|integrator| see(integrator, x));
        assert!((whitted - path).abs() < 0.03, "{x}: {whitted} instead of {path}");
    }
}
