//! Estimate of the remaining time.

use std::collections::VecDeque;
use std::time::Duration;

use rayframe::sequence::PlannedFrame;

/// Number of recent frames that the estimate uses.
const WINDOW: usize = 9;
/// Finished share of a frame from which its own pace is used.
const LEAST_SHARE: f64 = 0.05;

/// Number of frames done and in all, and durations of recent frames.
#[derive(Debug, Default)]
pub(super) struct Eta {
    /// Frames to render.
    pub(super) total: usize,
    /// Frames rendered, or failed.
    pub(super) done: usize,
    recent_seconds: VecDeque<f64>,
}

impl Eta {
    /// Records the duration of a frame.
    pub(super) fn frame_done(&mut self, seconds: f64) {
        self.done += 1;
        if self.recent_seconds.len() == WINDOW {
            self.recent_seconds.pop_front();
        }
        self.recent_seconds.push_back(seconds);
    }

    /// Counts a frame that another run has written since this one began. Those that were there are not among the frames to render.
    pub(super) fn frame_kept(&mut self, frame: &PlannedFrame) {
        self.done += usize::from(!frame.is_done);
    }

    /// Seconds until all frames are rendered: the median of recent frames for each remaining one. The median ignores a single
    /// slow frame, such as the first with cold caches.
    pub(super) fn remaining_seconds(&self) -> Option<f64> {
        Some(self.median_seconds()? * self.total.saturating_sub(self.done) as f64)
    }

    /// The same within a frame that started `elapsed` ago and is finished to `share`: the rest of it at its own pace, and the
    /// frames after it. Without recent frames the current one is the estimate of the others.
    pub(super) fn remaining_within(&self, share: f32, elapsed: Duration) -> Option<f64> {
        let share = f64::from(share);
        let own = (share > LEAST_SHARE).then(|| elapsed.as_secs_f64() / share);
        let usual = self.median_seconds();
        let after_this = self.total.saturating_sub(self.done + 1) as f64;
        Some(own.or(usual)? * (1.0 - share) + usual.or(own)? * after_this)
    }

    fn median_seconds(&self) -> Option<f64> {
        let mut sorted: Vec<f64> = self.recent_seconds.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }
}

/// Duration as a text, such as `4.2 s`, `3 min 20 s` or `2 h 05 min`.
pub(super) fn duration_text(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_frame_does_not_change_the_estimate() {
        let mut eta = Eta { total: 10, ..Eta::default() };
        assert_eq!(eta.remaining_seconds(), None);
        for seconds in [100.0, 2.0, 2.0] {
            eta.frame_done(seconds);
        }
        // Seven frames are left at a median of 2 s.
        assert_eq!(eta.remaining_seconds(), Some(14.0));
    }

    #[test]
    fn the_current_frame_refines_the_estimate() {
        let mut eta = Eta { total: 3, ..Eta::default() };
        let second = Duration::from_secs(1);
        // Too early to tell, then a quarter in one second: three more for this frame, four for each of two others.
        assert_eq!(eta.remaining_within(0.03, second), None);
        assert_eq!(eta.remaining_within(0.25, second), Some(3.0 + 8.0));
        eta.frame_done(6.0);
        // Early in the second frame its estimate is the median of 6 s; later it is its own pace.
        assert_eq!(eta.remaining_within(0.0, second), Some(12.0));
        assert_eq!(eta.remaining_within(0.5, second), Some(1.0 + 6.0));
        // A still image has no frames after it.
        let still = Eta { total: 1, ..Eta::default() };
        assert_eq!(still.remaining_within(0.5, second), Some(1.0));
    }

    #[test]
    fn durations_are_readable() {
        assert_eq!(duration_text(4.21), "4.2 s");
        assert_eq!(duration_text(200.4), "3 min 20 s");
        assert_eq!(duration_text(7500.0), "2 h 05 min");
    }
}
