//! The colour difference ΔE2000 of sRGB colours.
//!
//! Source: Sharma, Wu, Dalal, "The CIEDE2000 color-difference formula: implementation notes, supplementary test data, and
//! mathematical observations", Color Research and Application 30 (2005). The factors kL, kC and kH are 1.

/// White point D65 of the 2° observer, XYZ.
const WHITE: [f64; 3] = [0.950_47, 1.0, 1.088_83];

/// ΔE2000 of two sRGB colours between 0 and 255. About 1 is just noticeable side by side.
pub fn delta_e_2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    delta_e_of_lab(lab(a), lab(b))
}

/// CIELAB under D65 of an sRGB colour.
fn lab(encoded: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = encoded.map(|value| {
        let value = value / 255.0;
        if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
    });
    let xyz = [
        0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b,
        0.212_672_9 * r + 0.715_152_2 * g + 0.072_175 * b,
        0.019_333_9 * r + 0.119_192 * g + 0.950_304_1 * b,
    ];
    let [x, y, z] = [0, 1, 2].map(|index| {
        let share: f64 = xyz[index] / WHITE[index];
        if share > 216.0 / 24389.0 { libm::cbrt(share) } else { (24389.0 / 27.0 * share + 16.0) / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The formula, with the paper's symbols and equation numbers.
fn delta_e_of_lab([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let pow7 = |value: f64| libm::pow(value, 7.0);
    let sin_of = |degrees: f64| libm::sin(degrees.to_radians());
    let cos_of = |degrees: f64| libm::cos(degrees.to_radians());
    let seventh_share = |chroma: f64| libm::sqrt(pow7(chroma) / (pow7(chroma) + pow7(25.0)));

    // Chroma and hue, (2) to (7)
    let g = 0.5 * (1.0 - seventh_share(f64::midpoint(libm::hypot(a1, b1), libm::hypot(a2, b2))));
    let polar = |a: f64, b: f64| {
        let a = a * (1.0 + g);
        (libm::hypot(a, b), libm::atan2(b, a).to_degrees().rem_euclid(360.0))
    };
    let ((c1, h1), (c2, h2)) = (polar(a1, b1), polar(a2, b2));
    let is_grey = c1 * c2 == 0.0;

    // Differences, (8) to (11)
    let turn = match h2 - h1 {
        _ if is_grey => 0.0,
        turn if turn > 180.0 => turn - 360.0,
        turn if turn < -180.0 => turn + 360.0,
        turn => turn,
    };
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh = 2.0 * libm::sqrt(c1 * c2) * sin_of(turn / 2.0);

    // Means, (12) to (14)
    let (l, c) = (f64::midpoint(l1, l2), f64::midpoint(c1, c2));
    let h = match h1 + h2 {
        sum if is_grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => sum / 2.0,
        sum if sum < 360.0 => f64::midpoint(sum, 360.0),
        sum => (sum - 360.0) / 2.0,
    };

    // Weights, (15) to (22)
    let t = 1.0 - 0.17 * cos_of(h - 30.0) + 0.24 * cos_of(2.0 * h) + 0.32 * cos_of(3.0 * h + 6.0)
        - 0.20 * cos_of(4.0 * h - 63.0);
    let from_blue = (h - 275.0) / 25.0;
    let theta = 30.0 * libm::exp(-from_blue * from_blue);
    let from_middle = (l - 50.0) * (l - 50.0);
    let sl = 1.0 + 0.015 * from_middle / libm::sqrt(20.0 + from_middle);
    let (sc, sh) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let rt = -sin_of(2.0 * theta) * 2.0 * seventh_share(c);
    let (l, c, h) = (dl / sl, dc / sc, dh / sh);
    libm::sqrt(l * l + c * c + h * h + rt * c * h)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_gives_the_papers_values() {
        // Pairs 1, 7, 16, 17 and 25 of the paper's table.
        for (a, b, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ] {
            assert!((delta_e_of_lab(a, b) - expected).abs() < 1e-4, "{a:?} {b:?}");
            assert!((delta_e_of_lab(b, a) - expected).abs() < 1e-4, "{b:?} {a:?}");
        }
    }

    #[test]
    fn white_and_black_are_a_hundred_apart() {
        assert!((delta_e_2000([0.0; 3], [255.0; 3]) - 100.0).abs() < 0.01);
        assert_eq!(delta_e_2000([10.0, 20.0, 30.0], [10.0, 20.0, 30.0]), 0.0);
    }
}
