//! Owen-scrambled Sobol points, ordered along a Z curve over the image, as a pure function of pixel, sample, dimension and seed.
//!
//! Samples of neighbouring pixels are neighbouring parts of one sequence, so that errors of nearby pixels differ and images look
//! less noisy (Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
//! Pixels", 2020; `ZSobolSampler` in Pharr, Jakob and Humphreys, "Physically Based Rendering", 2023, section 8.7). All dimensions
//! use the first two of Sobol's, shuffled and scrambled by a hash of the dimension.
//!
//! Departures: a shuffle permutes all base-4 digits of an index at once, as affine maps over GF(2)², whose coefficients are the
//! bits of a hash in which every bit depends on higher digits alone. It uses all 24 permutations, with chances between 1/32 and
//! 3/64 each. The image has no size here.

mod lanes;

use glam::Vec2;

pub(crate) use self::lanes::SequenceLanes;
use super::unit_interval::unit_interval;

/// The low bit of every base-4 digit.
const LOW_BITS: u64 = 0x5555_5555_5555_5555;

/// The sample points of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ZSobol {
    /// Base-4 digits for the samples of a pixel.
    sample_digits: u32,
    /// Whether the highest of these digits takes only the values 0 and 1.
    has_binary_digit: bool,
    seed: u32,
}

/// The sample points of all dimensions of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SampleSequence {
    /// Position along the Z curve, then in the pixel; base-4 digits, the highest one in the lowest bits.
    reversed_index: u64,
    /// The reversed index's digit that takes only the values 0 and 1, as a shift. 64 or more: there is none.
    binary_digit: u32,
    seed: u32,
}

impl ZSobol {
    /// Points for pixels that take up to `max_samples`. The count is rounded up to a power of two; the first samples of a pixel
    /// are well distributed at every power of four, and all samples together.
    pub(crate) fn new(max_samples: u32, seed: u32) -> Self {
        let bits = u32::BITS - max_samples.saturating_sub(1).leading_zeros();
        Self { sample_digits: bits.div_ceil(2), has_binary_digit: bits % 2 == 1, seed }
    }

    /// The points of a sample. Pixel coordinates are below 65536; samples beyond the count of [`ZSobol::new`] continue with an
    /// independent set.
    pub(crate) fn sequence(&self, (x, y): (u32, u32), sample: u32) -> SampleSequence {
        let digit_bits = 2 * self.sample_digits;
        let sample_bits = digit_bits - u32::from(self.has_binary_digit);
        let sample = u64::from(sample);
        let round = (sample >> sample_bits) as u32;
        let z_order = spread(x) | spread(y) << 1;
        let shifted = if digit_bits < u64::BITS { z_order << digit_bits } else { 0 };
        let index = shifted | sample & ((1 << sample_bits) - 1);
        SampleSequence {
            reversed_index: index.reverse_bits(),
            binary_digit: if self.has_binary_digit { u64::BITS - digit_bits } else { u64::BITS },
            seed: if round == 0 { self.seed } else { hash(self.seed ^ hash(round)) },
        }
    }
}

impl SampleSequence {
    /// A number in [0, 1): the first coordinate of [`SampleSequence::point`].
    pub(crate) fn number(&self, dimension: u32) -> f32 {
        self.number_by(&DimensionKeys::new(self.seed, dimension))
    }

    /// A point in the unit square, coordinates in [0, 1). The points of different dimensions are independent.
    pub(crate) fn point(&self, dimension: u32) -> Vec2 {
        self.point_by(&DimensionKeys::new(self.seed, dimension))
    }

    /// The seed of the keys of all dimensions.
    pub(crate) fn seed(&self) -> u32 {
        self.seed
    }

    /// [`SampleSequence::number`] of the dimension of `keys`, which are those of this seed.
    pub(crate) fn number_by(&self, keys: &DimensionKeys) -> f32 {
        unit_interval(scramble(bits_of_first_dimension(self.shuffled_index(keys.shuffle)), keys.x))
    }

    /// [`SampleSequence::point`] of the dimension of `keys`, which are those of this seed.
    pub(crate) fn point_by(&self, keys: &DimensionKeys) -> Vec2 {
        self.point_and_random_by(keys).0
    }

    /// [`SampleSequence::point`] of the dimension of `keys`, and a number in [0, 1) that is white noise, of 16 bits: those below the ones
    /// that the coordinates use, on which their scrambling depends.
    #[inline(always)]
    pub(crate) fn point_and_random_by(&self, keys: &DimensionKeys) -> (Vec2, f32) {
        let index = self.shuffled_index(keys.shuffle);
        let [x, y] = scrambled_bits(index, [keys.x, keys.y]);
        let left = (x & 0xFF) << 8 | y & 0xFF;
        (Vec2::new(unit_interval(x), unit_interval(y)), left as f32 / (1 << 16) as f32)
    }
}

impl SampleSequence {
    /// The index of the Sobol point: the digits of the Z order, each permuted by a hash of the key and of all higher digits.
    #[inline(always)]
    fn shuffled_index(&self, key: u64) -> u64 {
        // Hash the higher digits: multiplications and additions carry to higher bits, which hold the lower digits.
        let mut hashed = self.reversed_index << 2;
        hashed ^= hashed.wrapping_mul(0xD27E_53B6_4C8F_9A1A);
        hashed = hashed.wrapping_add(key).wrapping_mul(key.rotate_left(32) | 1);
        hashed ^= hashed.wrapping_mul(0x6A94_3E5D_B1C2_70F6);
        let translation = hashed ^ hashed.wrapping_mul(0x93B1_C6E8_2F5A_D47C);
        let second = next_hash(hashed, key.rotate_left(13));
        let third = next_hash(second, key.rotate_left(47));

        // Permute by shears and a translation of GF(2)². The sequences of shears reach all six invertible matrices.
        let binary_digit = self.binary_digit_mask();
        let (shears, moves) = (LOW_BITS & !binary_digit, !binary_digit);
        let mut index = self.reversed_index;
        index ^= (index & second & shears) << 1;
        index ^= (index >> 1) & (third | third >> 1) & shears;
        index ^= (index & (second >> 1) & shears) << 1;
        let index = (index ^ translation & moves).reverse_bits();

        // Remove the unused bit of the binary digit: those below it stay. Without such a digit all do.
        let low_bits = binary_digit.reverse_bits().wrapping_sub(1);
        index & low_bits | (index >> 1) & !low_bits
    }

    /// The lower bit of the binary digit; none where there is no such digit.
    #[inline(always)]
    fn binary_digit_mask(&self) -> u64 {
        if self.binary_digit < u64::BITS { 1 << self.binary_digit } else { 0 }
    }
}

/// Another hash of which every bit depends on no higher bit of `hashed`.
#[inline(always)]
fn next_hash(hashed: u64, key: u64) -> u64 {
    let mixed = (hashed ^ key).wrapping_mul(0xE703_7ED1_A0B4_28DB);
    mixed ^ mixed.wrapping_mul(0x58F3_8DED_9C4B_1E62)
}

/// Keys of the shuffle and of both scrambles of a dimension.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DimensionKeys {
    shuffle: u64,
    x: u32,
    y: u32,
}

impl DimensionKeys {
    /// The keys of a dimension of sequences with this seed.
    pub(crate) fn new(seed: u32, dimension: u32) -> Self {
        let shuffle = mix(u64::from(seed) << 32 | u64::from(dimension));
        let scrambles = mix(shuffle);
        Self { shuffle, x: scrambles as u32, y: (scrambles >> 32) as u32 }
    }
}

/// The bits of a coordinate of the unit interval, the highest one in bit 0: the radical inverse.
#[inline(always)]
fn bits_of_first_dimension(index: u64) -> u32 {
    index as u32
}

/// The same of Sobol's second dimension. Its matrix is Pascal's triangle modulo 2, the Kronecker power of (1 1; 0 1): bit i sums
/// the bits of `index` whose numbers contain those of i (Lucas' theorem).
#[inline(always)]
fn bits_of_second_dimension(mut index: u64) -> u32 {
    index ^= (index >> 1) & LOW_BITS;
    index ^= (index >> 2) & 0x3333_3333_3333_3333;
    index ^= (index >> 4) & 0x0F0F_0F0F_0F0F_0F0F;
    index ^= (index >> 8) & 0x00FF_00FF_00FF_00FF;
    index ^= (index >> 16) & 0x0000_FFFF_0000_FFFF;
    (index ^ index >> 32) as u32
}

/// A point in the unit square of Sobol's first two dimensions, scrambled by a key for each.
pub(super) fn scrambled_point(index: u64, keys: [u32; 2]) -> Vec2 {
    let [x, y] = scrambled_bits(index, keys);
    Vec2::new(unit_interval(x), unit_interval(y))
}

#[inline(always)]
fn scrambled_bits(index: u64, keys: [u32; 2]) -> [u32; 2] {
    [scramble(bits_of_first_dimension(index), keys[0]), scramble(bits_of_second_dimension(index), keys[1])]
}

/// Nested uniform scrambling (Owen, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences", 1995) by a hash in which no bit depends
/// on higher ones (Laine and Karras, "Stratified Sampling for Stochastic Transparency", 2011), with the constants of Vegdahl
/// ("Building a Better LK Hash", 2021). The most significant bit of the coordinate is bit 0 before and bit 31 after.
#[inline(always)]
pub(super) fn scramble(mut bits: u32, key: u32) -> u32 {
    bits ^= bits.wrapping_mul(0x3D20_ADEA);
    bits = bits.wrapping_add(key);
    bits = bits.wrapping_mul((key >> 16) | 1);
    bits ^= bits.wrapping_mul(0x0552_6C56);
    bits ^= bits.wrapping_mul(0x53A2_2864);
    bits.reverse_bits()
}

/// Moves the lower 16 bits to the even bits.
fn spread(bits: u32) -> u64 {
    let mut bits = u64::from(bits & 0xFFFF);
    bits = (bits | bits << 8) & 0x00FF_00FF;
    bits = (bits | bits << 4) & 0x0F0F_0F0F;
    bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & LOW_BITS
}

/// A bijection of 64 bits that flips about half of them (variant 13 of Stafford, "Better Bit Mixing", 2011).
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

/// A hash of 32 bits.
fn hash(x: u32) -> u32 {
    mix(u64::from(x)) as u32
}

#[cfg(test)]
mod tests;
