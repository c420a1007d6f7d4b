//! Light of emissive surfaces through clear thin walls, by the path integrator: shadow rays and sampled rays decide alike which walls are clear.

use glam::{Vec3, Vec4};
use rayframe::scene::{
    AlphaMode, Anisotropy, Environment, EnvironmentImage, EnvironmentMap, Material, Volume,
};

use super::glass::glass;
use super::path::{floor, middle, stage};
use crate::stage::{assert_close, cuboid, lambert, rectangle};

/// The radiance of a floor below a lamp, with a pane between them and a medium of index `medium` around all, if any.
fn floor_below(pane: Option<Material>, medium: Option<f32>) -> Vec3 {
    floor_below_by(4096, pane, medium)
}

fn floor_below_by(samples: u32, pane: Option<Material>, medium: Option<f32>) -> Vec3 {
    let mut stage = stage(samples);
    stage.add(floor(3.0), lambert(Vec3::splat(0.5)));
    let lamp = Material { emissive: Vec3::splat(10.0), ..lambert(Vec3::ZERO) };
    stage.add(rectangle(Vec3::Y * 2.0, Vec3::X * 0.3, Vec3::Z * 0.3), lamp);
    if let Some(pane) = pane {
        stage.add(rectangle(Vec3::Y, Vec3::Z * 3.0, Vec3::X * 3.0), Material { double_sided: true, ..pane });
    }
    if let Some(ior) = medium {
        stage.add(cuboid(Vec3::ZERO, Vec3::splat(8.0)), glass(ior, Some(Volume::CLEAR)));
    }
    middle(&stage).truncate()
}

/// A pane as strongly anisotropic as `strength`.
fn pane(ior: f32, roughness: f32, strength: f32) -> Material {
    let anisotropy = Anisotropy { strength, rotation_radians: 0.3, texture: None };
    Material { roughness, anisotropy: (strength > 0.0).then_some(anisotropy), ..glass(ior, None) }
}

#[test]
fn walls_in_a_medium_of_their_index_are_not_there() {
    for (ior, roughness, strength) in [(1.33, 0.5, 0.0), (1.33, 1.0, 0.7), (1.5, 0.0, 0.0)] {
        let open = floor_below(None, Some(ior));
        let walled = floor_below(Some(pane(ior, roughness, strength)), Some(ior));
        assert_close(walled.extend(1.0), open, 0.03 * open.x);
    }
    // In vacuum
    let open = floor_below(None, None);
    for (roughness, strength) in [(0.7, 0.0), (0.0, 0.5), (0.4, 1.0)] {
        let walled = floor_below(Some(pane(1.0, roughness, strength)), None);
        assert_close(walled.extend(1.0), open, 0.02 * open.x);
    }
}

#[test]
fn walls_of_nearly_the_index_around_them_let_nearly_all_light_pass_once() {
    // Their surfaces reflect 0.5 % at most towards the lamp.
    for (ior, roughness, strength, medium) in [
        (1.5, 0.1, 0.0, Some(1.33)),
        (1.33, 0.3, 0.0, Some(1.5)),
        (1.05, 0.1, 0.3, None),
        (1.1, 0.1, 0.2, None),
    ] {
        // Few paths find the lamp through a rough pane.
        let open = floor_below(None, medium);
        let walled = floor_below_by(65_536, Some(pane(ior, roughness, strength)), medium);
        assert!(walled.x > 0.9 * open.x && walled.x < 1.06 * open.x, "{ior} in {medium:?}: {walled} {open}");
    }
}

#[test]
fn closed_shells_of_white_glass_return_what_they_receive() {
    // What the near wall lets through comes from inside: rays pass the backs of single-sided walls, and those of double-sided ones scatter it. Paths aim
    // shadow rays at environments that are not uniform.
    let (width, height) = (64, 32);
    let pixel = |index: u32| [if index / width < height / 2 { 1.0 } else { 0.98 }; 3];
    let pixels = (0..width * height).map(pixel).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    let nearly_uniform = EnvironmentMap::new("sides.hdr".as_ref(), image, 0.0).unwrap();
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: Vec4::new(1.0, 1.0, 1.0, 0.5),
        double_sided: false,
        ..lambert(Vec3::ONE)
    };
    let glass = |roughness: f32, double_sided: bool| Material { double_sided, ..pane(1.5, roughness, 0.0) };
    for shell in [glass(0.0, false), glass(0.5, false), glass(1.0, false), glass(0.5, true), veil] {
        let mut stage = stage(4096);
        stage.environment = Environment::Map(nearly_uniform.clone());
        stage.add(cuboid(Vec3::ZERO, Vec3::ONE), shell.clone());
        let seen = middle(&stage).truncate();
        assert!((seen.x - 0.99).abs() < 0.012, "{shell:?}: {seen}");
    }
}
