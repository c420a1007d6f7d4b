//! NormalTangentTest, NegativeScaleTest, OrientationTest, VertexColorTest.

use serde_json::{Value, json};

use super::sheet::{Card, Sheet, assert_close, assert_pairs, unlit};

/// Adds a directional light from the upper left and a rough white material, whose brightness depends on the normal.
fn lit(sheet: &mut Sheet) -> usize {
    let sun = json!({ "type": "directional", "intensity": 3.0 });
    sheet.extension("KHR_lights_punctual", json!({ "lights": [sun] }));
    // −Z turned down by 0.6 around X and to the right by 0.4 around Y.
    let (half_x, half_y) = (-0.3_f32, -0.2_f32);
    let (sx, cx, sy, cy) = (libm::sinf(half_x), libm::cosf(half_x), libm::sinf(half_y), libm::cosf(half_y));
    let rotation = [cy * sx, sy * cx, -sy * sx, cy * cx];
    sheet.node(json!({ "rotation": rotation, "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    sheet.material(rough(json!({})))
}

fn rough(extra: Value) -> Value {
    let mut material = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } });
    if let (Some(material), Value::Object(extra)) = (material.as_object_mut(), extra) {
        material.extend(extra);
    }
    material
}

#[test]
fn normals_of_a_map_match_normals_of_the_mesh() {
    // A map of one texel leans the normal along the tangent, its mirror image against it; the same normals written at the
    // corners look alike. 191 / 255 · 2 − 1 = 0.498, z from the third channel.
    let mut sheet = Sheet::new(&["KHR_lights_punctual"]);
    let flat = lit(&mut sheet);
    let value = |texel: u8| f32::from(texel) / 255.0 * 2.0 - 1.0;
    for (texel, handedness) in [([191, 128, 238], 1.0_f32), ([64, 200, 220], 1.0), ([128, 64, 220], -1.0)] {
        let [r, g, b] = texel;
        let texture = sheet.texture(1, &[[r, g, b, 255]], json!({}));
        let mapped = sheet.material(rough(json!({ "normalTexture": { "index": texture } })));
        let up = [[0.0, 0.0, 1.0]; 4];
        let tangents = Some([[1.0, 0.0, 0.0, handedness]; 4]);
        sheet.card(&Card { normals: Some(up), tangents, ..Card::default() }, mapped);
        // B = N × T · w is +Y for w = 1.
        let (x, y, z) = (value(r), value(g) * handedness, value(b));
        let length = (x * x + y * y + z * z).sqrt();
        let normal = [x / length, y / length, z / length];
        sheet.card(&Card { normals: Some([normal; 4]), ..Card::default() }, flat);
    }
    let seen = sheet.look();
    assert!(seen.iter().all(|[red, ..]| *red > 0.05), "{seen:?}");
    assert_pairs(&seen);
}

#[test]
fn mirrored_texture_coordinates_mirror_the_map() {
    // Without tangents they follow from the coordinates: where u runs to the left, the map leans to the left.
    let mut sheet = Sheet::new(&["KHR_lights_punctual"]);
    lit(&mut sheet);
    let plain = sheet.texture(1, &[[200, 128, 230, 255]], json!({}));
    let mirrored = sheet.texture(1, &[[55, 128, 230, 255]], json!({}));
    let up = Some([[0.0, 0.0, 1.0]; 4]);
    let leftwards = Card::default().uvs.map(|[u, v]| [1.0 - u, v]);
    let material = sheet.material(rough(json!({ "normalTexture": { "index": plain } })));
    sheet.card(&Card { uvs: leftwards, normals: up, ..Card::default() }, material);
    let material = sheet.material(rough(json!({ "normalTexture": { "index": mirrored } })));
    sheet.card(&Card { normals: up, ..Card::default() }, material);
    assert_pairs(&sheet.look());
}

#[test]
fn negative_scales_keep_fronts_and_normals() {
    // A leaning, single-sided card under a mirroring scale looks as one whose corners are written mirrored, turned the other
    // way round so that its front stays in front.
    let leaning = [[-0.4, -0.4, 0.2], [0.4, -0.4, -0.1], [0.4, 0.4, -0.3], [-0.4, 0.4, 0.0]];
    let mut sheet = Sheet::new(&["KHR_lights_punctual"]);
    let material = lit(&mut sheet);
    for scale in [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, -1.0, -1.0]] {
        let written = leaning.map(|[x, y, z]| [x * scale[0], y * scale[1], z * scale[2]]);
        let node = sheet.card(&Card { corners: leaning, ..Card::default() }, material);
        sheet.set(node, "scale", json!(scale));
        let flips = scale.iter().product::<f32>() < 0.0;
        let [a, b, c, d] = written;
        // A point reflection turns the front away: both cards are invisible from behind.
        let corners = if flips { [a, d, c, b] } else { written };
        sheet.card(&Card { corners, ..Card::default() }, material);
    }
    let seen = sheet.look();
    assert!(seen[..6].iter().all(|[red, ..]| *red > 0.05), "{seen:?}");
    assert_pairs(&seen);
}

#[test]
fn rotated_nodes_match_rotated_corners() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut sheet = Sheet::new(&[]);
    // One colour a corner distinguishes all rotations.
    let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 1.0]];
    let mut two_sided = unlit(&json!({}));
    two_sided["doubleSided"] = true.into();
    let two_sided = sheet.material(two_sided);
    let off_centre = Card::default().corners.map(|[x, y, z]| [x + 0.1, y + 0.2, z]);
    for (rotation, turned) in [
        // A quarter turn around Z: (x, y) → (−y, x).
        ([0.0, 0.0, half, half], off_centre.map(|[x, y, z]| [-y, x, z])),
        // A half turn around Y: (x, z) → (−x, −z).
        ([0.0, 1.0, 0.0, 0.0], off_centre.map(|[x, y, z]| [-x, y, -z])),
        // A half turn around X.
        ([1.0, 0.0, 0.0, 0.0], off_centre.map(|[x, y, z]| [x, -y, -z])),
    ] {
        let node =
            sheet.card(&Card { corners: off_centre, colors: Some(colors), ..Card::default() }, two_sided);
        sheet.set(node, "rotation", json!(rotation));
        sheet.card(&Card { corners: turned, colors: Some(colors), ..Card::default() }, two_sided);
    }
    assert_pairs(&sheet.look());
}

#[test]
fn vertex_colors_multiply_the_base_color() {
    let mut sheet = Sheet::new(&[]);
    let texture = sheet.texture(1, &[[255, 255, 0, 255]], json!({}));
    let base = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "baseColorTexture": { "index": texture } });
    let material = sheet.material(unlit(&base));
    let [low, high] = [[0.2, 0.4, 1.0, 1.0], [0.6, 0.8, 1.0, 1.0]];
    sheet.card(&Card { colors: Some([low; 4]), ..Card::default() }, material);
    // The centre of a card lies on the diagonal between two corners.
    sheet.card(&Card { colors: Some([low, high, high, low]), ..Card::default() }, material);
    let seen = sheet.look();
    // Linear: half of the colour in red and green, nothing in blue.
    assert_close(seen[0], [0.1, 0.2, 0.0], 0);
    assert_close(seen[1], [0.2, 0.3, 0.0], 1);
}
