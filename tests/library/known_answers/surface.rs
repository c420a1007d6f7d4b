//! Coverage and sides of surfaces.

use glam::{Vec2, Vec3, Vec4};
use rayframe::render::Integrator;
use rayframe::scene::{
    AlphaMode, Encoding, Filter, Image, ImageIndex, ImageMips, LightKind, Material, Primitive, Sampler,
    Texels, Texture, TextureIndex, TextureRef, UvTransform, mip_levels,
};

use crate::stage::{Stage, assert_close, lambert, rectangle, unlit};

fn card(z: f32, color: Vec4, alpha_mode: AlphaMode) -> (rayframe::scene::Primitive, Material) {
    let material = Material { alpha_mode, base_color: color, ..unlit(Vec3::ONE) };
    (rectangle(Vec3::Z * z, Vec3::X * 2.0, Vec3::Y * 2.0), material)
}

fn look_through(stage: &Stage) -> Vec4 {
    stage.look(Vec3::new(0.2, 0.1, 9.0), Vec3::new(0.2, 0.1, 0.0))
}

#[test]
fn blended_cards_composite_front_to_back_in_any_file_order() {
    // Front to back: 0.5 red over 0.25 green over opaque blue:
    // 0.5 · R + 0.5 · 0.25 · G + 0.5 · 0.75 · B.
    let cards = [
        card(3.0, Vec4::new(1.0, 0.0, 0.0, 0.5), AlphaMode::Blend),
        card(2.0, Vec4::new(0.0, 1.0, 0.0, 0.25), AlphaMode::Blend),
        card(1.0, Vec4::new(0.0, 0.0, 1.0, 1.0), AlphaMode::Opaque),
    ];
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let mut stage = Stage::new();
        for index in order {
            let (primitive, material) = cards[index].clone();
            stage.add(primitive, material);
        }
        assert_eq!(look_through(&stage), Vec4::new(0.5, 0.125, 0.375, 1.0));
    }
}

#[test]
fn coverage_of_blended_cards_over_nothing_is_kept() {
    // 1 − 0.5 · 0.75 = 0.625.
    let mut stage = Stage::new();
    stage.settings.show_background = false;
    for (z, alpha) in [(1.0, 0.5), (2.0, 0.25)] {
        let (primitive, material) = card(z, Vec4::new(1.0, 1.0, 1.0, alpha), AlphaMode::Blend);
        stage.add(primitive, material);
    }
    assert_eq!(look_through(&stage), Vec4::splat(0.625));
}

#[test]
fn masked_surfaces_are_opaque_or_absent() {
    for (alpha, seen) in [(0.49, 0.0), (0.5, 1.0)] {
        let mut stage = Stage::new();
        let (primitive, material) =
            card(1.0, Vec4::new(1.0, 1.0, 1.0, alpha), AlphaMode::Mask { cutoff: 0.5 });
        stage.add(primitive, material);
        assert_eq!(look_through(&stage).x, seen);
    }
}

#[test]
fn masks_at_their_cutoff_have_no_holes() {
    // Weighted sums of equal values round below them at some points.
    for alpha in [1.0, 0.5, 128.0 / 255.0] {
        let mut stage = Stage::new();
        let (primitive, material) = card(1.0, Vec4::ONE, AlphaMode::Mask { cutoff: alpha });
        let colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, alpha); 4]);
        stage.add(Primitive { colors, ..primitive }, material);
        for index in 0..400 {
            let at = Vec3::new(0.043 * (index % 20) as f32 - 0.4, 0.041 * (index / 20) as f32 - 0.4, 0.0);
            assert!(stage.look(at + Vec3::Z * 3.0, at).x > 0.99, "{alpha}: {at}");
        }
    }
}

/// A red mask, half of whose texels of a millimetre are opaque: their mean is below its cutoff. Behind it is a green wall, lit through the mask.
fn fine_mask(integrator: Integrator) -> Stage {
    let mut stage = Stage::new();
    (stage.settings.integrator, stage.settings.samples) = (integrator, 1024);
    let [open, opaque] = [[255, 255, 255, 0], [255; 4]];
    let texels = Texels::Rgba8(vec![open, opaque, opaque, open]);
    let image = Image { name: None, width: 2, height: 2, texels };
    let mut mips = ImageMips::default();
    mips.set(Encoding::CoveredSrgb, mip_levels(&image, Encoding::CoveredSrgb).into());
    stage.scene.images.push(image);
    stage.scene.mips.push(mips);
    let sampler = Sampler { minify: Filter::Nearest, magnify: Filter::Nearest, ..Sampler::default() };
    stage.scene.textures.push(Texture { name: None, image: ImageIndex(0), sampler });
    let texture = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
    let (mut mask, material) = card(5.0, Vec4::new(1.0, 0.0, 0.0, 1.0), AlphaMode::Mask { cutoff: 0.6 });
    mask.uvs = vec![mask.positions.iter().map(|at| Vec2::new(at.x, at.y) * 500.0).collect()];
    stage.add(mask, Material { base_color_texture: Some(texture), ..material });
    stage.add(rectangle(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0), lambert(Vec3::Y));
    stage.add_light(LightKind::Directional, std::f32::consts::PI, Vec3::ZERO, Vec3::NEG_Z);
    stage
}

#[test]
fn masks_are_read_in_the_full_image_by_camera_and_shadow_rays() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let stage = fine_mask(integrator);
        // A sample covers dozens of texels.
        let mask = stage.look(Vec3::Z * 9.0, Vec3::ZERO);
        assert!((mask.x - 0.5).abs() < 0.05, "{integrator:?}: {mask}");
        let shadow = stage.look(Vec3::Z * 4.5, Vec3::ZERO);
        assert!(shadow.x == 0.0 && (shadow.y - 0.5).abs() < 0.05, "{integrator:?}: {shadow}");
    }
}

#[test]
fn opaque_materials_ignore_alpha() {
    let mut stage = Stage::new();
    let (primitive, material) = card(1.0, Vec4::new(1.0, 1.0, 1.0, 0.0), AlphaMode::Opaque);
    stage.add(primitive, material);
    assert_eq!(look_through(&stage), Vec4::ONE);
}

#[test]
fn blended_cards_dim_light_without_colouring_it() {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0), lambert(Vec3::ONE));
    let (primitive, material) = card(1.0, Vec4::new(1.0, 0.0, 0.0, 0.25), AlphaMode::Blend);
    stage.add(primitive, material);
    stage.add_light(LightKind::Directional, std::f32::consts::PI, Vec3::ZERO, Vec3::NEG_Z);
    // Seen from below the card, the wall receives 1 − 0.25 of the light in all channels.
    assert_close(stage.look(Vec3::new(0.5, 0.0, 0.5), Vec3::ZERO), Vec3::splat(0.75), 1e-5);
}

#[test]
fn single_sided_backs_are_invisible_but_cast_shadows() {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0), lambert(Vec3::ONE));
    // This one faces away from the viewer and from the light.
    let back = rectangle(Vec3::Z, Vec3::Y * 0.5, Vec3::X * 0.5);
    stage.add(back, lambert(Vec3::ONE));
    stage.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::NEG_Z);
    let through_the_back = stage.look(Vec3::Z * 5.0, Vec3::ZERO);
    assert_close(through_the_back, Vec3::ZERO, 0.0);
    let beside = stage.look(Vec3::new(3.0, 0.0, 5.0), Vec3::new(3.0, 0.0, 0.0));
    assert_close(beside, Vec3::splat(3.0 / std::f32::consts::PI), 1e-5);
}

#[test]
fn double_sided_backs_are_lit_from_their_own_side() {
    let mut stage = Stage::new();
    let material = Material { double_sided: true, ..lambert(Vec3::ONE) };
    stage.add(rectangle(Vec3::ZERO, Vec3::Y, Vec3::X), material);
    stage.add_light(LightKind::Directional, std::f32::consts::PI, Vec3::ZERO, Vec3::NEG_Z);
    assert_close(stage.look(Vec3::new(0.1, 0.2, 5.0), Vec3::ZERO), Vec3::ONE, 1e-5);
    assert_close(stage.look(Vec3::new(0.1, 0.2, -5.0), Vec3::ZERO), Vec3::ZERO, 0.0);
}

#[test]
fn emission_fades_with_coverage() {
    let mut stage = Stage::new();
    stage.settings.show_background = false;
    let material = Material {
        base_color: Vec4::new(0.0, 0.0, 0.0, 0.5),
        emissive: Vec3::new(4.0, 2.0, 1.0),
        alpha_mode: AlphaMode::Blend,
        ..lambert(Vec3::ZERO)
    };
    stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y), material);
    let seen = stage.look(Vec3::new(0.1, 0.2, 5.0), Vec3::ZERO);
    assert_eq!(seen, Vec4::new(2.0, 1.0, 0.5, 0.5));
}
