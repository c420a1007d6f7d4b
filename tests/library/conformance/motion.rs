//! InterpolationTest.

use serde_json::json;

use super::sheet::{Card, Sheet, assert_close, unlit};

#[test]
fn interpolation() {
    // A card goes up by 2 m in a second. At three quarters of it, STEP is still in place, LINEAR is 1.5 m up, and
    // CUBICSPLINE without tangents is at 2 (3t² − 2t³) = 1.6875. Each card starts that far below its slot. At that time a strip
    // across the centre of the slot is visible, and one just above is not.
    let mut sheet = Sheet::new(&[]);
    let red = sheet.material(unlit(&json!({ "baseColorFactor": [1, 0, 0, 1] })));
    let blue = sheet.material(unlit(&json!({ "baseColorFactor": [0, 0, 1, 1] })));
    let times = sheet.floats(&[0.0, 1.0], 1);
    for (interpolation, height) in [("STEP", 0.0_f32), ("LINEAR", 1.5), ("CUBICSPLINE", 1.6875)] {
        for low in [-0.05, 0.05] {
            let high = low + 0.1;
            let corners = [[-0.4, low, 0.0], [0.4, low, 0.0], [0.4, high, 0.0], [-0.4, high, 0.0]];
            let (start, end, zero) =
                ([sheet.next_x(), -height, 0.0], [sheet.next_x(), 2.0 - height, 0.0], [0.0; 3]);
            sheet.card_at(&Card::default(), blue, -1.0);
            let node = sheet.card(&Card { corners, ..Card::default() }, red);
            let values = match interpolation {
                "CUBICSPLINE" => [zero, start, zero, zero, end, zero].concat(),
                _ => [start, end].concat(),
            };
            let values = sheet.floats(&values, 3);
            sheet.animate(node, "translation", times, values, interpolation);
        }
    }
    for (card, seen) in sheet.look_at(0.75).into_iter().enumerate() {
        assert_close(seen, if card % 2 == 0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] }, card);
    }
}
