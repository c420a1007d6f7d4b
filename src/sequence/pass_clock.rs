//! Sizes of the passes of a frame of paths: short ones where something happens between them.

use std::time::Instant;

use crate::render::Pass;

use super::SequenceJob;

/// Samples of the first pass, which is always taken, of all shutter samples together.
pub(crate) const FIRST_SAMPLES: u32 = 4;
/// Most samples of a pass between checkpoints, of all shutter samples together.
const MOST_SAMPLES: u32 = 64;

/// Times the passes of a frame.
#[derive(Debug)]
pub(super) struct PassClock {
    started: Instant,
    limit_seconds: Option<f64>,
    /// Samples of the first pass, of each shutter sample.
    first_samples: u32,
    /// Most samples of a pass, of each shutter sample, where it ends with a checkpoint.
    most_between_checkpoints: Option<u32>,
    /// Samples of finished passes, of each shutter sample, and of those of earlier runs.
    samples: u32,
    /// Samples of the passes of this run.
    timed_samples: u32,
    /// Time of a sample in the last pass.
    seconds_a_sample: f64,
    pass_started: Instant,
}

impl PassClock {
    /// Starts the clock of a frame of `shutter_samples` that has `samples` of earlier runs.
    pub(super) fn new(job: &SequenceJob, shutter_samples: u32, samples: u32) -> Self {
        let limit_seconds = job.render.path.time_limit_seconds.map(f64::from);
        Self::starting((limit_seconds, shutter_samples), job.checkpoint, samples)
    }

    fn starting(
        (limit_seconds, shutter_samples): (Option<f64>, u32),
        has_checkpoints: bool,
        samples: u32,
    ) -> Self {
        let now = Instant::now();
        // A pass takes its samples of every shutter sample.
        let of_each = |samples: u32| (samples / shutter_samples.max(1)).max(1);
        Self {
            started: now,
            limit_seconds,
            first_samples: of_each(FIRST_SAMPLES),
            most_between_checkpoints: has_checkpoints.then(|| of_each(MOST_SAMPLES)),
            samples,
            timed_samples: 0,
            seconds_a_sample: 0.0,
            pass_started: now,
        }
    }

    /// Most samples of the next pass; `None` when the time is over. Every run of a frame has a first pass.
    pub(super) fn most_samples(&self) -> Option<u32> {
        let between = |most| self.samples.clamp(self.first_samples, most);
        let of_checkpoints = self.most_between_checkpoints.map_or(u32::MAX, between);
        let Some(limit) = self.limit_seconds else { return Some(of_checkpoints) };
        if self.timed_samples == 0 {
            return Some(self.first_samples);
        }
        // Passes double, so that later ones are timed well.
        let doubled = self.timed_samples.max(self.first_samples);
        let left = limit - self.started.elapsed().as_secs_f64();
        let affordable = (left / self.seconds_a_sample) as u32;
        (affordable > 0).then(|| affordable.min(of_checkpoints).min(doubled))
    }

    /// Ends a pass.
    pub(super) fn finish(&mut self, pass: &Pass) {
        self.samples += pass.samples();
        self.timed_samples += pass.samples();
        self.seconds_a_sample = self.pass_started.elapsed().as_secs_f64() / f64::from(pass.samples());
        self.pass_started = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::PixelWindow;
    use crate::render::{Integrator, PathFrame, RenderSettings};

    /// Sizes of the passes of a frame of 200 samples that has `taken` of them.
    fn passes(taken: u32, limit_seconds: Option<f64>) -> Vec<u32> {
        shutter_passes((200, 1), taken, limit_seconds)
    }

    /// Sizes of the passes of a frame of so many samples and shutter samples that has `taken` of each of these.
    fn shutter_passes((samples, times): (u32, u32), taken: u32, limit_seconds: Option<f64>) -> Vec<u32> {
        let settings = RenderSettings {
            window: PixelWindow::full(1, 1),
            samples,
            integrator: Integrator::Path,
            ..RenderSettings::default()
        };
        let new = PathFrame::new(&settings, times);
        let (sums, finished) = (new.sums().clone(), new.finished().to_vec());
        let mut frame = new.resumed(sums, finished, taken).unwrap();
        let mut clock = PassClock::starting((limit_seconds, times), true, frame.samples_taken());
        let mut sizes = Vec::new();
        while let Some(pass) = clock.most_samples().and_then(|most| frame.next_pass(most)) {
            sizes.push(pass.samples());
            frame.finish(&pass);
            clock.finish(&pass);
        }
        sizes
    }

    #[test]
    fn continued_frames_have_the_passes_of_one_run() {
        let whole = passes(0, None);
        assert_eq!(whole, [4, 4, 8, 16, 32, 64, 64, 8]);
        let mut taken = 0;
        for (index, size) in whole.iter().enumerate() {
            assert_eq!(passes(taken, None), whole[index..], "{taken}");
            taken += size;
        }
    }

    #[test]
    fn checkpoints_are_as_frequent_however_many_times_the_shutter_has() {
        assert_eq!(shutter_passes((200, 4), 0, None), [1, 1, 2, 4, 8, 16, 16, 2]);
        assert_eq!(shutter_passes((200, 4), 16, None), [16, 16, 2]);
        assert_eq!(shutter_passes((256, 64), 0, None), [1, 1, 1, 1]);
        assert_eq!(shutter_passes((256, 256), 0, None), [1]);
    }

    #[test]
    fn passes_before_a_time_limit_are_timed_anew() {
        assert_eq!(passes(128, Some(1e6)), [4, 4, 8, 16, 32, 8]);
    }

    #[test]
    fn the_first_pass_under_a_limit_is_short_however_many_times_the_shutter_has() {
        let first = |times| PassClock::starting((Some(1.0), times), false, 0).most_samples();
        assert_eq!([1, 2, 3, 8, 64].map(first), [Some(4), Some(2), Some(1), Some(1), Some(1)]);
    }
}
