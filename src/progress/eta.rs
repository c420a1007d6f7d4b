//! How long the rest will take.

use std::collections::VecDeque;

/// Frames that are looked back on.
const WINDOW: usize = 9;

/// Frames done and to do, and how long the last ones took.
#[derive(Debug, Default)]
pub(super) struct Eta {
    /// Frames to render in all.
    pub(super) total: usize,
    /// Frames rendered, or failed.
    pub(super) done: usize,
    recent_seconds: VecDeque<f64>,
}

impl Eta {
    /// A frame took this long.
    pub(super) fn frame_done(&mut self, seconds: f64) {
        self.done += 1;
        if self.recent_seconds.len() == WINDOW {
            self.recent_seconds.pop_front();
        }
        self.recent_seconds.push_back(seconds);
    }

    /// Seconds until all frames are rendered: the median of the last frames for each that is left. One slow frame, such
    /// as the first with cold caches, does not spoil it.
    pub(super) fn remaining_seconds(&self) -> Option<f64> {
        let mut sorted: Vec<f64> = self.recent_seconds.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2)?;
        Some(median * self.total.saturating_sub(self.done) as f64)
    }
}

/// `4.2 s`, `3 min 20 s` or `2 h 05 min`.
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
    fn one_slow_frame_does_not_spoil_the_estimate() {
        let mut eta = Eta { total: 10, ..Eta::default() };
        assert_eq!(eta.remaining_seconds(), None);
        for seconds in [100.0, 2.0, 2.0] {
            eta.frame_done(seconds);
        }
        // Seven frames are left at a median of 2 s.
        assert_eq!(eta.remaining_seconds(), Some(14.0));
    }

    #[test]
    fn durations_read_well() {
        assert_eq!(duration_text(4.21), "4.2 s");
        assert_eq!(duration_text(200.4), "3 min 20 s");
        assert_eq!(duration_text(7500.0), "2 h 05 min");
    }
}
