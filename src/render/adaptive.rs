//! Adaptive sampling: pixels on edges take more samples.
//!
//! Source: Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980, section 4: the corners of a pixel are compared,
//! and the pixel is divided where they differ. Departure: the samples of a pixel are compared with each other and with the means of
//! the eight neighbours, which finds small objects that a pixel's own samples miss. Values are compared as a display shows
//! them at the exposure of the settings, where edges are visible. The decision depends only on the base samples of this neighbourhood, so crops decide alike.

/// Settings of adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Samples of pixels on edges, base samples included.
    pub max_samples: u32,
    /// Difference of display values, 0 to 1, above which a pixel is on an edge.
    pub threshold: f32,
}

/// Where a pixel is on an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeThreshold {
    /// See [`Adaptive::threshold`].
    pub(super) difference: f32,
    /// Factor of the exposure at which radiance is displayed.
    pub(super) exposure_scale: f32,
}

/// Range of a pixel's samples: linear radiance, of which a display shows nothing below 0, and coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleRange {
    low: [f32; 4],
    high: [f32; 4],
}

impl SampleRange {
    /// The range of no samples.
    pub(super) const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Extends the range by a sample.
    pub(super) fn add(&mut self, value: [f32; 4]) {
        for (channel, value) in value.into_iter().enumerate() {
            let value = if value > 0.0 { value } else { 0.0 };
            if value < self.low[channel] {
                self.low[channel] = value;
            }
            if value > self.high[channel] {
                self.high[channel] = value;
            }
        }
    }

    /// Whether the display values of any channel differ by more than a threshold.
    pub(super) fn exceeds(&self, threshold: EdgeThreshold) -> bool {
        // Display values grow with what they show.
        let [low, high] = [self.low, self.high].map(|values| displayed(values, threshold.exposure_scale));
        low.iter().zip(&high).any(|(low, high)| high - low > threshold.difference)
    }
}

/// Approximate display values of linear values: the square root of Reinhard's curve, and coverage as it is.
fn displayed([red, green, blue, coverage]: [f32; 4], exposure_scale: f32) -> [f32; 4] {
    let [red, green, blue] = [red, green, blue].map(|radiance| display_value(radiance * exposure_scale));
    [red, green, blue, coverage]
}

/// Approximate display value of a linear value.
pub(super) fn display_value(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0e30 { (x / (1.0 + x)).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn more_than(difference: f32) -> EdgeThreshold {
        EdgeThreshold { difference, exposure_scale: 1.0 }
    }

    fn range(values: &[[f32; 4]]) -> SampleRange {
        let mut range = SampleRange::EMPTY;
        for &value in values {
            range.add(value);
        }
        range
    }

    #[test]
    fn equal_samples_make_no_edge() {
        assert!(!SampleRange::EMPTY.exceeds(more_than(0.0)));
        assert!(!range(&[[0.3, 0.2, 0.1, 1.0]; 4]).exceeds(more_than(0.0)));
    }

    #[test]
    fn differences_are_measured_in_display_values() {
        // √(1/2) − √(1/3) = 0.13 in the dark, √(100/101) − √(50/51) = 0.005 where both are white.
        let dark = range(&[[0.5, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
        assert!(dark.exceeds(more_than(0.12)) && !dark.exceeds(more_than(0.14)));
        let bright = range(&[[50.0, 0.0, 0.0, 1.0], [100.0, 0.0, 0.0, 1.0]]);
        assert!(bright.exceeds(more_than(0.004)) && !bright.exceeds(more_than(0.006)));
        // The same at the exposure that shows both alike
        let darker = |difference| EdgeThreshold { difference, exposure_scale: 0.01 };
        assert!(bright.exceeds(darker(0.12)) && !bright.exceeds(darker(0.14)));
    }

    #[test]
    fn coverage_alone_is_an_edge_and_infinity_is_white() {
        assert!(range(&[[0.0; 4], [0.0, 0.0, 0.0, 1.0]]).exceeds(more_than(0.9)));
        assert!(!range(&[[f32::INFINITY, 0.0, 0.0, 1.0], [1.0e35, 0.0, 0.0, 1.0]]).exceeds(more_than(0.01)));
    }
}
