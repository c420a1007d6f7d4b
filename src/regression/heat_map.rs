//! The colour map of errors.
//!
//! Source: the perceptually uniform colour map *magma* of N. Smith and S. van der Walt (2015, CC0). 18 of its colours are interpolated
//! linearly, which deviates from it by at most three of 255 steps.

use super::FlipMap;

/// Every fifteenth colour of the 256, sRGB.
const MAGMA: [[u8; 3]; 18] = [
    [0, 0, 4],
    [9, 7, 32],
    [26, 16, 66],
    [49, 17, 101],
    [74, 16, 121],
    [98, 25, 128],
    [121, 34, 130],
    [145, 43, 129],
    [170, 51, 125],
    [194, 59, 117],
    [217, 70, 107],
    [236, 88, 96],
    [247, 114, 92],
    [252, 142, 100],
    [254, 170, 116],
    [254, 198, 138],
    [253, 226, 163],
    [252, 253, 191],
];

/// The colour of an error between 0 (black) and 1 (pale yellow).
pub fn magma(error: f32) -> [u8; 3] {
    let place = if error > 0.0 { error.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f32 } else { 0.0 };
    let below = (place as usize).min(MAGMA.len() - 2);
    let share = place - below as f32;
    [0, 1, 2].map(|channel| {
        let (from, to) = (f32::from(MAGMA[below][channel]), f32::from(MAGMA[below + 1][channel]));
        (from + (to - from) * share + 0.5) as u8
    })
}

/// The colours of all pixels of a map, opaque.
pub fn heat_map(map: &FlipMap) -> Vec<[u8; 4]> {
    let pixel = |&error: &f32| {
        let [r, g, b] = magma(error);
        [r, g, b, 255]
    };
    map.errors.iter().map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_run_from_black_to_pale_yellow_and_grow_lighter() {
        assert_eq!((magma(0.0), magma(1.0)), ([0, 0, 4], [252, 253, 191]));
        assert_eq!((magma(-1.0), magma(f32::NAN), magma(7.0)), ([0, 0, 4], [0, 0, 4], [252, 253, 191]));
        let lightness = |error: f32| {
            let [r, g, b] = magma(error).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((1..=100).all(|step| lightness(step as f32 / 100.0) > lightness((step - 1) as f32 / 100.0)));
    }
}
