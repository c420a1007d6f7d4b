//! Where samples lie inside a pixel.

use glam::Vec2;

/// `count` positions in the unit square: the same in every pixel and every frame, one in each of `count` columns and, for
/// powers of two, one in each of `count` rows (a Hammersley set). One sample lies in the middle.
pub(super) fn pixel_offsets(count: u32) -> Vec<Vec2> {
    let half_step = 0.5 / count as f32;
    let column = |i: u32| (i as f32 + 0.5) / count as f32;
    let row = |i: u32| {
        let row = radical_inverse(i) + half_step;
        if row < 1.0 { row } else { row - 1.0 }
    };
    (0..count).map(|i| Vec2::new(column(i), row(i))).collect()
}

/// The bits of `i` mirrored at the binary point.
fn radical_inverse(i: u32) -> f32 {
    // 24 bits fit a float exactly.
    (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_middle() {
        assert_eq!(pixel_offsets(1), [Vec2::splat(0.5)]);
    }

    #[test]
    fn each_row_and_column_has_one_sample() {
        for count in [2, 4, 16, 64] {
            let offsets = pixel_offsets(count);
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
    fn any_count_stays_inside_the_pixel() {
        for count in 1..70 {
            assert!(pixel_offsets(count).iter().all(|p| p.min_element() >= 0.0 && p.max_element() < 1.0));
        }
    }
}
