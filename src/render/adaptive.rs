//! Adaptive sampling: pixels on edges take more samples.
//!
//! Source: Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980, section 4: the corners of a pixel are compared,
//! and the pixel is divided where they differ. Departure: the samples of a pixel are compared with each other and with the means of
//! the eight neighbours, which finds small objects that a pixel's own samples miss. Values are compared as a display shows
//! them, where edges are visible. The decision depends only on the base samples of this neighbourhood, so crops decide alike.

/// Settings of adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Samples of pixels on edges, base samples included.
    pub max_samples: u32,
    /// Difference of display values, 0 to 1, above which a pixel is on an edge.
    pub threshold: f32,
}

/// Range of the display values of a pixel's samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleRange {
    low: [f32; 4],
    high: [f32; 4],
}

impl SampleRange {
    /// The range of no samples.
    pub(super) const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Extends the range by a sample: linear radiance and coverage.
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

/// Approximate display values of linear values: the square root of Reinhard's curve, and coverage as it is.
fn displayed([red, green, blue, coverage]: [f32; 4]) -> [f32; 4] {
    [display_value(red), display_value(green), display_value(blue), coverage]
}

/// Approximate display value of a linear value.
pub(super) fn display_value(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0e30 { (x / (1.0 + x)).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(values: &[[f32; 4]]) -> SampleRange {
        let mut range = SampleRange::EMPTY;
        for &value in values {
            range.add(value);
        }
        range
    }

    #[test]
    fn equal_samples_make_no_edge() {
        assert!(!SampleRange::EMPTY.exceeds(0.0));
        assert!(!range(&[[0.3, 0.2, 0.1, 1.0]; 4]).exceeds(0.0));
    }

    #[test]
    fn differences_are_measured_in_display_values() {
        // √(1/2) − √(1/3) = 0.13 in the dark, √(100/101) − √(50/51) = 0.005 where both are white.
        let dark = range(&[[0.5, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
        assert!(dark.exceeds(0.12) && !dark.exceeds(0.14));
        let bright = range(&[[50.0, 0.0, 0.0, 1.0], [100.0, 0.0, 0.0, 1.0]]);
        assert!(bright.exceeds(0.004) && !bright.exceeds(0.006));
    }

    #[test]
    fn coverage_alone_is_an_edge_and_infinity_is_white() {
        assert!(range(&[[0.0; 4], [0.0, 0.0, 0.0, 1.0]]).exceeds(0.9));
        assert!(!range(&[[f32::INFINITY, 0.0, 0.0, 1.0], [1.0e35, 0.0, 0.0, 1.0]]).exceeds(0.01));
    }
}
