//! First mip levels of eight-bit images, sixteen texels at a time: the loops of [`super::mip_maps`] over blocks, which the compiler turns into
//! vector instructions. They give the same bits.

use glam::{Vec3, Vec4};

use crate::geometry::{LANES, normalized_or};

/// Channels of a texel.
const CHANNELS: usize = 4;
/// Texels of the image above a row of a block.
const SOURCE_TEXELS: usize = 2 * LANES;

/// Linear channels of texels.
pub(super) type Values<const N: usize> = [[f32; CHANNELS]; N];
/// Encoded texels.
pub(super) type Codes<const N: usize> = [[u8; CHANNELS]; N];

/// Two rows of an image, and the row of the next level that they become.
pub(super) struct RowPair<'a, T> {
    pub(super) above: &'a [T],
    pub(super) below: &'a [T],
    pub(super) means: &'a mut [Vec4],
    pub(super) encoded: &'a mut [T],
}

impl RowPair<'_, [u8; CHANNELS]> {
    /// Fills whole blocks, and returns the number of texels.
    #[inline(always)]
    pub(super) fn fill_blocks(
        self,
        decode: impl Fn(&Codes<SOURCE_TEXELS>) -> Values<SOURCE_TEXELS>,
        encode: impl Fn(&Values<LANES>) -> Codes<LANES>,
    ) -> usize {
        let Self { above, below, means, encoded } = self;
        let (means, _) = means.as_chunks_mut::<LANES>();
        let (encoded, _) = encoded.as_chunks_mut::<LANES>();
        let rows = above.as_chunks::<SOURCE_TEXELS>().0.iter().zip(below.as_chunks::<SOURCE_TEXELS>().0);
        let mut filled = 0;
        for ((above, below), (means, encoded)) in rows.zip(means.iter_mut().zip(encoded)) {
            let (above, below) = (decode(above), decode(below));
            let mut sums = [[0.0_f32; CHANNELS]; LANES];
            for (texel, sum) in sums.iter_mut().enumerate() {
                for (channel, sum) in sum.iter_mut().enumerate() {
                    for value in
                        [&above[2 * texel], &above[2 * texel + 1], &below[2 * texel], &below[2 * texel + 1]]
                    {
                        *sum += value[channel] * 0.25;
                    }
                }
            }
            *encoded = encode(&sums);
            for (mean, sum) in means.iter_mut().zip(sums) {
                *mean = Vec4::from_array(sum);
            }
            filled += LANES;
        }
        filled
    }
}

/// Shares of the largest code.
#[inline(always)]
pub(super) fn shares<const N: usize>(codes: &Codes<N>) -> Values<N> {
    each(codes, |texel| each(&texel, share_of))
}

/// `code / 255`, in the same bits: the first product is exact, and the second so small that the sum is rounded as the quotient is.
#[inline(always)]
pub(super) fn share_of(code: u8) -> f32 {
    const HIGH: f32 = 257.0 / 65536.0;
    const LOW: f32 = (1.0 / 255.0 - 257.0 / 65536.0_f64) as f32;
    f32::from(code) * HIGH + f32::from(code) * LOW
}

/// Codes of shares, which saturate.
#[inline(always)]
pub(super) fn codes<const N: usize>(shares: &Values<N>) -> Codes<N> {
    each(shares, |texel| each(&texel, code_of))
}

/// The code of a share of the largest one. The cast saturates.
#[inline(always)]
pub(super) fn code_of(share: f32) -> u8 {
    (share * 255.0 + 0.5) as u8
}

/// Maps an array, as a loop that is vectorised.
#[inline(always)]
pub(super) fn each<A: Copy, B: Copy + Default, const N: usize>(
    of: &[A; N],
    value: impl Fn(A) -> B,
) -> [B; N] {
    let mut values = [B::default(); N];
    for (slot, &element) in values.iter_mut().zip(of) {
        *slot = value(element);
    }
    values
}

/// Unit vectors of the texels of a normal map; zero for those without a direction.
#[inline(always)]
pub(super) fn directions<const N: usize>(codes: &Codes<N>) -> Values<N> {
    let mut values = shares(codes);
    normalize(&mut values, |[x, y, z]| Vec3::new(x, y, z) * 2.0 - Vec3::ONE, Vec3::ZERO);
    values
}

/// Codes of mean directions, which are stored at unit length.
#[inline(always)]
pub(super) fn direction_codes<const N: usize>(means: &Values<N>) -> Codes<N> {
    let mut values = *means;
    normalize(&mut values, Vec3::from_array, Vec3::Z);
    for value in &mut values {
        for channel in &mut value[..3] {
            *channel = *channel * 0.5 + 0.5;
        }
    }
    codes(&values)
}

/// Replaces the first three channels of each value by the unit vector along what `vector` makes of them.
#[inline(always)]
fn normalize<const N: usize>(values: &mut Values<N>, vector: impl Fn([f32; 3]) -> Vec3, fallback: Vec3) {
    let (mut x, mut y, mut z) = ([0.0; N], [0.0; N], [0.0; N]);
    for i in 0..N {
        [x[i], y[i], z[i]] = [values[i][0], values[i][1], values[i][2]];
    }
    for i in 0..N {
        let unit = normalized_or(vector([x[i], y[i], z[i]]), fallback);
        (x[i], y[i], z[i]) = (unit.x, unit.y, unit.z);
    }
    for i in 0..N {
        values[i] = [x[i], y[i], z[i], values[i][3]];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_the_bits_of_quotients() {
        for code in 0..=u8::MAX {
            assert_eq!(share_of(code).to_bits(), (f32::from(code) / 255.0).to_bits());
            assert_eq!(code_of(share_of(code)), code);
        }
    }
}
