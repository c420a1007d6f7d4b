//! How one picture differs from another.

use super::Picture;

/// How far a channel may be from its reference before its pixel counts as different, and how many pixels may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest difference that never counts.
    pub absolute: f32,
    /// Largest difference that does not count, as a share of the reference's magnitude.
    pub relative: f32,
    /// Pixels that may be different.
    pub different_pixels: usize,
}

impl Tolerance {
    /// Every bit counts: the rule for pictures of one version of the program.
    pub const EXACT: Self = Self { absolute: 0.0, relative: 0.0, different_pixels: 0 };
}

/// What a comparison counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Differences {
    /// Pixels with a channel beyond the tolerance.
    pub different_pixels: usize,
    /// By channel, R, G, B, A: values beyond the absolute tolerance.
    pub beyond_absolute: [usize; 4],
    /// By channel: values beyond the relative tolerance.
    pub beyond_relative: [usize; 4],
    /// By channel: the largest absolute difference.
    pub largest: [f32; 4],
    /// Column and row of the pixel with the largest difference.
    pub largest_at: (u32, u32),
}

/// The result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Every value is the same to the last bit.
    Identical,
    /// Values differ, but not more than allowed.
    Close(Differences),
    /// More pixels differ than allowed.
    Different(Differences),
    /// One of the pictures holds values that are infinite or not a number.
    NotFinite {
        /// Pixels of the picture that was made.
        actual_pixels: usize,
        /// Pixels of the reference.
        reference_pixels: usize,
    },
    /// The pictures have different sizes.
    SizeDiffers {
        /// Of the picture that was made.
        actual: (u32, u32),
        /// Of the reference.
        reference: (u32, u32),
    },
}

impl Verdict {
    /// Whether the picture passes.
    pub fn is_pass(&self) -> bool {
        matches!(self, Self::Identical | Self::Close(_))
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Identical => write!(formatter, "identical"),
            Self::Close(found) | Self::Different(found) => write!(
                formatter,
                "{} pixels differ, by at most R {} G {} B {} A {}, most at column {}, row {}",
                found.different_pixels,
                found.largest[0],
                found.largest[1],
                found.largest[2],
                found.largest[3],
                found.largest_at.0,
                found.largest_at.1,
            ),
            Self::NotFinite { actual_pixels, reference_pixels } => write!(
                formatter,
                "{actual_pixels} pixels are infinite or not a number ({reference_pixels} in the reference)"
            ),
            Self::SizeDiffers { actual, reference } => write!(
                formatter,
                "the size is {}x{}, the reference's {}x{}",
                actual.0, actual.1, reference.0, reference.1
            ),
        }
    }
}

/// Compares a picture with its reference: first whether both are whole, then whether all bits agree, then by how much
/// they differ.
pub fn compare(actual: &Picture, reference: &Picture, tolerance: &Tolerance) -> Verdict {
    if actual.size != reference.size || actual.pixels.len() != reference.pixels.len() {
        return Verdict::SizeDiffers { actual: actual.size, reference: reference.size };
    }
    let (actual_pixels, reference_pixels) = (actual.non_finite_pixels(), reference.non_finite_pixels());
    if actual_pixels + reference_pixels > 0 {
        return Verdict::NotFinite { actual_pixels, reference_pixels };
    }
    let bits =
        |picture: &Picture| picture.pixels.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
    if bits(actual) == bits(reference) {
        return Verdict::Identical;
    }
    let differences = count(actual, reference, tolerance);
    if differences.different_pixels > tolerance.different_pixels {
        Verdict::Different(differences)
    } else {
        Verdict::Close(differences)
    }
}

fn count(actual: &Picture, reference: &Picture, tolerance: &Tolerance) -> Differences {
    let mut found = Differences::default();
    let mut largest = 0.0;
    for (index, (ours, theirs)) in actual.pixels.iter().zip(&reference.pixels).enumerate() {
        let mut differs = false;
        for channel in 0..4 {
            let difference = (ours[channel] - theirs[channel]).abs();
            let beyond_absolute = difference > tolerance.absolute;
            let beyond_relative = difference > tolerance.relative * theirs[channel].abs();
            found.beyond_absolute[channel] += usize::from(beyond_absolute);
            found.beyond_relative[channel] += usize::from(beyond_relative);
            differs |= beyond_absolute && beyond_relative;
            if difference > found.largest[channel] {
                found.largest[channel] = difference;
            }
            if difference > largest {
                largest = difference;
                let width = actual.size.0 as usize;
                found.largest_at = ((index % width) as u32, (index / width) as u32);
            }
        }
        found.different_pixels += usize::from(differs);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(values: [f32; 2]) -> Picture {
        Picture { size: (2, 1), pixels: values.map(|value| [value, 0.5, 0.25, 1.0]).to_vec() }
    }

    #[test]
    fn equal_pictures_are_identical() {
        let verdict = compare(&picture([0.1, 0.2]), &picture([0.1, 0.2]), &Tolerance::EXACT);
        assert_eq!(verdict, Verdict::Identical);
    }

    #[test]
    fn one_bit_is_a_difference_unless_tolerated() {
        let next = f32::from_bits(0.2_f32.to_bits() + 1);
        let verdict = compare(&picture([0.1, next]), &picture([0.1, 0.2]), &Tolerance::EXACT);
        let Verdict::Different(found) = verdict else {
            panic!("{verdict:?}");
        };
        assert_eq!(found.different_pixels, 1);
        assert_eq!(found.beyond_absolute, [1, 0, 0, 0]);
        assert_eq!(found.largest_at, (1, 0));
        let relative = Tolerance { relative: 1e-6, ..Tolerance::EXACT };
        let verdict = compare(&picture([0.1, next]), &picture([0.1, 0.2]), &relative);
        assert!(matches!(verdict, Verdict::Close(found) if found.different_pixels == 0), "{verdict:?}");
    }

    #[test]
    fn a_difference_must_exceed_both_tolerances() {
        // 0.01 of 10 is beyond 0.001 absolute but not beyond 0.2 % of 10; 0.01 of 0.1 is beyond both.
        let tolerance = Tolerance { absolute: 0.001, relative: 0.002, different_pixels: 0 };
        assert!(compare(&picture([10.01, 0.0]), &picture([10.0, 0.0]), &tolerance).is_pass());
        assert!(!compare(&picture([0.11, 0.0]), &picture([0.1, 0.0]), &tolerance).is_pass());
    }

    #[test]
    fn a_nan_fails_even_beside_a_nan() {
        let broken = picture([f32::NAN, 0.0]);
        let loose = Tolerance { absolute: f32::INFINITY, relative: f32::INFINITY, different_pixels: 9 };
        let verdict = compare(&broken, &broken, &loose);
        assert!(matches!(verdict, Verdict::NotFinite { actual_pixels: 1, reference_pixels: 1 }));
        assert!(!verdict.is_pass());
    }

    #[test]
    fn sizes_are_compared_first() {
        let other = Picture { size: (1, 2), ..picture([0.0; 2]) };
        assert!(matches!(
            compare(&picture([0.0; 2]), &other, &Tolerance::EXACT),
            Verdict::SizeDiffers { .. }
        ));
    }
}
