//! Bitwise equality of images, and a hash of their pixels.
//!
//! Renders of one version are deterministic (docs/architecture.md) and must be equal. Halves and floats of equal value are equal.
//! Channel names and windows count; attributes and compression do not.

use std::fmt::Write as _;

use sha2::{Digest as _, Sha256};

use super::{Image, Samples};

/// SHA-256 over windows, names and bits of all values, and the content that the file lists, as hexadecimal digits.
pub fn pixel_hash(image: &Image) -> String {
    let mut hash = Sha256::new();
    let (whole, data) = (image.display_window.size(), image.data_window);
    for number in [whole.0, whole.1, data.x0, data.y0, data.width(), data.height()] {
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
    if let Some(content) = &image.scene.content {
        hash.update(content.text().as_bytes());
    }
    hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
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
    use crate::image::PixelWindow;
    use crate::regression::ColorEncoding;

    #[test]
    fn one_bit_changes_the_hash() {
        let image =
            |value: f32| Image::from_rgba((1, 2), ColorEncoding::Linear, &[[0.5; 4], [0.1, 0.2, value, 1.0]]);
        let next = f32::from_bits(0.3_f32.to_bits() + 1);
        assert!(are_identical(&image(0.3), &image(0.3)) && !are_identical(&image(0.3), &image(next)));
        assert_eq!(pixel_hash(&image(0.3)), pixel_hash(&image(0.3)));
        assert_ne!(pixel_hash(&image(0.3)), pixel_hash(&image(next)));
        // Zero and its negative are equal numbers and different bits.
        assert!(!are_identical(&image(0.0), &image(-0.0)));
        let turned = Image { data_window: PixelWindow::full(2, 1), ..image(0.3) };
        assert_ne!(pixel_hash(&image(0.3)), pixel_hash(&turned));
        assert_eq!(pixel_hash(&turned).len(), 64);
    }
}
