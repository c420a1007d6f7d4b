//! Image registration: the displacement of a whole image against another one.
//!
//! Whole pixels are searched exhaustively. Fractions are then solved for as by B. Lucas and T. Kanade, *An Iterative Image Registration
//! Technique with an Application to Stereo Vision*, IJCAI 1981, with one displacement for the whole image.

/// Search radius, pixels.
const REACH: i64 = 8;
/// Width of the ignored border, pixels. Everything inside it was inside the reference, too.
const MARGIN: i64 = REACH + 2;
/// Approximate number of compared pixels.
const SAMPLES: i64 = 40_000;

/// A displacement of the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// Displacement of the image against the reference to the right, pixels.
    pub right: f64,
    /// Displacement downwards, pixels.
    pub down: f64,
    /// Share of the squared difference that the displacement explains.
    pub explained: f64,
}

/// A greyscale image.
struct Grey<'a> {
    values: &'a [f32],
    width: i64,
}

impl Grey<'_> {
    fn at(&self, x: i64, y: i64) -> f64 {
        f64::from(self.values[(y * self.width + x) as usize])
    }

    /// The value between four pixels, by bilinear interpolation.
    fn interpolated(&self, x: f64, y: f64) -> f64 {
        let (left, top) = (x.floor(), y.floor());
        let (u, v) = (x - left, y - top);
        let (left, top) = (left as i64, top as i64);
        let row = |y: i64| self.at(left, y) * (1.0 - u) + self.at(left + 1, y) * u;
        row(top) * (1.0 - v) + row(top + 1) * v
    }
}

/// The displacement with the least squared difference. `None` when the images are too small, or equal.
pub fn best_shift(actual: &[f32], reference: &[f32], size: (u32, u32)) -> Option<Shift> {
    let (width, height) = (i64::from(size.0), i64::from(size.1));
    if width <= 4 * MARGIN || height <= 4 * MARGIN {
        return None;
    }
    let (actual, reference) = (Grey { values: actual, width }, Grey { values: reference, width });
    let step = (1..width.max(height)).find(|step| width * height / (step * step) <= SAMPLES).unwrap_or(1);
    let pixels: Vec<(i64, i64)> = (MARGIN..height - MARGIN)
        .step_by(step as usize)
        .flat_map(|y| (MARGIN..width - MARGIN).step_by(step as usize).map(move |x| (x, y)))
        .collect();
    let squared_difference = |right: f64, down: f64| -> f64 {
        let difference = |&(x, y): &(i64, i64)| {
            let difference = actual.at(x, y) - reference.interpolated(x as f64 - right, y as f64 - down);
            difference * difference
        };
        pixels.iter().map(difference).sum()
    };
    let unmoved = squared_difference(0.0, 0.0);
    if unmoved == 0.0 {
        return None;
    }
    let mut best = (unmoved, 0.0, 0.0);
    for (right, down) in (-REACH..=REACH).flat_map(|right| (-REACH..=REACH).map(move |down| (right, down))) {
        let (right, down) = (right as f64, down as f64);
        let sum = squared_difference(right, down);
        if sum < best.0 {
            best = (sum, right, down);
        }
    }
    for _ in 0..4 {
        let (right, down) = refined(&actual, &reference, &pixels, (best.1, best.2));
        let is_near = right.abs() <= REACH as f64 && down.abs() <= REACH as f64;
        let sum = if is_near { squared_difference(right, down) } else { best.0 };
        if sum >= best.0 {
            break;
        }
        best = (sum, right, down);
    }
    Some(Shift { right: best.1, down: best.2, explained: 1.0 - best.0 / unmoved })
}

/// One Gauss–Newton step from a displacement towards the nearest minimum.
fn refined(actual: &Grey<'_>, reference: &Grey<'_>, pixels: &[(i64, i64)], from: (f64, f64)) -> (f64, f64) {
    let [mut xx, mut xy, mut yy, mut xd, mut yd] = [0.0; 5];
    for &(x, y) in pixels {
        let moved = |right: f64, down: f64| {
            reference.interpolated(x as f64 - from.0 + right, y as f64 - from.1 + down)
        };
        let slope_x = 0.5 * (moved(1.0, 0.0) - moved(-1.0, 0.0));
        let slope_y = 0.5 * (moved(0.0, 1.0) - moved(0.0, -1.0));
        let difference = moved(0.0, 0.0) - actual.at(x, y);
        xx += slope_x * slope_x;
        xy += slope_x * slope_y;
        yy += slope_y * slope_y;
        xd += slope_x * difference;
        yd += slope_y * difference;
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-9 * (xx + yy) * (xx + yy) {
        return from;
    }
    (from.0 + (yy * xd - xy * yd) / determinant, from.1 + (xx * yd - xy * xd) / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (80, 60);

    /// Waves in both directions, moved.
    fn waves(right: f64, down: f64) -> Vec<f32> {
        let pixel = |at: u32| {
            let (x, y) = (f64::from(at % SIZE.0) - right, f64::from(at / SIZE.0) - down);
            (libm::sin(x * 0.31) * libm::cos(y * 0.23 + x * 0.05)) as f32
        };
        (0..SIZE.0 * SIZE.1).map(pixel).collect()
    }

    #[test]
    fn whole_and_fractional_displacements_are_found() {
        for (right, down) in [(1.0, 0.0), (-3.0, 5.0), (0.4, -0.3), (2.5, 0.25)] {
            let shift = best_shift(&waves(right, down), &waves(0.0, 0.0), SIZE).unwrap();
            assert!((shift.right - right).abs() < 0.05 && (shift.down - down).abs() < 0.05, "{shift:?}");
            assert!(shift.explained > 0.95, "{shift:?}");
        }
    }

    #[test]
    fn other_differences_are_not_explained() {
        let brighter: Vec<f32> = waves(0.0, 0.0).iter().map(|value| value * 1.1 + 0.2).collect();
        let shift = best_shift(&brighter, &waves(0.0, 0.0), SIZE).unwrap();
        assert!(shift.explained < 0.5, "{shift:?}");
        assert_eq!(best_shift(&brighter, &brighter, SIZE), None);
        assert_eq!(best_shift(&[0.0; 9], &[1.0; 9], (3, 3)), None);
        let flat = vec![0.5; brighter.len()];
        let shift = best_shift(&flat, &vec![0.25; flat.len()], SIZE).unwrap();
        assert_eq!(shift.explained, 0.0);
    }
}
