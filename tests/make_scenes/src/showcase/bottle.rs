//! A perfume bottle: thick glass, amber liquid with air above it, a golden cap, a collar and a printed label.

use glam::{Vec2, Vec3};

use super::solids::{Outline, at, joined, lathe, loft, profile, rounded, surface};
use super::{Stage, metal, paint};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image, Wrap, texture};
use scene_builder::material::{ClearCoat, Material, TextureUse, Volume};

/// Half the width and depth of the bottle, metres.
const HALF: Vec2 = Vec2::new(0.036, 0.021);
/// Exponent of its superellipse.
const EXPONENT: f32 = 4.5;
/// Height of the glass.
const HEIGHT: f32 = 0.084;

pub(super) fn bottle() -> Built {
    let mut stage = Stage::new(
        "A perfume bottle of thick clear glass, three quarters full of amber liquid, with a golden cap and a cream label. Only \
         the studio lights it. The liquid is bent and magnified by the glass, and its surface is seen from above and below.",
    );
    glass(&mut stage);
    cap(&mut stage);
    label(&mut stage)?;
    Ok(stage.gltf)
}

/// The glass, the liquid that fills its cavity, and a bubble of air inside the liquid: each volume lies within the one before.
fn glass(stage: &mut Stage) {
    let outline = Outline::superellipse(HALF, EXPONENT, 48);
    let clear = Material {
        volume: Some(Volume { thickness: 0.01, attenuation: Some((0.35, [0.9, 0.97, 0.95])) }),
        ..Material::glass("glass", 1.5)
    };
    let clear = clear.add_to(&mut stage.gltf);
    let body = rounded(
        &[(-0.012, 0.0), (0.0, 0.0), (0.0, HEIGHT - 0.006), (-0.008, HEIGHT), (-0.014, HEIGHT)],
        0.004,
        4,
    );
    stage.add("glass", &[(loft(&outline, &body), clear)], [0.0; 3], 0.0);

    let liquid = Material {
        volume: Some(Volume { thickness: 0.03, attenuation: Some((0.03, [0.98, 0.66, 0.36])) }),
        ..Material::glass("perfume", 1.36)
    };
    let liquid = liquid.add_to(&mut stage.gltf);
    let (floor, ceiling) = (0.012, HEIGHT - 0.008);
    let cavity = rounded(
        &[
            (-0.014, floor),
            (-0.0045, floor),
            (-0.0045, ceiling - 0.004),
            (-0.012, ceiling),
            (-0.014, ceiling),
        ],
        0.005,
        4,
    );
    stage.add("perfume", &[(loft(&outline, &cavity), liquid)], [0.0; 3], 0.0);

    let air = Material::glass("air", 1.0).add_to(&mut stage.gltf);
    let level = HEIGHT * 0.76;
    let bubble = rounded(
        &[
            (-0.014, level),
            (-0.005, level),
            (-0.005, ceiling - 0.0045),
            (-0.0122, ceiling - 0.0005),
            (-0.014, ceiling - 0.0005),
        ],
        0.0015,
        3,
    );
    stage.add("air", &[(loft(&outline, &bubble), air)], [0.0; 3], 0.0);
}

/// A collar of steel and a bevelled golden cap with a groove.
fn cap(stage: &mut Stage) {
    let steel = metal("brushed steel", 0xd9d6d0, 0.22).add_to(&mut stage.gltf);
    let gold = metal("gold", 0xf0cf98, 0.24).add_to(&mut stage.gltf);
    let collar = rounded(&[(0.0, 0.0), (0.0125, 0.0), (0.0125, 0.005), (0.0, 0.005)], 0.0012, 4);
    stage.add("collar", &[(lathe(&collar, 32), steel)], [0.0, HEIGHT + 0.0002, 0.0], 0.0);
    let outline = Outline::superellipse(Vec2::new(0.017, 0.017), 4.0, 36);
    let lower = rounded(&[(-0.014, 0.0), (0.0, 0.0), (0.0, 0.0055), (-0.002, 0.0055)], 0.0008, 3);
    let upper = rounded(&[(-0.002, 0.0065), (0.0, 0.0065), (0.0, 0.031), (-0.014, 0.0325)], 0.0018, 5);
    let parts = joined([
        loft(&outline, &lower),
        loft(&outline, &upper),
        at(lathe(&profile(&[(0.013, 0.005), (0.013, 0.007)]), 32), 0.0, 0.0, 0.0),
    ]);
    stage.add("cap", &[(parts, gold)], [0.0, HEIGHT + 0.0052, 0.0], 0.0);
}

/// A label just off the glass that follows its curve, and its back.
fn label(stage: &mut Stage) -> Built<()> {
    let print = printed_texture(&mut stage.gltf)?;
    let paper = Material {
        base_color_texture: Some(TextureUse::of(print)),
        clear_coat: Some(ClearCoat { factor: 0.4, roughness: 0.15, normal_texture: None }),
        ..paint("label", 0xffffff, 0.55)
    };
    let paper = paper.add_to(&mut stage.gltf);
    let back = paint("back of the label", 0xe9e2d4, 0.8).add_to(&mut stage.gltf);
    let (width, low, high) = (0.034, 0.026, 0.062);
    let point = |u: f32, v: f32, gap: f32| {
        let x = (u - 0.5) * width;
        let depth = libm::powf(1.0 - libm::powf((x / HALF.x).abs(), EXPONENT), 1.0 / EXPONENT);
        Vec3::new(x, low + (high - low) * v, HALF.y * depth + gap)
    };
    let mut front = surface(16, 1, |u, v| point(u, v, 0.0004));
    front.uvs = front
        .positions
        .iter()
        .map(|position| Vec2::new(position.x / width + 0.5, (high - position.y) / (high - low)))
        .collect();
    let reverse = surface(16, 1, |u, v| point(1.0 - u, v, 0.0002));
    stage.add("label", &[(front, paper), (reverse, back)], [0.0; 3], 0.0);
    Ok(())
}

/// A cream label with a double frame and a flower of six petals, computed by formula.
fn printed_texture(gltf: &mut Gltf) -> Built<usize> {
    let size = 128;
    let image = Image::new(size, size, |x, y| {
        let [u, v] = [x, y].map(|texel| (texel as f32 + 0.5) / size as f32 * 2.0 - 1.0);
        let edge = u.abs().max(v.abs());
        let (radius, angle) = ((u * u + (v + 0.18) * (v + 0.18)).sqrt(), libm::atan2f(u, v + 0.18));
        let petal = 0.36 * (0.35 + 0.65 * libm::cosf(3.0 * angle).abs());
        let inks = [
            smooth_step(0.012, (edge - 0.88).abs() - 0.018),
            smooth_step(0.012, (edge - 0.81).abs() - 0.006),
            smooth_step(0.02, (radius - petal).abs() - 0.014),
            smooth_step(0.02, radius - 0.05),
            // Three lines of small print.
            smooth_step(0.012, (v - 0.40).abs() - 0.022) * smooth_step(0.02, u.abs() - 0.42),
            smooth_step(0.012, (v - 0.54).abs() - 0.010) * smooth_step(0.02, u.abs() - 0.28),
            smooth_step(0.012, (v - 0.64).abs() - 0.010) * smooth_step(0.02, u.abs() - 0.20),
        ];
        let ink = inks.into_iter().fold(0.0, f32::max);
        let mix = |paper: f32, ink_color: f32| (paper + (ink_color - paper) * ink) as u8;
        [mix(244.0, 58.0), mix(236.0, 44.0), mix(222.0, 62.0), 255]
    });
    let image = image.add_to(gltf, "label")?;
    Ok(texture(gltf, image, Filter::Mipmapped, [Wrap::ClampToEdge; 2]))
}

/// 1 where `distance` is negative, 0 beyond `width`.
fn smooth_step(width: f32, distance: f32) -> f32 {
    let share = (0.5 - distance / width).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
