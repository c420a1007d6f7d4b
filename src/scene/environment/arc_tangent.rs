//! The arc tangent of two coordinates: the same bits as [`libm::atan2f`], without its branches.
//!
//! The argument is reduced as there (FreeBSD's `s_atanf.c`): atan q = atan c + atan((q − c) / (1 + c q)) with c of 0, 1/2, 1, 3/2 or
//! infinity. The coefficients of numerator and denominator come from a table, which takes the place of five branches that
//! directions of all kinds make unpredictable.

/// Numerator and denominator of the reduced argument as factors of q and constants, and the arc tangent of c in two parts.
struct Reduction {
    numerator: [f32; 2],
    denominator: [f32; 2],
    high: f32,
    low: f32,
}

const fn reduction(numerator: [f32; 2], denominator: [f32; 2], high: f32, low: f32) -> Reduction {
    Reduction { numerator, denominator, high, low }
}

/// Reductions of the five intervals of q, with the rounded constants of `libm`. There are eight, so that a mask replaces the check of an index.
static REDUCTIONS: [Reduction; 8] = [
    reduction([1.0, 0.0], [0.0, 1.0], 0.0, 0.0),
    reduction([2.0, -1.0], [1.0, 2.0], 4.636_476e-1, 5.012_158_2e-9),
    reduction([1.0, -1.0], [1.0, 1.0], f32::from_bits(0x3f49_0fda), 3.774_894_7e-8),
    reduction([1.0, -1.5], [1.5, 1.0], 9.827_937e-1, 3.447_321_7e-8),
    INFINITE,
    INFINITE,
    INFINITE,
    INFINITE,
];
const INFINITE: Reduction = reduction([0.0, -1.0], [1.0, 0.0], f32::from_bits(0x3fc9_0fda), 7.549_789_4e-8);

/// Lower ends of the intervals of q after the first.
const LIMITS: [f32; 4] = [0.4375, 0.6875, 1.1875, 2.4375];
/// Quotients beyond this power of two, and below its inverse, are left to `libm`.
const MAX_QUOTIENT: f32 = (1 << 24) as f32;

/// [`libm::atan2f`].
#[inline(always)]
pub(super) fn atan2(y: f32, x: f32) -> f32 {
    if !is_reducible(y, x) {
        return libm::atan2f(y, x);
    }
    let q = (y / x).abs();
    let reaches = |limit: f32| usize::from(q >= limit);
    let interval = LIMITS.into_iter().map(reaches).sum::<usize>();
    by_reduction((y, x), q, &REDUCTIONS[interval & 7])
}

/// Whether [`atan2_reducible`] has the bits of [`atan2`]; not for coordinates that are almost zero beside the other one.
#[inline(always)]
pub(super) fn is_reducible(y: f32, x: f32) -> bool {
    // Not a number fails too.
    (1.0 / MAX_QUOTIENT..=MAX_QUOTIENT).contains(&(y / x).abs())
}

/// [`atan2`] where [`is_reducible`] is true, for loops over lanes: selections take the place of the table.
#[inline(always)]
pub(super) fn atan2_reducible(y: f32, x: f32) -> f32 {
    let q = (y / x).abs();
    let select = |[zero, half, one, three_halves, infinite]: [f32; 5]| {
        let below = if q >= LIMITS[0] { half } else { zero };
        let middle = if q >= LIMITS[1] { one } else { below };
        let above = if q >= LIMITS[2] { three_halves } else { middle };
        if q >= LIMITS[3] { infinite } else { above }
    };
    // Constants: of values in memory, the compiler would select the address, and load lane by lane.
    macro_rules! column {
        ($($field:tt)+) => {
            const {
                let [zero, half, one, three_halves, infinite, ..] = &REDUCTIONS;
                [zero.$($field)+, half.$($field)+, one.$($field)+, three_halves.$($field)+, infinite.$($field)+]
            }
        };
    }
    let selected = Reduction {
        numerator: [select(column!(numerator[0])), select(column!(numerator[1]))],
        denominator: [select(column!(denominator[0])), select(column!(denominator[1]))],
        high: select(column!(high)),
        low: select(column!(low)),
    };
    by_reduction((y, x), q, &selected)
}

/// The arc tangent by the reduction of the interval of `q`.
#[inline(always)]
fn by_reduction((y, x): (f32, f32), q: f32, reduction: &Reduction) -> f32 {
    const PI_LOW: f32 = -8.742_278e-8;
    let Reduction { numerator, denominator, high, low } = reduction;
    let t = (numerator[0] * q + numerator[1]) / (denominator[0] * q + denominator[1]);
    let z = t * t;
    let w = z * z;
    let odd = z * (3.333_332_8e-1 + w * (1.425_363_6e-1 + w * 6.168_760_7e-2));
    let even = w * (-1.999_915_8e-1 + w * -1.064_801_74e-1);
    let angle = high - ((t * (odd + even) - low) - t);
    let angle = if x < 0.0 { std::f32::consts::PI - (angle - PI_LOW) } else { angle };
    angle.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bits_are_those_of_libm() {
        let same = |y: f32, x: f32| {
            let (found, expected) = (atan2(y, x), libm::atan2f(y, x));
            assert!(
                found.to_bits() == expected.to_bits() || expected.is_nan(),
                "{y} {x}: {found} {expected}"
            );
            if is_reducible(y, x) {
                assert_eq!(atan2_reducible(y, x).to_bits(), found.to_bits(), "{y} {x}");
            }
        };
        let special =
            [0.0, 1.0, 1e-40, 1e-30, 1e-7, 0.4375, 0.6875, 1.1875, 2.4375, 1e7, 1e30, f32::INFINITY];
        for y in special {
            for x in special {
                for (y, x) in [(y, x), (-y, x), (y, -x), (-y, -x)] {
                    same(y, x);
                }
            }
            same(y, f32::NAN);
            same(f32::NAN, y);
        }
        // Quotients of all magnitudes, and the two coordinates of evenly spread directions
        for index in 0..400_000_u32 {
            let bits = index.wrapping_mul(0x9e37_79b9);
            let quotient = libm::exp2f((bits >> 12) as f32 / 16384.0 - 32.0);
            same(quotient, 1.0);
            same(quotient * 0.7, -0.7);
            let (sin, cos) = libm::sincosf(bits as f32 * 1.5e-9);
            same(sin, cos);
            same(sin * 0.9, cos * 0.9);
        }
    }
}
