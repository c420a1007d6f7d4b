//! The colour spaces of FLIP: the opponent space in which contrast sensitivity is modelled, and the space in which colours are
//! compared.
//!
//! Source: P. Andersson et al., *FLIP: A Difference Evaluator for Alternating Images*, HPG 2020, sections 4.1 and 4.2.

/// CIE XYZ from linear Rec.709. The sums of its rows are the white point D65.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_5],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];
const WHITE_XYZ: [f32; 3] = [0.950_428_5, 1.0, 1.088_900_4];

fn product(matrix: &[[f32; 3]; 3], vector: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// YyCxCz, which is linear in light: lightness, red–green, blue–yellow.
pub(super) fn opponent_from_linear(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = product(&XYZ_FROM_RGB, rgb);
    let (x, z) = (x / WHITE_XYZ[0], z / WHITE_XYZ[2]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse, clamped to the unit cube.
pub(super) fn linear_from_opponent([lightness, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let y = (lightness + 16.0) / 116.0;
    let x = y + red_green / 500.0;
    let z = y - blue_yellow / 200.0;
    product(&RGB_FROM_XYZ, [x * WHITE_XYZ[0], y, z * WHITE_XYZ[2]]).map(|value| value.clamp(0.0, 1.0))
}

/// CIELAB with Hunt's adjustment: chroma is scaled by lightness.
pub(super) fn hunt_lab_from_linear(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = product(&XYZ_FROM_RGB, rgb);
    let [x, y, z] = [x / WHITE_XYZ[0], y, z / WHITE_XYZ[2]].map(|value| {
        if value > DELTA * DELTA * DELTA {
            libm::cbrtf(value)
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The HyAB distance, for large differences: city-block between lightness and Euclidean chroma.
pub(super) fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [lightness, red_green, blue_yellow] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    lightness.abs() + (red_green * red_green + blue_yellow * blue_yellow).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_neutral_and_conversions_round_trip() {
        // Lightness is 100 for white and −16 for black, where the others are 0.
        let [lightness, red_green, blue_yellow] = opponent_from_linear([1.0; 3]);
        assert!((lightness - 100.0).abs() < 1e-3 && red_green.abs() < 1e-3 && blue_yellow.abs() < 1e-3);
        let [lightness, red_green, blue_yellow] = hunt_lab_from_linear([1.0; 3]);
        assert!((lightness - 100.0).abs() < 1e-3 && red_green.abs() < 1e-3 && blue_yellow.abs() < 1e-3);
        let color = [0.2, 0.7, 0.05];
        let back = linear_from_opponent(opponent_from_linear(color));
        assert!(color.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-5), "{back:?}");
    }

    #[test]
    fn hyab_adds_lightness_to_the_length_of_chroma() {
        // 2 + |(3, 4)| = 7.
        assert_eq!(hyab([5.0, 1.0, 1.0], [3.0, 4.0, 5.0]), 7.0);
    }
}
