//! Division of a still into tiles or into ranges of samples.

/// The pixels of each tile of a grid, row by row: first column and row, and the column and row after the last.
pub(super) fn tiles((width, height): (u32, u32), (columns, rows): (u32, u32)) -> Vec<[u32; 4]> {
    let (x, y) = (edges(width, columns), edges(height, rows));
    let row = |y: &[u32]| x.windows(2).map(|x| [x[0], y[0], x[1], y[1]]).collect::<Vec<_>>();
    y.windows(2).flat_map(row).collect()
}

/// The first and the last sample of each range.
pub(super) fn sample_ranges(samples: u32, count: u32) -> Vec<(u32, u32)> {
    edges(samples, count).windows(2).map(|ends| (ends[0], ends[1] - 1)).collect()
}

/// Ends of `count` parts of a length, at most one part a unit.
fn edges(length: u32, count: u32) -> Vec<u32> {
    let count = u64::from(count.clamp(1, length.max(1)));
    (0..=count).map(|part| (part * u64::from(length) / count) as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once() {
        for (size, grid) in [((64, 36), (2, 2)), ((7, 5), (3, 2)), ((2, 2), (5, 1)), ((1, 1), (1, 1))] {
            let mut seen = vec![0; (size.0 * size.1) as usize];
            for [x0, y0, x1, y1] in tiles(size, grid) {
                for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                    seen[(y * size.0 + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|count| *count == 1), "{size:?} {grid:?}");
        }
        assert_eq!(tiles((4, 2), (2, 1)), [[0, 0, 2, 2], [2, 0, 4, 2]]);
    }

    #[test]
    fn ranges_have_each_sample_once() {
        assert_eq!(sample_ranges(10, 3), [(0, 2), (3, 5), (6, 9)]);
        assert_eq!(sample_ranges(2, 9), [(0, 0), (1, 1)]);
    }
}
