//! Presentation of a run: images on the terminal, a movie, a contact sheet.

use std::path::PathBuf;
use std::sync::OnceLock;

use crate::progress::{Reporter, TerminalImages, print_note, print_warning};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Result, Warning};
use rayframe::output::PreviewLook;
use rayframe::sequence::{Plan, SequenceEvent, SequenceJob, Summary, display_frame, write_sequence_outputs};

/// Shows frames during a run, and makes the files of all frames after it.
pub(super) struct Presenter<'a> {
    job: &'a SequenceJob,
    plan: &'a Plan,
    /// Tone mapping of the run, from its event.
    look: OnceLock<PreviewLook>,
    terminal: Option<TerminalImages>,
    is_quiet: bool,
}

impl<'a> Presenter<'a> {
    /// Detects whether the terminal shows images. A quiet one prints warnings alone.
    pub(super) fn new(job: &'a SequenceJob, plan: &'a Plan, is_quiet: bool) -> Self {
        let terminal = if job.sequence_outputs.shows_frames { TerminalImages::of_stderr() } else { None };
        if job.sequence_outputs.shows_frames && terminal.is_none() {
            print_warning("--show: this terminal shows neither images nor 24-bit colours");
        }
        Self { job, plan, look: OnceLock::new(), terminal, is_quiet }
    }

    /// Shows a finished frame.
    pub(super) fn watch(&self, event: SequenceEvent<'_>, reporter: &Reporter) {
        if let SequenceEvent::ExposureFound { ev, .. } = event {
            let _ = self.look.set(self.job.look(ev));
        }
        if let (SequenceEvent::FrameImage(image), Some(terminal)) = (event, self.terminal) {
            reporter.show(&terminal.text(image));
        }
        if self.job.output.is_movie() {
            return;
        }
        let (SequenceEvent::FrameWritten(report), Some(terminal), Some(&look)) =
            (event, self.terminal, self.look.get())
        else {
            return;
        };
        let planned = self.plan.frames.iter().find(|planned| planned.frame == report.frame);
        match planned.map(|planned| display_frame(self.job, planned, look)) {
            Some(Ok(image)) => reporter.show(&terminal.text(&image)),
            Some(Err(error)) => print_warning(&format!("--show: {error}")),
            None => {}
        }
    }

    /// Makes the movie and the contact sheet, unless frames are missing. Returns what was made.
    pub(super) fn present(
        &self,
        summary: &Summary,
        reporter: &Reporter,
        cancel: &CancelFlag,
    ) -> Result<Vec<PathBuf>> {
        let Some(look) = summary.look else { return Ok(Vec::new()) };
        if summary.is_interrupted || !summary.failed.is_empty() {
            for (path, option) in self.job.sequence_outputs.files() {
                reporter.warn(&Warning::of_file(format!(
                    "`{option}`: \"{}\" was not made, as frames are missing",
                    path.display()
                )));
            }
            return Ok(Vec::new());
        }
        let (made, warnings) = write_sequence_outputs(self.job, self.plan, look, cancel)?;
        for warning in &warnings {
            reporter.warn(warning);
        }
        for path in made.iter().filter(|_| !self.is_quiet) {
            print_note(&format!("all frames together: {}", path.display()));
        }
        Ok(made)
    }
}
