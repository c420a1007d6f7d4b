//! Progress lines of Open Job Description on the standard output, as read by AWS Deadline Cloud.
//!
//! Source: the Open Job Description specifications, "How Jobs Are Run", section "Stdout/Stderr Messages":
//! `openjd_progress: PERCENT`, `openjd_status: TEXT` and `openjd_fail: TEXT`.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayframe::sequence::{FrameProgress, SequenceEvent};

use super::eta::Eta;
use super::one_line;
use super::plain::{kept_text, summary_text, written_text};
use super::reported::ReportedSequence;
use super::standard_output::write_lines;

/// Shortest time between two progress lines of a frame.
const INTERVAL: Duration = Duration::from_millis(500);

/// Greatest reported share of the run while a frame is unfinished.
const MOST_BEFORE_END: f64 = 0.999;

/// Lines of Open Job Description on the standard output.
#[derive(Debug)]
pub(super) struct OpenJdLines {
    sequence: ReportedSequence,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    eta: Eta,
    /// Number of started frames.
    started: usize,
    /// Last reported percentage, which never decreases.
    percent: f64,
    printed: Option<Instant>,
}

impl OpenJdLines {
    pub(super) fn new(sequence: &ReportedSequence) -> Self {
        Self { sequence: sequence.clone(), state: Mutex::default() }
    }

    pub(super) fn print(&self, event: SequenceEvent<'_>) {
        // Called from many threads. Skipped where it would wait for a lock.
        if let SequenceEvent::FrameProgress(_, FrameProgress { share, .. }) = event {
            if let Ok(mut state) = self.state.try_lock()
                && state.printed.is_none_or(|printed| printed.elapsed() >= INTERVAL)
            {
                // A traced frame is not on disk yet.
                let most = state.eta.total as f64 * MOST_BEFORE_END;
                let frames = state.started.saturating_sub(1) as f64 + f64::from(share);
                print_lines(&[state.progress(if frames < most { frames } else { most })]);
            }
            return;
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        print_lines(&self.lines(&mut state, event));
    }

    /// Lines of an event other than progress within a frame.
    fn lines(&self, state: &mut State, event: SequenceEvent<'_>) -> Vec<String> {
        match event {
            SequenceEvent::Started { to_render, kept } => {
                (state.eta.done, state.eta.total) = self.sequence.done_and_total(to_render, kept);
                state.started = state.eta.done;
                let kept = kept_text(kept, to_render).map(|text| status(&text));
                std::iter::once(state.progress(state.eta.done as f64)).chain(kept).collect()
            }
            SequenceEvent::FrameKept(frame) if !frame.is_done => {
                state.eta.frame_kept(frame);
                state.started += 1;
                let done = state.eta.done as f64;
                vec![state.progress(done)]
            }
            SequenceEvent::FrameStarted(_) => {
                state.started += 1;
                Vec::new()
            }
            SequenceEvent::FrameWritten(report) => {
                state.eta.frame_done(report.seconds.period);
                let done = state.eta.done as f64;
                vec![state.progress(done), status(&written_text(report, &state.eta))]
            }
            SequenceEvent::FrameFailed(frame, error) => {
                state.eta.done += 1;
                vec![failure(&self.sequence.failure_text(frame, error))]
            }
            SequenceEvent::Finished(summary) if self.sequence.part().is_none() => {
                let is_done = !summary.is_interrupted && summary.failed.is_empty();
                let progress = is_done.then(|| state.progress(state.eta.total as f64));
                let text = status(&summary_text(summary, state.eta.total, &self.sequence));
                progress.into_iter().chain([text]).collect()
            }
            _ => Vec::new(),
        }
    }
}

impl State {
    /// Progress line for a number of finished frames.
    fn progress(&mut self, frames: f64) -> String {
        let percent = match self.eta.total {
            0 => 100.0,
            total => (100.0 * frames / total as f64).min(100.0),
        };
        self.percent = if percent > self.percent { percent } else { self.percent };
        self.printed = Some(Instant::now());
        format!("openjd_progress: {:.1}", self.percent)
    }
}

/// Prints why a run failed before its first frame.
pub(crate) fn print_openjd_failure(message: &str) {
    print_lines(&[failure(message)]);
}

/// Prints the result of a run of several sequences.
pub(crate) fn print_openjd_total(text: &str, is_complete: bool) {
    let progress = is_complete.then(|| "openjd_progress: 100.0".to_owned());
    print_lines(&progress.into_iter().chain([status(text)]).collect::<Vec<_>>());
}

fn status(text: &str) -> String {
    format!("openjd_status: {}", one_line(text))
}

fn failure(text: &str) -> String {
    format!("openjd_fail: {}", one_line(text))
}

fn print_lines(lines: &[String]) {
    if !lines.is_empty() {
        write_lines(&lines.join("\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::sequence::Summary;

    #[test]
    fn progress_never_decreases_and_ends_at_a_hundred() {
        let lines = OpenJdLines::new(&ReportedSequence::default());
        let mut state = State::default();
        let begin = SequenceEvent::Started { to_render: 4, kept: 2 };
        assert_eq!(
            lines.lines(&mut state, begin),
            ["openjd_progress: 0.0", "openjd_status: 2 frames are there already and are kept"]
        );
        // One frame and a half of four; then the first frame is on disk, which is less.
        assert_eq!(state.progress(1.5), "openjd_progress: 37.5");
        assert_eq!(state.progress(1.0), "openjd_progress: 37.5");
        let summary = Summary::default();
        assert_eq!(lines.lines(&mut state, SequenceEvent::Finished(&summary))[0], "openjd_progress: 100.0");
        // A run without frames to render is complete.
        assert_eq!(State::default().progress(0.0), "openjd_progress: 100.0");
    }

    #[test]
    fn messages_stay_on_their_line() {
        assert_eq!(failure("a\nopenjd_progress: 100"), "openjd_fail: a\\nopenjd_progress: 100");
    }
}
