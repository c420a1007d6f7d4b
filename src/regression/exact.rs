//! Whether two pictures are the same to the last bit, and a hash that says so without the other picture.
//!
//! Renders are deterministic (docs/architecture.md), so this is the rule between runs of one version. Halves and floats of
//! equal value are the same; names of channels and windows count, attributes and compression do not.

use std::fmt::Write as _;

use sha2::{Digest as _, Sha256};

use super::{ChannelValues, LayeredPicture};

/// SHA-256 over windows, names and bits of all values, as hexadecimal digits.
pub fn pixel_hash(picture: &LayeredPicture) -> String {
    let mut hash = Sha256::new();
    let (whole, origin, size) = (picture.picture_size, picture.origin, picture.size);
    for number in [whole.0, whole.1, origin.0, origin.1, size.0, size.1] {
        hash.update(number.to_le_bytes());
    }
    for channel in &picture.channels {
        hash.update((channel.name.len() as u64).to_le_bytes());
        hash.update(channel.name.as_bytes());
        match &channel.values {
            ChannelValues::Numbers(values) => {
                hash.update(b"n");
                for value in values {
                    hash.update(value.to_bits().to_le_bytes());
                }
            }
            ChannelValues::Ids(values) => {
                hash.update(b"i");
                for value in values {
                    hash.update(value.to_le_bytes());
                }
            }
        }
    }
    hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Whether all bits agree; a value that is not a number equals one of the same bits.
pub fn are_identical(a: &LayeredPicture, b: &LayeredPicture) -> bool {
    let same_values = |a: &ChannelValues, b: &ChannelValues| match (a, b) {
        (ChannelValues::Numbers(a), ChannelValues::Numbers(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        }
        (ChannelValues::Ids(a), ChannelValues::Ids(b)) => a == b,
        _ => false,
    };
    (a.picture_size, a.origin, a.size) == (b.picture_size, b.origin, b.size)
        && a.channels.len() == b.channels.len()
        && a.channels
            .iter()
            .zip(&b.channels)
            .all(|(a, b)| a.name == b.name && same_values(&a.values, &b.values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::ValueRange;

    #[test]
    fn one_bit_changes_the_hash() {
        let picture = |value: f32| {
            LayeredPicture::of_pixels((1, 2), ValueRange::Light, &[[0.5; 4], [0.1, 0.2, value, 1.0]])
        };
        let next = f32::from_bits(0.3_f32.to_bits() + 1);
        assert!(are_identical(&picture(0.3), &picture(0.3)) && !are_identical(&picture(0.3), &picture(next)));
        assert_eq!(pixel_hash(&picture(0.3)), pixel_hash(&picture(0.3)));
        assert_ne!(pixel_hash(&picture(0.3)), pixel_hash(&picture(next)));
        // Zero and its negative are equal numbers and different bits.
        assert!(!are_identical(&picture(0.0), &picture(-0.0)));
        let turned = LayeredPicture { size: (2, 1), ..picture(0.3) };
        assert_ne!(pixel_hash(&picture(0.3)), pixel_hash(&turned));
        assert_eq!(pixel_hash(&turned).len(), 64);
    }
}
