//! TextureSettingsTest, TextureTransformTest, TextureEncodingTest, TextureLinearInterpolationTest.

use serde_json::{Value, json};

use super::sheet::{Card, Sheet, assert_close, assert_pairs, linear, unlit};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const WHITE: [u8; 4] = [255; 4];
const REPEAT: u32 = 10497;
const MIRROR: u32 = 33648;
const CLAMP: u32 = 33071;
const NEAREST: u32 = 9728;
const LINEAR: u32 = 9729;

fn textured(texture: usize) -> Value {
    unlit(&json!({ "baseColorTexture": { "index": texture } }))
}

fn nearest(s: u32, t: u32) -> Value {
    json!({ "wrapS": s, "wrapT": t, "magFilter": NEAREST, "minFilter": NEAREST })
}

/// Red and green above, blue and white below.
const FOUR: [[u8; 4]; 4] = [RED, GREEN, BLUE, WHITE];

#[test]
fn texture_settings_wrap_modes() {
    // A wrapped coordinate beside the coordinate of the same texel inside the image.
    let inside = |s: usize, t: usize| (0.25 + 0.5 * s as f32, 0.25 + 0.5 * t as f32);
    for (mode_s, mode_t, outside, texel) in [
        (REPEAT, REPEAT, (1.25, 2.75), (0, 1)),
        (REPEAT, REPEAT, (-0.25, -0.75), (1, 0)),
        (MIRROR, MIRROR, (1.25, 1.75), (1, 0)),
        (MIRROR, MIRROR, (-0.25, -1.25), (0, 1)),
        (CLAMP, CLAMP, (1.75, -3.0), (1, 0)),
        (REPEAT, CLAMP, (1.75, 1.75), (1, 1)),
        (CLAMP, MIRROR, (-1.0, 1.25), (0, 1)),
        (MIRROR, REPEAT, (1.25, 1.25), (1, 0)),
    ] {
        let mut sheet = Sheet::new(&[]);
        let texture = sheet.texture(2, &FOUR, nearest(mode_s, mode_t));
        let material = sheet.material(textured(texture));
        sheet.card(&Card::at_uv(outside.0, outside.1), material);
        let (u, v) = inside(texel.0, texel.1);
        sheet.card(&Card::at_uv(u, v), material);
        assert_pairs(&sheet.look());
    }
}

#[test]
fn texture_settings_filters_and_sides() {
    let mut sheet = Sheet::new(&[]);
    let sharp = sheet.texture(2, &[RED, GREEN], nearest(CLAMP, CLAMP));
    let smooth =
        sheet.texture(2, &[RED, GREEN], json!({ "wrapS": CLAMP, "magFilter": LINEAR, "minFilter": LINEAR }));
    for texture in [sharp, smooth] {
        let material = sheet.material(textured(texture));
        sheet.card(&Card::at_uv(0.45, 0.5), material);
    }
    // From behind, a double-sided card is visible; a single-sided one shows the card behind it.
    let turned = Card { corners: Card::default().corners.map(|[x, y, z]| [-x, y, z]), ..Card::default() };
    let behind = sheet.material(unlit(&json!({ "baseColorFactor": [0, 0, 1, 1] })));
    for double_sided in [true, false] {
        let mut material = unlit(&json!({ "baseColorFactor": [1, 1, 0, 1] }));
        material["doubleSided"] = double_sided.into();
        let material = sheet.material(material);
        sheet.card_at(&Card::default(), behind, -1.0);
        sheet.card(&turned, material);
    }
    let seen = sheet.look();
    assert_close(seen[0], [1.0, 0.0, 0.0], 0);
    // 0.45 is 0.9 texels, 0.4 of the way from the centre of the first to that of the second.
    assert_close(seen[1], [0.6, 0.4, 0.0], 1);
    assert_close(seen[2], [1.0, 1.0, 0.0], 2);
    assert_close(seen[3], [0.0, 0.0, 1.0], 3);
}

#[test]
fn texture_transform() {
    // u' = offset + R(rotation) · scale · u, by the extension's matrices: R = [[cos, sin], [−sin, cos]].
    let quarter = std::f32::consts::FRAC_PI_2;
    for (transform, uv, moved) in [
        (json!({ "offset": [0.5, 0.0] }), (0.25, 0.25), (0.75, 0.25)),
        (json!({ "offset": [0.0, 0.5] }), (0.25, 0.25), (0.25, 0.75)),
        (json!({ "scale": [3.0, 1.0] }), (0.25, 0.25), (0.75, 0.25)),
        (json!({ "scale": [1.0, -1.0] }), (0.25, 0.25), (0.25, -0.25)),
        (json!({ "rotation": quarter }), (0.25, 0.75), (0.75, -0.25)),
        (
            json!({ "rotation": quarter, "offset": [0.5, 0.5], "scale": [2.0, 1.0] }),
            (0.125, 0.25),
            (0.75, 0.25),
        ),
    ] {
        let mut sheet = Sheet::new(&["KHR_texture_transform"]);
        let texture = sheet.texture(2, &FOUR, nearest(REPEAT, REPEAT));
        let extensions = json!({ "KHR_texture_transform": transform });
        let reference = json!({ "index": texture, "extensions": extensions });
        let transformed = sheet.material(unlit(&json!({ "baseColorTexture": reference })));
        let plain = sheet.material(textured(texture));
        sheet.card(&Card::at_uv(uv.0, uv.1), transformed);
        sheet.card(&Card::at_uv(moved.0, moved.1), plain);
        assert_pairs(&sheet.look());
    }
}

#[test]
fn texture_encoding() {
    // Base colour and emission are sRGB: a texel matches the factor of its linear value. Metalness is linear: a texel of one
    // half matches a factor of one half.
    let mut sheet = Sheet::new(&[]);
    let texel = [188, 100, 30, 255];
    let factor: Vec<f32> = texel[..3].iter().map(|&value| linear(value)).collect();
    let colors = sheet.texture(1, &[texel], json!({}));
    let numbers = sheet.texture(1, &[[0, 128, 128, 255]], json!({}));
    let colored = sheet.material(textured(colors));
    sheet.card(&Card::default(), colored);
    let plain = sheet.material(unlit(&json!({ "baseColorFactor": [factor[0], factor[1], factor[2], 1.0] })));
    sheet.card(&Card::default(), plain);
    let black = json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 });
    let glowing = sheet.material(json!({
        "pbrMetallicRoughness": black, "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": colors },
    }));
    sheet.card(&Card::default(), glowing);
    let glows = sheet.material(json!({ "pbrMetallicRoughness": black, "emissiveFactor": factor }));
    sheet.card(&Card::default(), glows);
    let half = sheet
        .material(json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": numbers } } }));
    sheet.card(&Card::default(), half);
    let value = 128.0 / 255.0;
    let written = json!({ "pbrMetallicRoughness": { "metallicFactor": value, "roughnessFactor": value } });
    let written = sheet.material(written);
    sheet.card(&Card::default(), written);
    assert_pairs(&sheet.look());
}

#[test]
fn texture_linear_interpolation() {
    // Half way between black and white texels is half the light, not the value in the middle of the sRGB curve.
    let mut sheet = Sheet::new(&[]);
    let sampler = json!({ "wrapS": CLAMP, "magFilter": LINEAR, "minFilter": LINEAR });
    let texture = sheet.texture(2, &[[0, 0, 0, 255], WHITE], sampler);
    let material = sheet.material(textured(texture));
    sheet.card(&Card::at_uv(0.5, 0.5), material);
    assert_close(sheet.look()[0], [0.5; 3], 0);
}
