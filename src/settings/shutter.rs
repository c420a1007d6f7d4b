//! Shutter: the times that a frame averages.

use super::frame_rate::FrameRate;

/// A shutter that opens before a frame's time and closes as long after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Open time in frames; 0.5 is the 180 degree shutter of a film camera.
    pub open: f64,
    /// Number of times at which the scene is rendered; 1 gives the frame's own time without motion blur.
    pub time_samples: u32,
}

impl Default for Shutter {
    fn default() -> Self {
        Self { open: 0.0, time_samples: 1 }
    }
}

impl Shutter {
    /// The times of a frame at `time_seconds`: midpoints of equal intervals of the open time.
    pub(crate) fn times(self, time_seconds: f64, rate: FrameRate) -> Vec<f64> {
        if self.time_samples <= 1 {
            return vec![time_seconds];
        }
        let open_seconds = self.open * rate.time_seconds(1);
        let count = f64::from(self.time_samples);
        let share = |index: u32| (f64::from(index) + 0.5) / count - 0.5;
        (0..self.time_samples).map(|index| time_seconds + share(index) * open_seconds).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_centred_and_even() {
        // Half of 1/24 s around 1 s in four parts: ±1/384 and ±3/384 s.
        let shutter = Shutter { open: 0.5, time_samples: 4 };
        let times = shutter.times(1.0, FrameRate::FILM);
        let expected = [-3.0, -1.0, 1.0, 3.0].map(|step| 1.0 + step / 384.0);
        assert!(times.iter().zip(expected).all(|(time, expected)| (time - expected).abs() < 1e-15));
    }

    #[test]
    fn one_time_is_the_frames_own() {
        assert_eq!(Shutter::default().times(0.1, FrameRate::FILM), [0.1]);
        assert_eq!(Shutter { open: 0.5, time_samples: 1 }.times(0.1, FrameRate::FILM), [0.1]);
    }
}
