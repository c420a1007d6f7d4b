//! Minified textures, environments with another background, and shadow catchers.

use glam::{Vec2, Vec3, Vec4};
use rayframe::integrator::Integrator;
use rayframe::scene::{
    AlphaMode, ComposedEnvironment, Encoding, Environment, Ground, Image, ImageIndex, ImageMips, LightKind,
    Material, Sampler, Specular, Texels, Texture, TextureIndex, TextureRef, Transmission, UvTransform,
    Volume, mip_levels,
};

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

/// A floor of 1 km with a mipmapped texture of black and white squares of 0.5 m.
fn chequered_floor() -> Stage {
    let mut stage = Stage::new();
    let texels = Texels::Rgba8(vec![[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]]);
    let image = Image { name: None, width: 2, height: 2, texels };
    let mut mips = ImageMips::default();
    mips.set(Encoding::Srgb, mip_levels(&image, Encoding::Srgb).into());
    stage.scene.images.push(image);
    stage.scene.mips.push(mips);
    stage.scene.textures.push(Texture { name: None, image: ImageIndex(0), sampler: Sampler::default() });
    let texture = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
    let mut floor = rectangle(Vec3::ZERO, Vec3::Z * 500.0, Vec3::X * 500.0);
    floor.uvs = vec![floor.positions.iter().map(|position| Vec2::new(position.x, position.z)).collect()];
    let material = Material { base_color_texture: Some(texture), ..unlit(Vec3::ONE) };
    stage.add(floor, material);
    stage.projection = rayframe::scene::Projection::Perspective {
        fov_y_radians: 0.01,
        aspect_ratio: None,
        z_near: 0.0,
        z_far: None,
    };
    stage
}

#[test]
fn a_chequered_floor_fades_to_its_mean_towards_the_horizon() {
    // A pixel of 0.01 at distance d covers 0.01 d across and 0.01 d · d / h along, from height h = 1. From 30 m on that is more
    // than nine squares along; a point sample would return 0 or 1.
    let stage = chequered_floor();
    for distance in [30.0, 60.0, 100.0, 200.0, 400.0] {
        for aside in [0.0, 0.13, 0.31] {
            let eye = Vec3::new(aside, 1.0, distance);
            let seen = stage.look(eye, Vec3::new(aside, 0.0, 0.2));
            assert!((seen.x - 0.5).abs() < 0.12, "{distance} {aside}: {seen}");
        }
    }
    // From 200 m on it covers four squares across as well, and only the mean remains.
    let far = stage.look(Vec3::new(0.13, 1.0, 400.0), Vec3::new(0.13, 0.0, 0.2));
    assert_close(far, Vec3::splat(0.503), 0.01);
    // Close to the camera the squares are resolved: the centres of a white and of a black one.
    for (x, z, expected) in [(0.75, 0.25, 1.0), (0.25, 0.25, 0.0), (0.25, 0.75, 1.0)] {
        let seen = stage.look(Vec3::new(x, 1.0, z + 0.01), Vec3::new(x, 0.0, z));
        assert_close(seen, Vec3::splat(expected), 0.01);
    }
}

#[test]
fn mirrors_and_windows_minify_textures_by_the_length_of_the_path() {
    // A flat mirror 1 m above a chequered floor shows it from 1 + 2 + 2 m, hardly blurrier than from 5 m directly.
    let mut stage = chequered_floor();
    let direct = stage.look(Vec3::new(0.5, 5.0, 0.25), Vec3::new(0.5, 0.0, 0.26));
    let mirror = Material { metallic: 1.0, roughness: 0.0, double_sided: true, ..Material::default() };
    stage.add(rectangle(Vec3::Y * 4.0, Vec3::X, Vec3::Z), mirror);
    // The eye lies as far above the floor as its mirror image would above the mirror: 3 + 1 + 1 up, 4 down.
    let seen = stage.look(Vec3::new(0.5, 3.0, 0.246), Vec3::new(0.5, 4.0, 0.248));
    assert_close(seen, direct.truncate(), 0.05);
}

#[test]
fn glass_of_index_zero_shows_textures_sharp() {
    // An index of 0 reflects the specular colour, here black, and does not refract, so ray differentials do not change.
    let mut stage = chequered_floor();
    let glass = Material {
        metallic: 0.0,
        roughness: 0.0,
        ior: 0.0,
        specular: Some(Specular { factor: 0.0, texture: None, color: Vec3::ONE, color_texture: None }),
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        volume: Some(Volume::CLEAR),
        ..Material::default()
    };
    stage.add(cuboid(Vec3::Y * 0.5, Vec3::new(2.0, 0.1, 2.0)), glass);
    for (x, expected) in [(0.75, 1.0), (0.25, 0.0)] {
        let seen = stage.look(Vec3::new(x, 1.0, 0.27), Vec3::new(x, 0.0, 0.25));
        assert_close(seen, Vec3::splat(expected), 0.01);
    }
}

fn composed(light: Environment, intensity: f32, background: Option<Environment>) -> Environment {
    Environment::Composed(Box::new(ComposedEnvironment { light, intensity, background }))
}

#[test]
fn the_background_is_visible_and_does_not_light() {
    let white = || Environment::Constant(Vec3::ONE);
    let green = || Some(Environment::Constant(Vec3::Y));
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y), lambert(Vec3::splat(0.5)));
    stage.environment = composed(white(), 0.25, green());
    // The card reflects half of the environment's 0.25; beside the card is the background.
    assert_close(stage.look(Vec3::Z * 3.0, Vec3::ZERO), Vec3::splat(0.125), 1e-6);
    assert_close(stage.look(Vec3::new(3.0, 0.0, 3.0), Vec3::X * 3.0), Vec3::Y, 0.0);
    stage.environment = composed(white(), 0.25, None);
    assert_close(stage.look(Vec3::new(3.0, 0.0, 3.0), Vec3::X * 3.0), Vec3::splat(0.25), 0.0);
    // A mirror shows the environment that lights it.
    let mut stage = Stage::new();
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..Material::default() };
    stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y), mirror);
    stage.environment = composed(white(), 0.25, green());
    assert_close(stage.look(Vec3::Z * 3.0, Vec3::ZERO), Vec3::splat(0.25), 1e-5);
}

/// A shadow catcher under two lights straight above, of three units and one, and a card that occludes one of them.
fn catcher(card: Material) -> Stage {
    catcher_on(lambert(Vec3::ONE), card)
}

/// The same on a floor of this material.
fn catcher_on(floor: Material, card: Material) -> Stage {
    let mut stage = Stage::new();
    stage.settings.show_background = false;
    let floor = Material { is_shadow_catcher: true, ..floor };
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), floor);
    stage.add(rectangle(Vec3::new(0.0, 2.0, 0.0), Vec3::Z * 0.5, Vec3::X * 0.5), card);
    stage.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::NEG_Y);
    // cos 60° = 1/2 of two units is one.
    stage.add_light(LightKind::Directional, 2.0, Vec3::ZERO, Vec3::new(-3_f32.sqrt(), -1.0, 0.0));
    stage
}

fn look_aslant(stage: &Stage, x: f32) -> Vec4 {
    stage.look(Vec3::new(x, 1.0, 4.0), Vec3::new(x, 0.0, 0.0))
}

#[test]
fn a_catcher_is_as_opaque_as_its_shadows() {
    let stage = catcher(Material { double_sided: true, ..lambert(Vec3::ONE) });
    // Below the card, three of four units are occluded; 2 · √3 m beside it, one unit; elsewhere none.
    assert_eq!(look_aslant(&stage, 0.0), Vec4::new(0.0, 0.0, 0.0, 0.75));
    assert!((look_aslant(&stage, -2.0 * 3_f32.sqrt()).w - 0.25).abs() < 1e-5);
    assert_eq!(look_aslant(&stage, 3.0), Vec4::ZERO);
    // From below, the catcher faces no light and is transparent.
    assert_eq!(stage.look(Vec3::new(3.0, -2.0, 1.0), Vec3::new(3.0, 0.0, 0.0)), Vec4::ZERO);
}

#[test]
fn shadows_on_a_catcher_darken_surfaces_below_it() {
    let mut stage = catcher(Material { double_sided: true, ..lambert(Vec3::ONE) });
    stage.settings.show_background = true;
    stage.environment = composed(Environment::None, 1.0, Some(Environment::Constant(Vec3::ONE)));
    assert_close(look_aslant(&stage, 0.0), Vec3::splat(0.25), 1e-6);
    assert_close(look_aslant(&stage, 3.0), Vec3::ONE, 0.0);
    // A white object below the catcher is lit through it, as it casts no shadow: 3 + 1 units over π.
    stage.environment = Environment::None;
    stage.add(rectangle(Vec3::NEG_Y * 0.5, Vec3::Z * 9.0, Vec3::X * 9.0), lambert(Vec3::ONE));
    assert_close(look_aslant(&stage, 3.0), Vec3::splat(4.0 / std::f32::consts::PI), 1e-4);
}

#[test]
fn half_covered_cards_cast_half_shadows_on_a_catcher() {
    let half = Material {
        base_color: Vec4::new(1.0, 1.0, 1.0, 0.5),
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..lambert(Vec3::ONE)
    };
    let seen = look_aslant(&catcher(half), 0.0);
    assert!((seen.w - 0.375).abs() < 1e-5, "{seen}");
}

#[test]
fn a_catcher_catches_as_much_as_it_covers() {
    let card = Material { double_sided: true, ..lambert(Vec3::ONE) };
    let floor = |alpha: f32, alpha_mode| Material {
        base_color: Vec4::new(1.0, 1.0, 1.0, alpha),
        alpha_mode,
        ..lambert(Vec3::ONE)
    };
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        // Of the 0.75 below the card
        for (alpha, alpha_mode, caught) in [
            (0.4, AlphaMode::Opaque, 0.75),
            (0.4, AlphaMode::Blend, 0.3),
            (0.0, AlphaMode::Blend, 0.0),
            (0.6, mask, 0.75),
            (0.4, mask, 0.0),
        ] {
            let mut stage = catcher_on(floor(alpha, alpha_mode), card.clone());
            stage.settings.integrator = integrator;
            let seen = look_aslant(&stage, 0.0);
            assert!((seen.w - caught).abs() < 1e-5, "{alpha} {alpha_mode:?}: {seen}");
            // The ground below it catches the rest: together they are one floor.
            stage.settings.ground = Some(Ground { up: Vec3::Y, height: -1e-4, is_mirror: false });
            let seen = look_aslant(&stage, 0.0);
            assert!((seen.w - 0.75).abs() < 1e-5, "{alpha} {alpha_mode:?} over the ground: {seen}");
        }
    }
}
