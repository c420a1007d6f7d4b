//! Image coordinates of several directions at a time, equal bit by bit to those of single directions.
//!
//! The arc tangent is that of `libm` (FreeBSD's `s_atanf.c` and `e_atan2f.c`), with selections for its branches, so that
//! compilers turn the loops into vector code. Arguments that it treats apart are left to `libm`.

use std::f32::consts::PI;

/// Directions at a time.
pub(super) const LANES: usize = 16;
/// One number a direction.
pub(super) type Lanes = [f32; LANES];

/// The part of π beyond its nearest `f32`.
const PI_LOW: f32 = f32::from_bits(0xb3bb_bd2e);
/// Arc tangents of 1/2, 1, 3/2 and infinity, and the parts beyond them.
const HIGH: [f32; 4] = floats([0x3eed_6338, 0x3f49_0fda, 0x3f7b_985e, 0x3fc9_0fda]);
const LOW: [f32; 4] = floats([0x31ac_3769, 0x3322_2168, 0x3314_0fb4, 0x33a2_2168]);
/// Coefficients of the polynomial.
const POLYNOMIAL: [[f32; 4]; 2] =
    [floats([0x3eaa_aaa9, 0x3e11_f50d, 0x3d7c_ac25, 0]), floats([0xbe4c_ca98, 0xbdda_1247, 0, 0])];
/// Ratios beyond which `libm` takes other branches.
const LARGE: f32 = (1_u32 << 26) as f32;
const SMALL: f32 = 1.0 / (1_u32 << 25) as f32;

const fn floats(bits: [u32; 4]) -> [f32; 4] {
    let [a, b, c, d] = bits;
    [f32::from_bits(a), f32::from_bits(b), f32::from_bits(c), f32::from_bits(d)]
}

/// Image coordinates of unit directions; see [`super::equirect::uv_from_direction`].
#[inline(always)]
pub(super) fn uvs_from_directions([x, y, z]: &[Lanes; 3]) -> [Lanes; 2] {
    let behind = z.map(|z| -z);
    let mut horizontal = [0.0; LANES];
    for ((horizontal, x), z) in horizontal.iter_mut().zip(x).zip(z) {
        *horizontal = (x * x + z * z).sqrt();
    }
    let (azimuths, polars) = (atan2(x, &behind), atan2(&horizontal, y));
    [azimuths.map(|azimuth| 0.5 + azimuth / (2.0 * PI)), polars.map(|polar| polar / PI)]
}

/// `libm::atan2f` of each pair.
#[inline(always)]
fn atan2(y: &Lanes, x: &Lanes) -> Lanes {
    let (mut angles, mut is_ordinary) = ([0.0; LANES], true);
    for ((result, &y), &x) in angles.iter_mut().zip(y).zip(x) {
        let ratio = (y / x).abs();
        // Neither number is zero where this holds.
        is_ordinary &= (SMALL..LARGE).contains(&ratio);
        let angle = atan(ratio);
        let angle = if x.is_sign_negative() { PI - (angle - PI_LOW) } else { angle };
        *result = if y.is_sign_negative() { -angle } else { angle };
    }
    if !is_ordinary {
        for ((result, &y), &x) in angles.iter_mut().zip(y).zip(x) {
            *result = libm::atan2f(y, x);
        }
    }
    angles
}

/// `libm::atanf` of a number between [`SMALL`] and [`LARGE`].
#[inline(always)]
fn atan(x: f32) -> f32 {
    let (is_first, is_second, is_third) = (x < 0.6875, x < 1.1875, x < 2.4375);
    let select = |values: [f32; 4]| {
        let upper = if is_third { values[2] } else { values[3] };
        let lower = if is_first { values[0] } else { values[1] };
        if is_second { lower } else { upper }
    };
    let is_reduced = x >= 0.4375;
    let numerator = select([2.0 * x - 1.0, x - 1.0, x - 1.5, -1.0]);
    let denominator = select([2.0 + x, x + 1.0, 1.0 + 1.5 * x, x]);
    let reduced = if is_reduced { numerator / denominator } else { x };
    let z = reduced * reduced;
    let w = z * z;
    let [odd, even] = POLYNOMIAL;
    let rest = reduced * (z * (odd[0] + w * (odd[1] + w * odd[2])) + w * (even[0] + w * even[1]));
    let plain = if x < 1.0 / 4096.0 { x } else { x - rest };
    let shifted = select(HIGH) - ((rest - select(LOW)) - reduced);
    if is_reduced { shifted } else { plain }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::equirect::uv_from_direction;
    use super::*;

    #[test]
    fn arc_tangents_are_those_of_libm() {
        let mut values = vec![0.0_f32, -0.0, 1.0, -1.0, f32::INFINITY, f32::NAN, 1e-40, 3e38];
        for exponent in -40..40 {
            for mantissa in [1.0, 1.000_000_1, 1.187_5, 1.375, 1.4375, 1.75, 1.9999] {
                let value = mantissa * libm::exp2f(exponent as f32);
                values.extend([value, -value]);
            }
        }
        for &y in &values {
            for x in values.chunks(LANES) {
                let mut lanes = [0.3; LANES];
                lanes[..x.len()].copy_from_slice(x);
                let found = atan2(&[y; LANES], &lanes);
                for (found, x) in found.into_iter().zip(lanes) {
                    let expected = libm::atan2f(y, x);
                    let is_equal =
                        found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
                    assert!(is_equal, "{y} {x}: {found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn coordinates_are_those_of_single_directions() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for _ in 0..4000 {
            let directions: [Vec3; LANES] =
                std::array::from_fn(|_| Vec3::new(random(), random(), random()).normalize_or(Vec3::Y));
            let component = |axis: usize| directions.map(|direction| direction[axis]);
            let [u, v] = uvs_from_directions(&[component(0), component(1), component(2)]);
            for (lane, direction) in directions.into_iter().enumerate() {
                assert_eq!([u[lane], v[lane]], uv_from_direction(direction).to_array(), "{direction}");
            }
        }
    }
}
