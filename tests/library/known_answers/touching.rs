//! Surfaces that lie on each other.

use glam::{Vec2, Vec3};
use rayframe::integrator::Integrator;
use rayframe::scene::{
    DiffuseTransmission, Encoding, Environment, Image, ImageIndex, ImageMips, LightKind, Material, Primitive,
    Sampler, Texels, Texture, TextureIndex, TextureRef, Transmission, UvTransform, Volume, mip_levels,
};

use super::path::floor;
use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle, unlit};

const INTEGRATORS: [Integrator; 2] = [Integrator::Whitted, Integrator::Path];

/// A stage of one narrow pixel.
fn stage(integrator: Integrator, samples: u32) -> Stage {
    let mut stage = super::path::stage(samples);
    stage.settings.integrator = integrator;
    stage
}

/// Adds two surfaces in either order.
fn add(stage: &mut Stage, surfaces: [(Primitive, Material); 2], second_first: bool) {
    let [first, second] = surfaces;
    let in_order = if second_first { [second, first] } else { [first, second] };
    for (primitive, material) in in_order {
        stage.add(primitive, material);
    }
}

fn pane(color: Vec3, roughness: f32) -> Material {
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    Material { roughness, ior: 1.5, transmission, double_sided: true, ..lambert(color) }
}

#[test]
fn volumes_absorb_on_the_way_back_from_the_floor_on_which_they_stand() {
    for (integrator, second_first) in INTEGRATORS.into_iter().flat_map(|i| [(i, false), (i, true)]) {
        let mut stage = stage(integrator, 4096);
        stage.environment = Environment::Constant(Vec3::ONE);
        // Half the light is left after half a metre.
        let volume =
            Volume { attenuation_distance: 0.5, attenuation_color: Vec3::splat(0.5), ..Volume::CLEAR };
        let water = Material { ior: 1.0, volume: Some(volume), double_sided: false, ..pane(Vec3::ONE, 0.0) };
        let mirror = Material { metallic: 1.0, roughness: 0.0, ..lambert(Vec3::ONE) };
        let block = cuboid(Vec3::Y * 0.5, Vec3::new(3.0, 0.5, 3.0));
        add(&mut stage, [(block, water), (floor(6.0), mirror)], second_first);
        // A metre down and another one up.
        assert_close(stage.look(Vec3::Y * 6.0, Vec3::ZERO), Vec3::splat(0.0625), 2e-3);
    }
}

#[test]
fn volumes_behind_a_pane_that_touches_them_are_entered_once() {
    for (integrator, second_first) in INTEGRATORS.into_iter().flat_map(|i| [(i, false), (i, true)]) {
        let mut stage = stage(integrator, 4096);
        let volume =
            Volume { attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5), ..Volume::CLEAR };
        let water = Material { ior: 1.0, volume: Some(volume), double_sided: false, ..pane(Vec3::ONE, 0.0) };
        let block = cuboid(Vec3::NEG_Z * 0.5, Vec3::new(2.0, 2.0, 0.5));
        let front = rectangle(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0);
        let clear = Material { ior: 1.0, ..pane(Vec3::ONE, 0.0) };
        add(&mut stage, [(block, water), (front, clear)], second_first);
        stage.add(rectangle(Vec3::NEG_Z * 5.0, Vec3::X * 9.0, Vec3::Y * 9.0), unlit(Vec3::ONE));
        // Nothing but the metre of the block weakens the light of the wall behind it.
        assert_close(stage.look(Vec3::Z * 3.0, Vec3::ZERO), Vec3::splat(0.5), 5e-3);
    }
}

#[test]
fn panes_that_coincide_pass_light_one_after_the_other() {
    for integrator in INTEGRATORS {
        let mut stage = stage(integrator, 256);
        for side in [1.0, -1.0] {
            stage.add(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y * side), pane(Vec3::ONE, 0.0));
        }
        stage.add(rectangle(Vec3::NEG_Z * 3.0, Vec3::X * 9.0, Vec3::Y * 9.0), unlit(Vec3::ONE));
        // Each reflects F = ((1.5 − 1) / (1.5 + 1))² = 0.04, and what is reflected between both may count or not: 0.96² … 0.96 / 1.04.
        let seen = stage.look(Vec3::Z * 3.0, Vec3::ZERO).x;
        assert!((0.915..0.93).contains(&seen), "{seen}");
    }
}

#[test]
fn no_light_passes_paper_that_lies_on_a_table() {
    for (integrator, gap) in INTEGRATORS.into_iter().flat_map(|i| [(i, 0.0), (i, 0.01)]) {
        let mut stage = stage(integrator, 64);
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.settings.show_background = false;
        let half = DiffuseTransmission { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None };
        let paper = Material { diffuse_transmission: Some(half), double_sided: true, ..lambert(Vec3::ONE) };
        stage.add(floor(2.0), paper);
        let table = Material { double_sided: true, ..lambert(Vec3::ZERO) };
        stage.add(rectangle(Vec3::NEG_Y * gap, Vec3::Z * 4.0, Vec3::X * 4.0), table);
        stage.add_light(LightKind::Point, 10.0, Vec3::NEG_Y, Vec3::Y);
        let seen = stage.look(Vec3::new(0.0, 1.0, 0.5), Vec3::ZERO);
        // Light comes in through the narrow gap's open side at most.
        assert_close(seen, Vec3::ZERO, 0.01);
    }
}

fn paper() -> Material {
    let factor = DiffuseTransmission { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None };
    Material { diffuse_transmission: Some(factor), double_sided: true, ..lambert(Vec3::ONE) }
}

#[test]
fn lamps_shine_as_if_bare_through_sheets_that_touch_them() {
    // Half a metre above the floor, a square of half width 1 and radiance 1 lights it by its form factor.
    let expected = 0.5 * super::path::square_form_factor(1.0, 0.5);
    for sheet in [pane(Vec3::ONE, 0.0), pane(Vec3::ONE, 0.6), paper()] {
        for sheet_last in [false, true] {
            let mut stage = stage(Integrator::Path, 4096);
            stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
            let square = || rectangle(Vec3::Y * 0.5, Vec3::X, Vec3::Z);
            let lamp = Material { emissive: Vec3::ONE, ..lambert(Vec3::ZERO) };
            add(&mut stage, [(square(), sheet.clone()), (square(), lamp)], sheet_last);
            stage.settings.max_depth = 3;
            assert_close(stage.look(Vec3::new(0.0, 0.1, 0.4), Vec3::ZERO), Vec3::splat(expected), 0.02);
            // The lamp itself
            assert_close(stage.look(Vec3::new(0.1, 0.1, 0.0), Vec3::Y * 0.5), Vec3::ONE, 0.02);
        }
    }
}

#[test]
fn lamps_shine_through_sheets_that_touch_a_pane() {
    let clear = pane(Vec3::ONE, 0.0);
    for (integrator, sheet) in INTEGRATORS.into_iter().flat_map(|i| [(i, paper()), (i, pane(Vec3::ONE, 0.8))])
    {
        let see = |gap: f32, sheet_last: bool| {
            let mut stage = stage(integrator, 4096);
            let square = |height: f32| rectangle(Vec3::Y * height, Vec3::Z * 2.0, Vec3::X * 2.0);
            add(&mut stage, [(square(0.0), sheet.clone()), (square(-gap), clear.clone())], sheet_last);
            stage.add_light(LightKind::Point, 10.0, Vec3::NEG_Y, Vec3::Y);
            stage.look(Vec3::new(0.0, 1.0, 0.5), Vec3::ZERO).x
        };
        let apart = see(0.01, false);
        for sheet_last in [false, true] {
            // The touching pane may be left out: it reflects a twentieth.
            let touching = see(0.0, sheet_last);
            assert!((touching / apart - 1.0).abs() < 0.1 && apart > 0.5, "{touching} {apart}");
        }
    }
}

#[test]
fn copies_of_glass_that_is_opaque_in_places_are_shaded() {
    // Where the mean of the texture lets light pass and its texel does not, each copy gave way to the other for ever.
    for integrator in INTEGRATORS {
        let mut stage = Stage::new();
        stage.settings.integrator = integrator;
        stage.settings.samples = 64;
        stage.environment = Environment::Constant(Vec3::ONE);
        let texels = (0..64 * 64).map(|texel| [if texel % 8 < 4 { 0 } else { 255 }; 4]).collect();
        let image = Image { name: None, width: 64, height: 64, texels: Texels::Rgba8(texels) };
        let mut mips = ImageMips::default();
        mips.set(Encoding::Linear, mip_levels(&image, Encoding::Linear).into());
        stage.scene.mips.push(mips);
        stage.scene.images.push(image);
        stage.scene.textures.push(Texture { name: None, image: ImageIndex(0), sampler: Sampler::default() });
        let texture = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        let transmission = Some(Transmission { factor: 1.0, texture: Some(texture) });
        let mut square = rectangle(Vec3::ZERO, Vec3::X, Vec3::Y);
        square.uvs = vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]];
        for _ in 0..2 {
            let material = Material { transmission, ..pane(Vec3::splat(0.5), 0.0) };
            stage.add(square.clone(), material);
        }
        // Of index 1.5, under uniform light: darker than that light, lighter than two tints.
        let seen = stage.look(Vec3::Z * 3.0, Vec3::ZERO).x;
        assert!((0.2..0.8).contains(&seen), "{seen}");
    }
}
