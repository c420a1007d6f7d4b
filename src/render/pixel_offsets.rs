//! Sample positions inside a pixel.

use std::ops::Range;

use glam::Vec2;

use crate::integrator::R2;

/// `count` positions in the unit square, the same in every pixel and every frame: a Hammersley set, with one position in each of
/// `count` columns and, for powers of two, one in each of `count` rows. A single position is the centre.
///
/// Each set `set` is the first one, rotated around the square so that all sets together fill it evenly (by the R₂ sequence of
/// Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018). Set 0 is not rotated.
pub(super) fn pixel_offsets(count: u32, set: u32) -> Vec<Vec2> {
    let half_step = 0.5 / count as f32;
    let column = |i: u32| (i as f32 + 0.5) / count as f32;
    let row = |i: u32| wrapped(radical_inverse(i) + half_step);
    let shift = Vec2::new(fraction(set.wrapping_mul(R2[0])), fraction(set.wrapping_mul(R2[1])));
    (0..count).map(|i| Vec2::new(wrapped(column(i) + shift.x), wrapped(row(i) + shift.y))).collect()
}

/// Some of `count` positions in the unit square of which the first of any number fill it evenly: Sobol's points, by their first two
/// dimensions. `set` rotates them as in [`pixel_offsets`].
pub(super) fn progressive_offsets(indices: Range<u32>, count: u32, set: u32) -> Vec<Vec2> {
    let half_step = 0.5 / count.next_power_of_two() as f32;
    let shift = Vec2::new(fraction(set.wrapping_mul(R2[0])), fraction(set.wrapping_mul(R2[1]))) + half_step;
    let point = |i: u32| Vec2::new(radical_inverse(i), fraction(sobol_second(i))) + shift;
    indices.map(point).map(|p| Vec2::new(wrapped(p.x), wrapped(p.y))).collect()
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

/// Wraps a number in [0, 2) to [0, 1).
fn wrapped(x: f32) -> f32 {
    if x < 1.0 { x } else { x - 1.0 }
}

/// The upper 24 bits, which a float holds exactly, as a fraction in [0, 1).
fn fraction(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// The radical inverse of `i` in base 2.
fn radical_inverse(i: u32) -> f32 {
    fraction(i.reverse_bits())
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
    fn every_power_of_two_of_progressive_positions_is_even() {
        let offsets = progressive_offsets(0..256, 256, 0);
        assert_eq!(progressive_offsets(17..40, 256, 0), offsets[17..40]);
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
    fn positions_of_any_count_and_set_stay_inside_the_pixel() {
        for count in 1..70 {
            for set in [0, 1, 2, 77] {
                let offsets = [pixel_offsets(count, set), progressive_offsets(0..count, count, set)].concat();
                assert!(offsets.iter().all(|p| p.min_element() >= 0.0 && p.max_element() < 1.0));
            }
        }
    }

    #[test]
    fn single_samples_of_many_sets_fill_the_pixel() {
        // Of 64 sets each sixteenth of the pixel gets 4 ± 2 samples.
        let mut cells = [0; 16];
        for set in 0..64 {
            let p = pixel_offsets(1, set)[0];
            cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|count| (2..=6).contains(count)), "{cells:?}");
    }
}
