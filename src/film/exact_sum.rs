//! Sums of floats that do not depend on the order of the additions.

/// Binary digits after the point.
const FRACTION_BITS: i32 = 64;

/// Largest magnitude of a value, 1.4·10¹⁴: that of 2¹⁶ values is still in range.
const LARGEST: f32 = (1_u64 << 47) as f32;

/// Scale of squares, whose range is larger than that of values.
const SQUARE_SCALE: f64 = 1.0 / (1 << 16) as f64;

/// A sum of floats in fixed point with 64 digits before the point and 64 after it, two's complement.
///
/// A float is clamped to ±2⁴⁷ and rounded towards zero to a multiple of 2⁻⁶⁴ once; additions are exact. So parts of a sum of up to 2¹⁶ floats can be
/// added apart, in any order, and give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactSum(i128);

impl ExactSum {
    /// Number of 32-bit words of a sum.
    pub const WORDS: usize = 4;

    /// Adds a float; NaN counts as 0.
    #[inline]
    pub fn add(&mut self, value: f32) {
        self.add_f64(f64::from(value.clamp(-LARGEST, LARGEST)));
    }

    /// Adds the square of a float to a sum of squares, which [`ExactSum::squares_to_f64`] returns. It has 48 digits after the point and stays at 2⁷⁹.
    #[inline]
    pub fn add_square(&mut self, value: f32) {
        // The square of 24 binary digits has 48, which a double holds.
        let value = f64::from(value.clamp(-LARGEST, LARGEST));
        self.add_f64(value * value * SQUARE_SCALE);
    }

    #[inline]
    fn add_f64(&mut self, value: f64) {
        const SCALE: f64 = (1_u128 << FRACTION_BITS) as f64;
        self.0 = self.0.saturating_add((value * SCALE) as i128);
    }

    /// The sum of squares, rounded.
    pub fn squares_to_f64(self) -> f64 {
        self.to_f64() / SQUARE_SCALE
    }

    /// Adds another sum.
    #[inline]
    pub fn merge(&mut self, other: Self) {
        self.0 = self.0.saturating_add(other.0);
    }

    /// The sum, rounded.
    pub fn to_f64(self) -> f64 {
        const UNIT: f64 = 1.0 / (1_u128 << FRACTION_BITS) as f64;
        self.0 as f64 * UNIT
    }

    /// The bits of the sum, the lowest word first.
    pub fn to_words(self) -> [u32; Self::WORDS] {
        [0, 32, 64, 96].map(|shift| (self.0 >> shift) as u32)
    }

    /// The sum of these bits.
    pub fn from_words(words: [u32; Self::WORDS]) -> Self {
        Self(words.iter().rev().fold(0, |bits, &word| bits << 32 | i128::from(word)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(values: &[f32]) -> ExactSum {
        let mut sum = ExactSum::default();
        for &value in values {
            sum.add(value);
        }
        sum
    }

    #[test]
    fn small_values_beside_large_ones_count() {
        // In floats, 1e8 + 0.25 is 1e8.
        assert_eq!(sum(&[1e8, 0.25, 0.25, -1e8]).to_f64(), 0.5);
        assert_eq!(sum(&[1e-6; 1000]).to_f64() as f32, 1e-3);
    }

    #[test]
    fn parts_in_any_order_give_the_same_bits() {
        let values: Vec<f32> = (0..100).map(|i| libm::expf((i * 37 % 100) as f32 * 0.3 - 15.0)).collect();
        let whole = sum(&values);
        for split in [1, 17, 50, 99] {
            let (first, second) = values.split_at(split);
            let mut parts = sum(second);
            parts.merge(sum(first));
            assert_eq!(parts, whole);
            assert_eq!(ExactSum::from_words(parts.to_words()), whole);
        }
    }

    #[test]
    fn negative_sums_and_squares_survive_their_words() {
        let sum = sum(&[-3.5]);
        assert_eq!(ExactSum::from_words(sum.to_words()), sum);
        let mut squares = ExactSum::default();
        squares.add_square(-1.5);
        assert_eq!(squares.squares_to_f64(), 2.25);
    }

    #[test]
    fn values_beyond_the_range_are_clamped_before_they_are_added() {
        assert_eq!(sum(&[f32::INFINITY]), sum(&[f32::MAX]));
        assert_eq!(sum(&[f32::NAN]), ExactSum::default());
        // Whatever their order
        assert_eq!(sum(&[f32::MAX, f32::MAX, -f32::MAX, 1.0]), sum(&[-f32::MAX, 1.0, f32::MAX, f32::MAX]));
    }

    #[test]
    fn squares_of_suns_are_in_range() {
        let mut squares = ExactSum::default();
        for _ in 0..4096 {
            squares.add_square(1.6e9);
        }
        assert!((squares.squares_to_f64() / (4096.0 * 2.56e18) - 1.0).abs() < 1e-6);
    }
}
