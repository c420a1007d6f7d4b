//! Sine and cosine within one turn: the same bits as [`libm::sincosf`], without its branches.
//!
//! The argument is reduced as there (FreeBSD's `s_sinf.c`): by the nearest multiple of a quarter turn, as a double. Both polynomials are computed
//! and selected from, so that loops over lanes are vectorised and evenly spread angles mispredict no branch.

use std::f64::consts::FRAC_PI_2;

/// Ends of the intervals around the multiples of a quarter turn, as `libm` rounds them: π/4, 3π/4, 5π/4 and 7π/4.
const ENDS: [u32; 4] = [0x3f49_0fda, 0x4016_cbe3, 0x407b_53d1, 0x40af_eddf];

/// Sine and cosine of an angle from −2π to 2π, in radians.
#[inline(always)]
pub(crate) fn sin_cos_of_turn(radians: f32) -> (f32, f32) {
    let (angle, sign) = (radians.abs(), radians.to_bits() & 1 << 31);
    let quarter: u32 = ENDS.into_iter().map(|end| u32::from(angle.to_bits() > end)).sum();
    let rest = f64::from(angle) - f64::from(quarter as i32) * FRAC_PI_2;
    let (sine, cosine) = (sine_near_zero(rest), cosine_near_zero(rest));
    let is_crossed = quarter & 1 != 0;
    let (sine, cosine) = if is_crossed { (cosine, sine) } else { (sine, cosine) };
    // Sines are negative in the quarters 2 and 3, cosines in 1 and 2.
    let sine = f32::from_bits(sine.to_bits() ^ sign ^ (quarter & 2) << 30);
    let cosine = f32::from_bits(cosine.to_bits() ^ ((quarter + 1) & 2) << 30);
    (sine, cosine)
}

/// `k_sinf` of FreeBSD.
#[inline(always)]
fn sine_near_zero(x: f64) -> f32 {
    let z = x * x;
    let w = z * z;
    let high = -1.983_933_483_609_663_2e-4 + z * 2.718_311_493_989_822e-6;
    let s = z * x;
    ((x + s * (-1.666_666_664_162_655e-1 + z * 8.333_329_385_889_463e-3)) + s * w * high) as f32
}

/// `k_cosf` of FreeBSD.
#[inline(always)]
fn cosine_near_zero(x: f64) -> f32 {
    let z = x * x;
    let w = z * z;
    let high = -1.388_676_377_460_993e-3 + z * 2.439_044_879_627_741e-5;
    (((1.0 + z * -4.999_999_972_510_31e-1) + w * 4.166_662_332_373_906e-2) + (w * z) * high) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn all_bits_are_those_of_libm() {
        let same = |radians: f32| {
            for radians in [radians, -radians] {
                let (found, expected) = (sin_cos_of_turn(radians), libm::sincosf(radians));
                let bits = |(sine, cosine): (f32, f32)| (sine.to_bits(), cosine.to_bits());
                assert_eq!(bits(found), bits(expected), "{radians}: {found:?} {expected:?}");
                assert_eq!(bits(found), bits((libm::sinf(radians), libm::cosf(radians))), "{radians}");
            }
        };
        for bits in (0..=TAU.to_bits()).step_by(1009) {
            same(f32::from_bits(bits));
        }
        for end in ENDS.into_iter().chain([0, 0x3980_0000, TAU.to_bits() - 8]) {
            for bits in end.saturating_sub(8)..=end + 8 {
                same(f32::from_bits(bits));
            }
        }
    }
}
