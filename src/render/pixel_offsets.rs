//! Sample positions inside a pixel.

use std::ops::Range;

use glam::Vec2;

use super::shutter_sample::ShutterSample;
use crate::integrator::{R2, unit_interval};

/// `count` positions in the unit square, the same in every pixel and every frame: a Hammersley set, with one position in each of
/// `count` columns and, for powers of two, one in each of `count` rows. Their mean is the centre, so that no count moves the image.
///
/// Each set `set` is the first one, rotated around the square (by the R₂ sequence of Roberts, "The Unreasonable Effectiveness of
/// Quasirandom Sequences", 2018), and its mean is up to half a step from the centre: a set whose mean is the centre, too, would have the columns of
/// the first one. Set 0 is not rotated.
pub(super) fn pixel_offsets(count: u32, set: u32) -> Vec<Vec2> {
    let column = |i: u32| (i as f32 + 0.5) / count as f32;
    let shift_of_rows = shift_to_center(count, u32::reverse_bits);
    let row = |i: u32| inside(unit_interval(i.reverse_bits()) + shift_of_rows);
    let shift = Vec2::new(unit_interval(set.wrapping_mul(R2[0])), unit_interval(set.wrapping_mul(R2[1])));
    (0..count).map(|i| Vec2::new(wrapped(column(i) + shift.x), wrapped(row(i) + shift.y))).collect()
}

/// Some of the `count` positions in the unit square that one shutter sample has. The first of any number fill the square evenly, and so
/// do those of all shutter samples together: they are Sobol's points, whose third dimension is the time. The mean of all `count`
/// positions of all times is the centre, where the times are a power of two.
pub(super) fn progressive_offsets(indices: Range<u32>, count: u32, shutter: ShutterSample) -> Vec<Vec2> {
    let times = shutter.count.next_power_of_two();
    // Of other numbers of times some points are not used, and the mean of the others is a little beside the centre.
    let of_all_times = count.saturating_mul(times);
    let shift = Vec2::new(
        shift_to_center(of_all_times, u32::reverse_bits),
        shift_to_center(of_all_times, sobol_second),
    );
    let point = |i: u32| Vec2::new(unit_interval(i.reverse_bits()), unit_interval(sobol_second(i)));
    let index = |i: u32| index_at_time(i.wrapping_mul(times), shutter.index, times.trailing_zeros());
    indices.map(|i| point(index(i)) + shift).map(|p| Vec2::new(inside(p.x), inside(p.y))).collect()
}

/// What moves the mean of the first `count` values of a dimension of Sobol's sequence, in units of 2⁻³², to ½.
fn shift_to_center(count: u32, value: impl Fn(u32) -> u32) -> f32 {
    let (mut first, mut sum) = (0_u32, 0.0);
    for bits in (0..u32::BITS).rev().filter(|bits| (count >> bits) & 1 == 1) {
        // The leading digits of such a block take every value once; its indices have the others in common.
        let size = f64::from(1_u32 << bits);
        let in_common = f64::from(value(first) & (u32::MAX >> bits)) / 2_f64.powi(32);
        sum += size * (in_common + 0.5 - 0.5 / size);
        first |= 1 << bits;
    }
    (0.5 - sum / f64::from(count)) as f32
}

/// The index, of the 2^`bits` ones from `first`, of the point of Sobol's sequence whose third dimension is in the interval `time` of
/// 2^`bits` equal ones. `first` is a multiple of their number, so that each interval has one.
fn index_at_time(first: u32, time: u32, bits: u32) -> u32 {
    let mut index = first;
    // The directions are a unit triangular matrix: the last bit of the interval decides about the last direction.
    for bit in (0..bits).rev() {
        let differs = (sobol_third(index) >> (31 - bit)) ^ (time >> (bits - 1 - bit));
        index ^= (differs & 1) << bit;
    }
    index
}

/// The second dimension of Sobol's sequence, whose generator matrix is Pascal's triangle modulo 2.
fn sobol_second(mut index: u32) -> u32 {
    let (mut value, mut column) = (0, 1 << 31);
    while index > 0 {
        if index & 1 == 1 {
            value ^= column;
        }
        column ^= column >> 1;
        index >>= 1;
    }
    value
}

/// The third dimension of Sobol's sequence.
fn sobol_third(mut index: u32) -> u32 {
    let mut value = 0;
    while index > 0 {
        value ^= THIRD_DIRECTIONS[index.trailing_zeros() as usize];
        index &= index - 1;
    }
    value
}

/// Direction numbers of the third dimension, of the primitive polynomial x² + x + 1 and the initial numbers 1 and 3 (Joe & Kuo,
/// "Constructing Sobol Sequences with Better Two-Dimensional Projections", SIAM Journal on Scientific Computing 30, 2008).
const THIRD_DIRECTIONS: [u32; 32] = {
    let mut directions = [0; 32];
    directions[0] = 1 << 31;
    directions[1] = 3 << 30;
    let mut i = 2;
    while i < 32 {
        directions[i] = directions[i - 1] ^ directions[i - 2] ^ (directions[i - 2] >> 2);
        i += 1;
    }
    directions
};

/// The number, or the closest one in [0, 1). Positions that are moved until their mean is the centre may be outside by about a step.
fn inside(x: f32) -> f32 {
    x.clamp(0.0, 1.0 - f32::EPSILON / 2.0)
}

/// Wraps a number in [0, 2) to [0, 1).
fn wrapped(x: f32) -> f32 {
    if x < 1.0 { x } else { x - 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_center() {
        assert_eq!(pixel_offsets(1, 0), [Vec2::splat(0.5)]);
    }

    #[test]
    fn each_row_and_column_has_one_sample() {
        for count in [2, 4, 16, 64] {
            let offsets = pixel_offsets(count, 0);
            let cell = |x: f32| (x * count as f32) as u32;
            let mut columns: Vec<_> = offsets.iter().map(|offset| cell(offset.x)).collect();
            let mut rows: Vec<_> = offsets.iter().map(|offset| cell(offset.y)).collect();
            columns.sort_unstable();
            rows.sort_unstable();
            let all: Vec<_> = (0..count).collect();
            assert_eq!((columns, rows), (all.clone(), all));
        }
    }

    #[test]
    fn rotated_sets_have_columns_and_rows_of_their_own() {
        for (base, extra) in [(1, 1), (2, 2), (4, 4), (8, 8), (4, 12), (3, 5)] {
            let offsets = [pixel_offsets(base, 0), pixel_offsets(extra, 1 << 16)].concat();
            for axis in 0..2 {
                let mut along: Vec<f32> = offsets.iter().map(|p| p[axis]).collect();
                along.sort_unstable_by(f32::total_cmp);
                let closest = along.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f32::min);
                assert!(closest > 0.02 / (base + extra) as f32, "{base} {extra}: {closest}");
            }
        }
    }

    #[test]
    fn every_power_of_two_of_progressive_positions_is_even() {
        let offsets = progressive_offsets(0..256, 256, ShutterSample::ONLY);
        assert_eq!(progressive_offsets(17..40, 256, ShutterSample::ONLY), offsets[17..40]);
        for count in [4, 16, 64, 256] {
            // One position in each cell of a square grid.
            let side = (count as f32).sqrt();
            let cell = |p: &Vec2| (p.x * side) as usize * side as usize + (p.y * side) as usize;
            let mut cells: Vec<_> = offsets[..count].iter().map(cell).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn positions_of_any_count_stay_inside_the_pixel() {
        for count in 1..1100 {
            for set in [0, 1, 2, 77] {
                let shutter = ShutterSample { index: set, count: 78 };
                let whole = progressive_offsets(0..count, count, ShutterSample::ONLY);
                let of_one_time = progressive_offsets(0..count, count, shutter);
                let offsets = [pixel_offsets(count, set), whole, of_one_time].concat();
                assert!(offsets.iter().all(|p| p.min_element() >= 0.0 && p.max_element() < 1.0));
            }
        }
    }

    #[test]
    fn no_number_of_samples_moves_the_image() {
        let mean = |offsets: &[Vec2]| offsets.iter().sum::<Vec2>() / offsets.len() as f32;
        for count in 1..700 {
            let progressive = progressive_offsets(0..count, count, ShutterSample::ONLY);
            for offsets in [pixel_offsets(count, 0), progressive] {
                let distance = (mean(&offsets) - 0.5).abs().max_element();
                assert!(distance < 3e-4, "{count}: {distance}");
            }
        }
        for (count, times) in [(3, 4), (5, 2), (96, 8)] {
            assert!((mean(&of_all_times(0..count, count, times)) - 0.5).abs().max_element() < 1e-4);
        }
    }

    /// Positions that `times` shutter samples with `count` each have together.
    fn of_all_times(indices: Range<u32>, count: u32, times: u32) -> Vec<Vec2> {
        let of_time =
            |index| progressive_offsets(indices.clone(), count, ShutterSample { index, count: times });
        (0..times).flat_map(of_time).collect()
    }

    #[test]
    fn shutter_samples_share_the_positions_of_one_sequence() {
        let bits = |points: Vec<Vec2>| {
            let mut bits: Vec<_> = points.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
            bits.sort_unstable();
            bits
        };
        for (count, times) in [(1, 8), (2, 8), (8, 8), (16, 4), (1, 64), (64, 1), (5, 4)] {
            let whole = progressive_offsets(0..count * times, count * times, ShutterSample::ONLY);
            assert_eq!(bits(of_all_times(0..count, count, times)), bits(whole.clone()), "{count} x {times}");
            // So do the first ones of each, wherever a frame ends.
            let first = whole[..(count.div_ceil(2) * times) as usize].to_vec();
            assert_eq!(
                bits(of_all_times(0..count.div_ceil(2), count, times)),
                bits(first),
                "{count} x {times}"
            );
        }
    }

    #[test]
    fn positions_of_each_time_fill_the_pixel() {
        // Each sixteenth of the pixel has 4 ± 2 of the 64 positions of each time.
        for index in 0..8 {
            let mut cells = [0; 16];
            for p in progressive_offsets(0..64, 64, ShutterSample { index, count: 8 }) {
                cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
            }
            assert!(cells.iter().all(|count| (2..=6).contains(count)), "{index}: {cells:?}");
        }
    }

    #[test]
    fn numbers_of_times_between_powers_of_two_fill_the_pixel_too() {
        // Each sixteenth of the pixel has 6 ± 2 of the 96 positions of six times.
        let mut cells = [0; 16];
        for p in of_all_times(0..16, 16, 6) {
            cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|count| (4..=8).contains(count)), "{cells:?}");
    }
}
