//! AlphaBlendModeTest, EmissiveStrengthTest, TransmissionTest, ClearCoatTest.

use serde_json::{Value, json};

use super::sheet::{Card, Sheet, assert_close, assert_pairs, unlit};

#[test]
fn alpha_modes() {
    let mut sheet = Sheet::new(&[]);
    let behind = sheet.material(unlit(&json!({ "baseColorFactor": [0, 0, 1, 1] })));
    let mut put = |mode: &str, cutoff: Option<f32>, alpha: f32| {
        let mut material = unlit(&json!({ "baseColorFactor": [1, 0, 0, alpha] }));
        material["alphaMode"] = mode.into();
        if let Some(cutoff) = cutoff {
            material["alphaCutoff"] = cutoff.into();
        }
        let material = sheet.material(material);
        sheet.card_at(&Card::default(), behind, -1.0);
        sheet.card(&Card::default(), material);
    };
    let cases = [
        ("OPAQUE", None, 0.25, 1.0),
        ("BLEND", None, 0.25, 0.25),
        ("BLEND", None, 1.0, 1.0),
        // The cutoff is 0.5 by default; alpha equal to it is opaque.
        ("MASK", None, 0.49, 0.0),
        ("MASK", None, 0.5, 1.0),
        ("MASK", Some(0.25), 0.3, 1.0),
        ("MASK", Some(0.75), 0.7, 0.0),
    ];
    for (mode, cutoff, alpha, _) in cases {
        put(mode, cutoff, alpha);
    }
    for (card, (seen, (.., coverage))) in sheet.look().into_iter().zip(cases).enumerate() {
        assert_close(seen, [coverage, 0.0, 1.0 - coverage], card);
    }
}

#[test]
fn emissive_strength() {
    let mut sheet = Sheet::new(&["KHR_materials_emissive_strength"]);
    let black = json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 });
    for strength in [0.25, 1.0, 16.0] {
        let material = sheet.material(json!({
            "pbrMetallicRoughness": black, "emissiveFactor": [0.5, 0.25, 0.125],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } },
        }));
        sheet.card(&Card::default(), material);
    }
    let seen = sheet.look();
    // The studio light adds the same dielectric reflection to each black card.
    for (strong, times) in [(seen[1], 4.0), (seen[2], 64.0)] {
        for channel in 0..3 {
            let emitted = [0.5, 0.25, 0.125][channel] * 0.25;
            let added = strong[channel] - seen[0][channel];
            assert!((added - emitted * (times - 1.0)).abs() < 2e-3 * times, "{times}: {added}");
        }
    }
}

fn thin_glass(factor: &Value, color: [f32; 4]) -> Value {
    json!({
        "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": { "KHR_materials_transmission": factor, "KHR_materials_ior": { "ior": 1.0 } },
    })
}

#[test]
fn transmission() {
    // An index of one reflects nothing. The result is base colour · transmission · background; the diffuse rest is black
    // without light.
    let mut sheet = Sheet::new(&["KHR_materials_transmission", "KHR_materials_ior", "KHR_lights_punctual"]);
    // A light of no intensity replaces the studio light.
    let out = json!({ "lights": [{ "type": "point", "intensity": 0.0 }] });
    sheet.extension("KHR_lights_punctual", out);
    sheet.node(json!({ "translation": [0, 0, 9], "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    let behind = sheet.material(unlit(&json!({ "baseColorFactor": [0.8, 0.6, 0.4, 1] })));
    let texture = sheet.texture(1, &[[128, 0, 0, 255]], json!({}));
    let tint = [0.5, 1.0, 0.25, 1.0];
    let cases = [
        (json!({ "transmissionFactor": 0.0 }), 0.0),
        (json!({ "transmissionFactor": 0.5 }), 0.5),
        (json!({ "transmissionFactor": 1.0 }), 1.0),
        (json!({ "transmissionFactor": 1.0, "transmissionTexture": { "index": texture } }), 128.0 / 255.0),
    ];
    for (factor, _) in &cases {
        let material = sheet.material(thin_glass(factor, tint));
        sheet.card_at(&Card::default(), behind, -1.0);
        sheet.card(&Card::default(), material);
    }
    for (card, (seen, (_, share))) in sheet.look().into_iter().zip(cases).enumerate() {
        assert_close(seen, [0.8 * 0.5 * share, 0.6 * share, 0.4 * 0.25 * share], card);
    }
}

#[test]
fn clear_coat() {
    // Along the normal the coat transmits 1 − 0.04. A coat of factor 0, or with a black texture, has no effect.
    let mut sheet = Sheet::new(&["KHR_materials_clearcoat", "KHR_lights_punctual"]);
    let out = json!({ "lights": [{ "type": "point", "intensity": 0.0 }] });
    sheet.extension("KHR_lights_punctual", out);
    sheet.node(json!({ "translation": [0, 0, 9], "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    let texture = sheet.texture(1, &[[128, 0, 0, 255]], json!({}));
    let black = sheet.texture(1, &[[0, 255, 255, 255]], json!({}));
    let mut put = |coat: Option<Value>| {
        let mut material = json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1 },
            "emissiveFactor": [1, 0.5, 0.25],
        });
        if let Some(coat) = coat {
            material["extensions"] = json!({ "KHR_materials_clearcoat": coat });
        }
        let material = sheet.material(material);
        sheet.card(&Card::default(), material);
    };
    put(None);
    put(Some(json!({ "clearcoatFactor": 0.0 })));
    put(None);
    put(Some(json!({ "clearcoatFactor": 1.0, "clearcoatTexture": { "index": black } })));
    put(Some(json!({ "clearcoatFactor": 1.0 })));
    put(Some(json!({ "clearcoatFactor": 1.0, "clearcoatTexture": { "index": texture } })));
    let seen = sheet.look();
    assert_pairs(&seen[..4]);
    let below = |share: f32| [1.0, 0.5, 0.25].map(|emitted| emitted * (1.0 - 0.04 * share));
    assert_close(seen[4], below(1.0), 4);
    assert_close(seen[5], below(128.0 / 255.0), 5);
}
