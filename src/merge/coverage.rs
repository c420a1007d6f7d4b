//! Check that rectangles cover an image, each pixel once.
//!
//! The edges of all rectangles cut the image into bands of rows. A rectangle covers a band completely or not at all, so a
//! sweep from left to right over the rectangles of a band finds gaps and overlaps.

use crate::image::PixelWindow;

/// Why rectangles do not cover an image exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CoverageError {
    /// No rectangle covers these pixels.
    Gap(PixelWindow<i64>),
    /// Two rectangles, given by index, cover these pixels.
    Overlap(usize, usize, PixelWindow<i64>),
}

/// The first error from the top, and in its rows from the left; overlaps before gaps of the same band. All rectangles lie in
/// `image`.
pub(super) fn first_error(image: PixelWindow<i64>, rectangles: &[PixelWindow<i64>]) -> Option<CoverageError> {
    let mut edges: Vec<i64> = rectangles.iter().flat_map(|r| [r.y0, r.y1]).collect();
    edges.extend([image.y0, image.y1]);
    edges.sort_unstable();
    edges.dedup();
    let bands: Vec<(i64, i64)> = edges.windows(2).map(|rows| (rows[0], rows[1])).collect();

    let mut gap: Option<PixelWindow<i64>> = None;
    for (y0, y1) in bands {
        let mut present: Vec<usize> = (0..rectangles.len())
            .filter(|&index| rectangles[index].y0 <= y0 && y1 <= rectangles[index].y1)
            .collect();
        present.sort_by_key(|&index| (rectangles[index].x0, index));
        if gap.is_none()
            && let Some((first, second)) = overlapping(rectangles, &present)
        {
            let (a, b) = (rectangles[first], rectangles[second]);
            return Some(CoverageError::Overlap(first, second, a.intersection(&b)));
        }
        let missing = missing_spans(image, rectangles, &present);
        gap = match (gap, missing.first()) {
            (None, None) => None,
            (None, Some(&(x0, x1))) => Some(PixelWindow { x0, y0, x1, y1 }),
            // The gap continues downwards while all of its columns are missing.
            (Some(gap), _) if missing.contains(&(gap.x0, gap.x1)) => Some(PixelWindow { y1, ..gap }),
            (Some(gap), _) => return Some(CoverageError::Gap(gap)),
        };
    }
    gap.map(CoverageError::Gap)
}

/// The first two adjacent rectangles that share a column; `present` is sorted by the left edge.
fn overlapping(rectangles: &[PixelWindow<i64>], present: &[usize]) -> Option<(usize, usize)> {
    let pairs = present.windows(2).map(|pair| (pair[0], pair[1]));
    let mut overlapping = pairs.filter(|&(a, b)| rectangles[b].x0 < rectangles[a].x1);
    overlapping.next().map(|(a, b)| (a.min(b), a.max(b)))
}

/// Columns of the image that none of `present` covers.
fn missing_spans(
    image: PixelWindow<i64>,
    rectangles: &[PixelWindow<i64>],
    present: &[usize],
) -> Vec<(i64, i64)> {
    let mut spans = Vec::new();
    let mut filled = image.x0;
    for rectangle in present.iter().map(|&index| rectangles[index]) {
        if rectangle.x0 > filled {
            spans.push((filled, rectangle.x0));
        }
        filled = filled.max(rectangle.x1);
    }
    if filled < image.x1 {
        spans.push((filled, image.x1));
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn window(x0: i64, y0: i64, x1: i64, y1: i64) -> PixelWindow<i64> {
        PixelWindow { x0, y0, x1, y1 }
    }

    const IMAGE: PixelWindow<i64> = window(0, 0, 6, 4);

    #[test]
    fn complete_coverage_has_no_error() {
        assert_eq!(first_error(IMAGE, &[IMAGE]), None);
        // Two by three rectangles in any order, and bricks with offset edges.
        let mut grid = Vec::new();
        for (x, y) in [(2, 0), (0, 1), (1, 1), (0, 0), (2, 1), (1, 0)] {
            grid.push(window(2 * x, 2 * y, 2 * x + 2, 2 * y + 2));
        }
        assert_eq!(first_error(IMAGE, &grid), None);
        let bricks = [window(0, 1, 5, 4), window(0, 0, 3, 1), window(3, 0, 6, 1), window(5, 1, 6, 4)];
        assert_eq!(first_error(IMAGE, &bricks), None);
    }

    #[test]
    fn the_first_missing_rectangle_is_named() {
        assert_eq!(first_error(IMAGE, &[]), Some(CoverageError::Gap(IMAGE)));
        let rows = [window(0, 0, 6, 1), window(0, 2, 6, 4)];
        assert_eq!(first_error(IMAGE, &rows), Some(CoverageError::Gap(window(0, 1, 6, 2))));
        // Columns 2 and 3 of the upper rows and column 5 of all are missing; the former come first.
        let holes = [window(0, 0, 2, 4), window(4, 0, 5, 4), window(2, 2, 4, 4)];
        assert_eq!(first_error(IMAGE, &holes), Some(CoverageError::Gap(window(2, 0, 4, 2))));
        // A gap that widens downwards is reported for the rows of its first width.
        let steps = [window(0, 0, 3, 1), window(4, 0, 6, 4), window(0, 1, 2, 4)];
        assert_eq!(first_error(IMAGE, &steps), Some(CoverageError::Gap(window(3, 0, 4, 1))));
    }

    #[test]
    fn overlapping_pixels_are_named() {
        let twice = [window(0, 0, 4, 4), window(3, 1, 6, 3), window(4, 0, 6, 4)];
        assert_eq!(first_error(IMAGE, &twice), Some(CoverageError::Overlap(0, 1, window(3, 1, 4, 3))));
        assert_eq!(first_error(IMAGE, &[IMAGE, IMAGE]), Some(CoverageError::Overlap(0, 1, IMAGE)));
    }

    /// Reference implementation: counts the rectangles over each pixel.
    #[test]
    fn errors_equal_those_of_counting_pixels() {
        // A fixed pseudo-random sequence (linear congruential generator).
        let mut state = 1_u32;
        let mut below = |most: i64| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            i64::from(state >> 16) % most
        };
        let mut whole = 0;
        for round in 0..4000 {
            // Cuts the image into up to four parts and sometimes removes, adds or moves one.
            let (x, y) = (1 + below(5), 1 + below(3));
            let mut list =
                vec![window(0, 0, x, y), window(x, 0, 6, y), window(0, y, x, 4), window(x, y, 6, 4)];
            match round % 4 {
                1 => drop(list.remove(below(4) as usize)),
                2 => {
                    let x0 = below(5);
                    let y0 = below(3);
                    list.push(window(x0, y0, x0 + 1 + below(6 - x0), y0 + 1 + below(4 - y0)));
                }
                3 => list[0].x1 = 1 + below(5),
                _ => {}
            }
            let count = |x: i64, y: i64| {
                list.iter().filter(|r| r.x0 <= x && x < r.x1 && r.y0 <= y && y < r.y1).count()
            };
            let pixels = || (0..4).flat_map(|y| (0..6).map(move |x| (x, y)));
            let error = first_error(IMAGE, &list);
            match error {
                None => {
                    whole += 1;
                    assert!(pixels().all(|(x, y)| count(x, y) == 1), "{list:?}");
                }
                Some(CoverageError::Gap(gap)) => {
                    for (x, y) in
                        pixels().filter(|&(x, y)| gap.x0 <= x && x < gap.x1 && gap.y0 <= y && y < gap.y1)
                    {
                        assert_eq!(count(x, y), 0, "{list:?} {error:?}");
                    }
                }
                Some(CoverageError::Overlap(_, _, both)) => {
                    assert!(
                        count(both.x0, both.y0) > 1 && count(both.x1 - 1, both.y1 - 1) > 1,
                        "{list:?} {error:?}"
                    );
                }
            }
        }
        assert!((1000..3000).contains(&whole), "{whole}");
    }
}
