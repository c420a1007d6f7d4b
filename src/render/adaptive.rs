//! Which pixels take more samples than the others: those on edges.
//!
//! Source: Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980, section 4, compares the corners of a pixel and
//! divides it where they differ. Here the samples of a pixel are compared with each other and with the means of its eight
//! neighbours, which sees small things that a pixel's own samples miss; and in values as a display shows them, since that is
//! where edges are seen. What is decided depends on base samples of this neighbourhood alone, so crops decide alike.

/// More samples where they show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Samples that pixels on edges have in all.
    pub most_samples: u32,
    /// Differences of display values, between 0 and 1, above this are edges.
    pub threshold: f32,
}

/// What the base samples of a pixel have shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    low: [f32; 4],
    high: [f32; 4],
}

impl Spread {
    /// Of no samples.
    pub(super) const NONE: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Adds linear radiance and coverage.
    pub(super) fn add(&mut self, value: [f32; 4]) {
        for (channel, shown) in displayed(value).into_iter().enumerate() {
            if shown < self.low[channel] {
                self.low[channel] = shown;
            }
            if shown > self.high[channel] {
                self.high[channel] = shown;
            }
        }
    }

    /// Whether any channel differs by more than `threshold`.
    pub(super) fn exceeds(&self, threshold: f32) -> bool {
        self.low.iter().zip(&self.high).any(|(low, high)| high - low > threshold)
    }
}

/// About what a display makes of linear values: the square root of Reinhard's curve, and coverage as it is.
fn displayed([red, green, blue, coverage]: [f32; 4]) -> [f32; 4] {
    let shown = |x: f32| {
        let x = if x > 0.0 { x } else { 0.0 };
        if x < 1.0e30 { (x / (1.0 + x)).sqrt() } else { 1.0 }
    };
    [shown(red), shown(green), shown(blue), coverage]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(values: &[[f32; 4]]) -> Spread {
        let mut spread = Spread::NONE;
        for &value in values {
            spread.add(value);
        }
        spread
    }

    #[test]
    fn equal_samples_are_no_edge() {
        assert!(!Spread::NONE.exceeds(0.0));
        assert!(!spread(&[[0.3, 0.2, 0.1, 1.0]; 4]).exceeds(0.0));
    }

    #[test]
    fn differences_count_as_a_display_shows_them() {
        // √(1/2) − √(1/3) = 0.13 in the dark, √(100/101) − √(50/51) = 0.005 where both are white.
        let dark = spread(&[[0.5, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
        assert!(dark.exceeds(0.12) && !dark.exceeds(0.14));
        let bright = spread(&[[50.0, 0.0, 0.0, 1.0], [100.0, 0.0, 0.0, 1.0]]);
        assert!(bright.exceeds(0.004) && !bright.exceeds(0.006));
    }

    #[test]
    fn coverage_alone_is_an_edge_and_infinity_is_white() {
        assert!(spread(&[[0.0; 4], [0.0, 0.0, 0.0, 1.0]]).exceeds(0.9));
        assert!(!spread(&[[f32::INFINITY, 0.0, 0.0, 1.0], [1.0e35, 0.0, 0.0, 1.0]]).exceeds(0.01));
    }
}
