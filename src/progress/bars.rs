//! Two progress bars on a terminal: the sequence, and the current frame.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use rayframe::render::PathProgress;
use rayframe::sequence::{FrameProgress, SequenceEvent};

use super::Verbosity;
use super::eta::{Eta, duration_text};
use super::option_names::option_names;
use super::plain::{exposure_text, kept_text, phases_text, summary_text};
use super::print::{one_line, print_note};
use super::reported::ReportedSequence;

/// Steps of the frame bar.
const FRAME_STEPS: u64 = 1000;
/// Shortest time between two estimates within a frame.
const ETA_INTERVAL: Duration = Duration::from_millis(250);

/// Bars on the standard error stream.
#[derive(Debug)]
pub(super) struct Bars {
    verbosity: Verbosity,
    all: MultiProgress,
    sequence: ProgressBar,
    frame: ProgressBar,
    reported: ReportedSequence,
    times: Mutex<Times>,
}

/// Input of the estimate of the remaining time.
#[derive(Debug, Default)]
struct Times {
    eta: Eta,
    frame_started: Option<Instant>,
    last_estimate: Option<Instant>,
}

impl Bars {
    pub(super) fn new(verbosity: Verbosity, reported: &ReportedSequence) -> Self {
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        let sequence = all.add(ProgressBar::new(0).with_style(style("frames {bar:40} {pos}/{len} {msg}")));
        let frame =
            all.add(ProgressBar::new(FRAME_STEPS).with_style(style("{prefix:6} {bar:40} {percent} % {msg}")));
        Self { verbosity, all, sequence, frame, reported: reported.clone(), times: Mutex::default() }
    }

    pub(super) fn print(&self, event: SequenceEvent<'_>) {
        // Called from many threads. Only the estimate locks, and rarely.
        if let SequenceEvent::FrameProgress(_, FrameProgress { share, path }) = event {
            self.frame.set_position((share * FRAME_STEPS as f32) as u64);
            if let Some(path) = path {
                self.frame.set_message(path_text(&path));
            }
            self.estimate(share);
            return;
        }
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let times = &mut *times;
        let eta = &mut times.eta;
        match event {
            SequenceEvent::Started { to_render, kept } => {
                (eta.done, eta.total) = self.reported.done_and_total(to_render, kept);
                self.sequence.set_length(eta.total as u64);
                self.sequence.set_position(eta.done as u64);
                if let Some(text) = kept_text(kept, to_render) {
                    self.line(&text);
                }
            }
            SequenceEvent::ExposureFound { ev, is_automatic } => {
                if is_automatic {
                    self.line(&exposure_text(ev));
                }
                // Automatic exposure is not part of the frame's time.
                times.frame_started = Some(Instant::now());
            }
            SequenceEvent::FrameStarted(frame) => {
                times.frame_started = Some(Instant::now());
                self.frame.set_position(0);
                self.frame.set_prefix(frame.frame.to_string());
            }
            SequenceEvent::FrameWritten(report) => {
                eta.frame_done(report.seconds.period);
                if self.verbosity.is_verbose {
                    self.line(&format!("{}:{}", report.path.display(), phases_text(report)));
                }
                self.advance(eta);
            }
            SequenceEvent::FrameKept(frame) => {
                eta.frame_kept(frame);
                self.advance(eta);
            }
            SequenceEvent::FrameFailed(frame, error) => {
                eta.done += 1;
                if self.verbosity.names_failures {
                    self.line(&format!("rayframe: error: {}", self.reported.failure_text(frame, error)));
                }
                self.advance(eta);
            }
            SequenceEvent::Warned(warning) => {
                self.line(&format!("rayframe: warning: {}", option_names(&warning.to_string())));
            }
            SequenceEvent::Finished(summary) => {
                self.frame.finish_and_clear();
                self.sequence.finish_and_clear();
                // The bars are cleared; their own line would not end in a newline.
                if self.reported.part().is_none() {
                    print_note(&summary_text(summary, eta.total, &self.reported));
                }
            }
            _ => {}
        }
    }

    fn advance(&self, eta: &Eta) {
        self.sequence.set_position(eta.done as u64);
        if let Some(seconds) = eta.remaining_seconds() {
            self.show_eta(seconds);
        }
    }

    /// Updates the estimate within a frame. Called from many threads; skipped where it would wait for a lock.
    fn estimate(&self, share: f32) {
        let Ok(mut times) = self.times.try_lock() else {
            return;
        };
        if times.last_estimate.is_some_and(|last| last.elapsed() < ETA_INTERVAL) {
            return;
        }
        let elapsed = times.frame_started.map(|started| started.elapsed());
        if let Some(seconds) = elapsed.and_then(|elapsed| times.eta.remaining_within(share, elapsed)) {
            times.last_estimate = Some(Instant::now());
            self.show_eta(seconds);
        }
    }

    fn show_eta(&self, seconds: f64) {
        self.sequence.set_message(format!("eta {}", duration_text(seconds)));
    }

    /// Whether the terminal cannot show bars, for example because it cannot move its cursor.
    pub(super) fn is_hidden(&self) -> bool {
        self.all.is_hidden()
    }

    /// Runs `work` while the bars are hidden.
    pub(super) fn suspended(&self, work: impl FnOnce()) {
        self.all.suspend(work);
    }

    /// Prints a line above the bars.
    fn line(&self, text: &str) {
        let _ = self.all.println(one_line(text));
    }
}

/// `64 of 256 samples, noise 0.012`.
fn path_text(path: &PathProgress) -> String {
    let noise = path.noise.map_or(String::new(), |noise| format!(", noise {noise:.4}"));
    format!("{} of {} samples{noise}", path.samples, path.most_samples)
}

/// Style of a template, or the default style if the template is invalid.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}
