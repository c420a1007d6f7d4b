//! Seconds that each frame of a sequence takes, from the statistics of a sparse run before it.

use std::path::Path;

use serde::Deserialize;

use rayframe::error::{Error, Result, json_error_text};
use rayframe::image_file::read_regular_file;

/// Largest file of statistics: those of a million frames are smaller.
const MAX_BYTES: u64 = 4 << 30;

/// Seconds of some frames of a sequence, in the order of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameCosts {
    measured: Vec<(i64, f64)>,
}

/// An image and the threads that render it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Workload {
    pub(super) resolution: (u32, u32),
    pub(super) samples: u32,
    pub(super) threads: u32,
}

impl Workload {
    /// Samples a thread.
    fn samples_a_thread(self) -> f64 {
        let (width, height) = self.resolution;
        f64::from(width) * f64::from(height) * f64::from(self.samples) / f64::from(self.threads.max(1))
    }
}

/// The part of a file of `--stats` that is read.
#[derive(Debug, Deserialize)]
struct Statistics {
    resolution: (u32, u32),
    samples: u32,
    threads: u32,
    frames: Vec<Frame>,
}

#[derive(Debug, Deserialize)]
struct Frame {
    frame: i64,
    seconds: Seconds,
}

#[derive(Debug, Deserialize)]
struct Seconds {
    total: f64,
}

impl FrameCosts {
    /// Reads a file of `--stats`. Its times are scaled to `workload` by the number of samples and of threads.
    ///
    /// # Errors
    /// [`Error::Missing`], and [`Error::Invalid`] for a file of another kind or without frames.
    pub(super) fn read(path: &Path, workload: Workload) -> Result<Self> {
        let text = read_regular_file(path, MAX_BYTES)?;
        let invalid =
            |why: String| Error::invalid(path, "", format!("{why}; name a file of rayframe render --stats"));
        let statistics: Statistics = serde_json::from_slice(&text).map_err(|error| {
            invalid(format!("holds no statistics of frames ({})", json_error_text(&error)))
        })?;
        let Statistics { resolution, samples, threads, frames } = statistics;
        let scale =
            workload.samples_a_thread() / Workload { resolution, samples, threads }.samples_a_thread();
        let mut measured: Vec<_> =
            frames.iter().map(|frame| (frame.frame, frame.seconds.total * scale)).collect();
        if measured.is_empty()
            || measured.iter().any(|(_, seconds)| !(seconds.is_finite() && *seconds >= 0.0))
        {
            return Err(invalid("has no frame with its seconds".to_owned()));
        }
        measured.sort_by_key(|(frame, _)| *frame);
        Ok(Self { measured })
    }

    /// Seconds of `frame`: linear between measured frames, and those of the nearest one beyond them.
    pub(super) fn seconds(&self, frame: i64) -> f64 {
        let next = self.measured.partition_point(|(measured, _)| *measured < frame);
        let before = next.checked_sub(1).and_then(|index| self.measured.get(index));
        match (before, self.measured.get(next)) {
            (Some(&(a, from)), Some(&(b, to))) => from + (to - from) * ((frame - a) as f64 / (b - a) as f64),
            (Some(&(_, seconds)), None) | (None, Some(&(_, seconds))) => seconds,
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORKLOAD: Workload = Workload { resolution: (64, 36), samples: 4, threads: 2 };

    fn read(text: &str, workload: Workload) -> Result<FrameCosts> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stats.json");
        std::fs::write(&path, text).unwrap();
        FrameCosts::read(&path, workload)
    }

    fn statistics(frames: &str) -> String {
        format!(
            r#"{{"resolution": [64, 36], "samples": 4, "threads": 2, "seconds": 3.5, "frames": [{frames}]}}"#
        )
    }

    #[test]
    fn costs_between_measured_frames_are_interpolated() {
        let text =
            statistics(r#"{"frame": 11, "seconds": {"total": 3}}, {"frame": 1, "seconds": {"total": 1}}"#);
        let costs = read(&text, WORKLOAD).unwrap();
        assert_eq!([-5, 1, 6, 11, 99].map(|frame| costs.seconds(frame)), [1.0, 1.0, 2.0, 3.0, 3.0]);
        // Twice the width and the samples, on one thread.
        let larger = Workload { resolution: (128, 36), samples: 8, threads: 1 };
        assert_eq!(read(&text, larger).unwrap().seconds(1), 8.0);
    }

    #[test]
    fn other_files_are_refused() {
        for text in ["", "{}", "[1]", &statistics(""), &statistics(r#"{"frame": 1}"#)] {
            assert_eq!(read(text, WORKLOAD).unwrap_err().exit_code(), 65, "{text}");
        }
        assert_eq!(FrameCosts::read(Path::new("/none/s.json"), WORKLOAD).unwrap_err().exit_code(), 66);
    }
}
