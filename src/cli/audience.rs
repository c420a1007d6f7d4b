//! What is shown of frames while they come, and made of them at the end: pictures on the terminal, a movie, a contact sheet.

use std::sync::OnceLock;

use crate::progress::{Reporter, TerminalImages, print_note, print_warning};
use rayframe::cancel::CancelFlag;
use rayframe::error::Result;
use rayframe::output::PreviewLook;
use rayframe::sequence::{Plan, SequenceEvent, SequenceJob, Summary, display_frame, write_sequence_outputs};

/// Who looks at the frames of one run.
pub(super) struct Audience<'a> {
    job: &'a SequenceJob,
    plan: &'a Plan,
    /// Tone mapping of the run, from its event.
    look: OnceLock<PreviewLook>,
    terminal: Option<TerminalImages>,
}

impl<'a> Audience<'a> {
    /// Finds out whether the terminal shows images.
    pub(super) fn new(job: &'a SequenceJob, plan: &'a Plan) -> Self {
        let terminal = if job.sequence_outputs.shows_frames { TerminalImages::of_stderr() } else { None };
        if job.sequence_outputs.shows_frames && terminal.is_none() {
            print_warning("--show: this is no terminal that shows pictures or 24-bit colours");
        }
        Self { job, plan, look: OnceLock::new(), terminal }
    }

    /// Shows a frame that is finished.
    pub(super) fn watch(&self, event: SequenceEvent<'_>, reporter: &Reporter) {
        if let SequenceEvent::ExposureFound { ev, .. } = event {
            let _ = self.look.set(PreviewLook { exposure_ev: ev, tone: self.job.tone });
        }
        let (SequenceEvent::FrameWritten(report), Some(terminal), Some(&look)) =
            (event, self.terminal, self.look.get())
        else {
            return;
        };
        let planned = self.plan.frames.iter().find(|planned| planned.frame == report.frame);
        match planned.map(|planned| display_frame(self.job, planned, look)) {
            Some(Ok(picture)) => reporter.show(&terminal.text(&picture)),
            Some(Err(error)) => print_warning(&format!("--show: {error}")),
            None => {}
        }
    }

    /// Makes what is made of all frames, unless some are missing.
    pub(super) fn present(&self, summary: &Summary, cancel: &CancelFlag) -> Result<()> {
        let Some(look) = summary.look else { return Ok(()) };
        if summary.is_interrupted || !summary.failed.is_empty() {
            for (path, option) in self.job.sequence_outputs.files() {
                print_warning(&format!(
                    "{option}: \"{}\" was not made, as frames are missing",
                    path.display()
                ));
            }
            return Ok(());
        }
        for path in write_sequence_outputs(self.job, self.plan, look, cancel)? {
            print_note(&format!("all frames together: {}", path.display()));
        }
        Ok(())
    }
}
