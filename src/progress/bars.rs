//! Two bars on a terminal: the sequence, and the frame at hand.

use std::sync::{Mutex, PoisonError};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::sequence::SequenceEvent;

use super::Verbosity;
use super::eta::{Eta, duration_text};
use super::plain::{exposure_text, kept_text, phases_text, summary_text};
use super::print::{one_line, print_note};

/// Steps of the frame bar.
const FRAME_STEPS: u64 = 1000;

/// Bars on the standard error stream.
#[derive(Debug)]
pub(super) struct Bars {
    verbosity: Verbosity,
    all: MultiProgress,
    sequence: ProgressBar,
    frame: ProgressBar,
    eta: Mutex<Eta>,
}

impl Bars {
    pub(super) fn new(verbosity: Verbosity) -> Self {
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        let sequence = all.add(ProgressBar::new(0).with_style(style("frames {bar:40} {pos}/{len} {msg}")));
        let frame =
            all.add(ProgressBar::new(FRAME_STEPS).with_style(style("{prefix:6} {bar:40} {percent} %")));
        Self { verbosity, all, sequence, frame, eta: Mutex::default() }
    }

    pub(super) fn tell(&self, event: SequenceEvent<'_>) {
        // Comes from many threads and needs nothing but the bar.
        if let SequenceEvent::FrameProgress(_, share) = event {
            self.frame.set_position((share * FRAME_STEPS as f32) as u64);
            return;
        }
        let mut eta = self.eta.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            SequenceEvent::Started { to_render, kept } => {
                eta.total = to_render;
                self.sequence.set_length(to_render as u64);
                if kept > 0 {
                    self.line(&kept_text(kept));
                }
            }
            SequenceEvent::ExposureFound(ev) => self.line(&exposure_text(ev)),
            SequenceEvent::FrameStarted(frame) => {
                self.frame.set_position(0);
                self.frame.set_prefix(frame.frame.to_string());
            }
            SequenceEvent::FrameWritten(report) => {
                eta.frame_done(report.seconds.total);
                if self.verbosity.is_verbose {
                    self.line(&format!("{}:{}", report.path.display(), phases_text(report)));
                }
                self.advance(&eta);
            }
            SequenceEvent::FrameFailed(frame, error) => {
                eta.done += 1;
                if self.verbosity.names_failures {
                    self.line(&format!("rayframe: error: frame {}: {error}", frame.frame));
                }
                self.advance(&eta);
            }
            SequenceEvent::Warned(warning) => self.line(&format!("rayframe: warning: {warning}")),
            SequenceEvent::Finished(summary) => {
                self.frame.finish_and_clear();
                self.sequence.finish_and_clear();
                // The bars are gone; a line of theirs would not end the terminal's line.
                print_note(&summary_text(summary, eta.total));
            }
            SequenceEvent::FrameKept(_) | SequenceEvent::FrameProgress(..) => {}
        }
    }

    fn advance(&self, eta: &Eta) {
        self.sequence.set_position(eta.done as u64);
        if let Some(seconds) = eta.remaining_seconds() {
            self.sequence.set_message(format!("eta {}", duration_text(seconds)));
        }
    }

    /// Whether the terminal cannot show bars, such as one that cannot move its cursor.
    pub(super) fn is_hidden(&self) -> bool {
        self.all.is_hidden()
    }

    /// A line above the bars.
    fn line(&self, text: &str) {
        let _ = self.all.println(one_line(text));
    }
}

/// The style of a template; the default style, should the template not be understood.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}
