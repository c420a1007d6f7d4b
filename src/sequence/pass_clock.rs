//! Sizes of the passes of a frame of paths: short ones where something happens between them.

use std::time::Instant;

use crate::render::Pass;

use super::SequenceJob;

/// Samples of the first pass.
const FIRST_SAMPLES: u32 = 4;
/// Most samples of a pass between checkpoints.
const MOST_SAMPLES: u32 = 64;

/// Times the passes of a frame.
#[derive(Debug)]
pub(super) struct PassClock {
    started: Instant,
    limit_seconds: Option<f64>,
    has_checkpoints: bool,
    /// Samples of finished passes, of each shutter sample.
    samples: u32,
    /// Time of a sample in the last pass.
    seconds_a_sample: f64,
    pass_started: Instant,
}

impl PassClock {
    pub(super) fn new(job: &SequenceJob) -> Self {
        let now = Instant::now();
        Self {
            started: now,
            limit_seconds: job.render.path.time_limit_seconds.map(f64::from),
            has_checkpoints: job.checkpoint,
            samples: 0,
            seconds_a_sample: 0.0,
            pass_started: now,
        }
    }

    /// Most samples of the next pass; `None` when the time is over. Every frame has a first pass.
    pub(super) fn most_samples(&self) -> Option<u32> {
        // Passes double, so that later ones are timed well.
        let doubled = self.samples.max(FIRST_SAMPLES);
        let of_checkpoints = if self.has_checkpoints { doubled.min(MOST_SAMPLES) } else { u32::MAX };
        let Some(limit) = self.limit_seconds else { return Some(of_checkpoints) };
        if self.samples == 0 {
            return Some(FIRST_SAMPLES);
        }
        let left = limit - self.started.elapsed().as_secs_f64();
        let affordable = (left / self.seconds_a_sample) as u32;
        (affordable > 0).then(|| affordable.min(of_checkpoints).min(doubled))
    }

    /// Ends a pass.
    pub(super) fn finish(&mut self, pass: &Pass) {
        self.samples += pass.samples();
        self.seconds_a_sample = self.pass_started.elapsed().as_secs_f64() / f64::from(pass.samples());
        self.pass_started = Instant::now();
    }
}
