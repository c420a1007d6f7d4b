//! Bitwise equality of images, and a hash of their pixels.
//!
//! Renders of one version are deterministic (docs/architecture.md) and must be equal. Halves and floats of equal value are equal.
//! Channel names and windows count; attributes and compression do not.

use std::fmt::Write as _;

use sha2::{Digest as _, Sha256};

use super::{Image, Samples};
use crate::image::PartHashes;

/// SHA-256 over windows, names and bits of all values, and what a file that lists its content tells of the scene, as hexadecimal digits.
pub fn pixel_hash(image: &Image) -> String {
    let mut hash = hash_of_values(image);
    if let Some(content) = &image.scene.content {
        hash.update(content.text().as_bytes());
        let parts = image.scene.parts.as_ref().map(PartHashes::text);
        hash.update(parts.unwrap_or_default().as_bytes());
    }
    digits(hash)
}

/// [`pixel_hash`] without the scene, of which references of earlier versions tell less.
pub(super) fn value_hash(image: &Image) -> String {
    digits(hash_of_values(image))
}

fn digits(hash: Sha256) -> String {
    hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn hash_of_values(image: &Image) -> Sha256 {
    let mut hash = Sha256::new();
    let (whole, first, size) = (image.display_window.size(), image.position(), image.size());
    // Two's complement keeps pixels before the display window apart.
    for number in [whole.0, whole.1, first.0 as u32, first.1 as u32, size.0, size.1] {
        hash.update(number.to_le_bytes());
    }
    for channel in &image.channels {
        hash.update((channel.name.len() as u64).to_le_bytes());
        hash.update(channel.name.as_bytes());
        if let Samples::Uint(values) = &channel.samples {
            hash.update(b"i");
            for value in values {
                hash.update(value.to_le_bytes());
            }
        }
        if let Some(values) = channel.samples.floats() {
            hash.update(b"n");
            for value in values.iter() {
                hash.update(value.to_bits().to_le_bytes());
            }
        }
    }
    hash
}

/// Whether all bits and their encoding are equal. A NaN equals a NaN of the same bits.
pub fn are_identical(a: &Image, b: &Image) -> bool {
    let same_samples = |a: &Samples, b: &Samples| match (a.floats(), b.floats()) {
        (Some(a), Some(b)) => {
            a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| a.to_bits() == b.to_bits())
        }
        (None, None) => a == b,
        _ => false,
    };
    (a.display_window, a.data_window, a.encoding) == (b.display_window, b.data_window, b.encoding)
        && a.channels.len() == b.channels.len()
        && a.channels
            .iter()
            .zip(&b.channels)
            .all(|(a, b)| a.name == b.name && same_samples(&a.samples, &b.samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{PixelWindow, SceneContent};
    use crate::regression::{ColorEncoding, Preset, compare};

    #[test]
    fn one_bit_changes_the_hash() {
        let image =
            |value: f32| Image::from_rgba((1, 2), ColorEncoding::Linear, &[[0.5; 4], [0.1, 0.2, value, 1.0]]);
        let next = f32::from_bits(0.3_f32.to_bits() + 1);
        assert!(are_identical(&image(0.3), &image(0.3)) && !are_identical(&image(0.3), &image(next)));
        assert_eq!(pixel_hash(&image(0.3)), pixel_hash(&image(0.3)));
        assert_ne!(pixel_hash(&image(0.3)), pixel_hash(&image(next)));
        let mut told = image(0.3);
        told.scene.content = Some(SceneContent::default());
        assert_ne!(pixel_hash(&told), pixel_hash(&image(0.3)));
        assert_eq!(value_hash(&told), value_hash(&image(0.3)));
        assert_ne!(value_hash(&image(0.3)), value_hash(&image(next)));
        // Zero and its negative are equal numbers and different bits.
        assert!(!are_identical(&image(0.0), &image(-0.0)));
        let turned = Image { data_window: PixelWindow::full(2, 1), ..image(0.3) };
        assert_ne!(pixel_hash(&image(0.3)), pixel_hash(&turned));
        assert_eq!(pixel_hash(&turned).len(), 64);
    }

    #[test]
    fn overscan_of_another_side_is_another_window() {
        let image = |display_x0: u32, red: f32| {
            let mut pixels = [[0.25, 0.5, 0.75, 1.0]; 15 * 8];
            pixels[0][0] = red;
            let image = Image::from_rgba((15, 8), ColorEncoding::Linear, &pixels);
            let display_window = PixelWindow { x0: display_x0, y0: 0, x1: display_x0 + 12, y1: 8 };
            Image { display_window, ..image }
        };
        let limits = Preset::Exact.limits();
        assert!(compare(&image(3, 0.25), &image(3, 0.25), &limits).passes());
        // The first pixel is left of the display window.
        assert!(!compare(&image(3, 0.3), &image(3, 0.25), &limits).passes());
        let (left, right) = (image(3, 0.25), image(0, 0.25));
        assert!(!are_identical(&left, &right) && pixel_hash(&left) != pixel_hash(&right));
        let said = compare(&left, &right, &Preset::Noisy.limits()).failures().join("\n");
        let expected = "holds 15x8 pixels from column -3, row 0, the reference 15x8 from column 0, row 0";
        assert!(said.contains(expected), "{said}");
    }
}
