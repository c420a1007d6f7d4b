//! Sample positions inside a pixel.

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
    fn positions_of_any_count_and_set_stay_inside_the_pixel() {
        for count in 1..70 {
            for set in [0, 1, 2, 77] {
                let offsets = pixel_offsets(count, set);
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
