//! What is shown of frames while they come, and made of them at the end: pictures on the terminal, a movie, a contact sheet.

use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::output::PreviewLook;
use crate::progress::{Reporter, TerminalPictures, exposure_text, print_note, print_warning};
use crate::sequence::{
    Exposure, OutputFormat, Plan, SequenceEvent, SequenceJob, Summary, find_look, present, shown,
};

/// Who looks at the frames of one run.
pub(super) struct Audience<'a> {
    job: &'a SequenceJob,
    plan: &'a Plan,
    /// Known where anything is tone-mapped.
    look: Option<PreviewLook>,
    terminal: Option<TerminalPictures>,
}

impl<'a> Audience<'a> {
    /// Finds out what the terminal shows, and the exposure that all pictures have.
    pub(super) fn new(job: &'a SequenceJob, plan: &'a Plan, cancel: &CancelFlag) -> Result<Self> {
        let look = if job.presentation.needs_look() { Some(find_look(job, cancel)?) } else { None };
        let is_told_by_the_loop = job.preview || job.output.format() == OutputFormat::Png;
        if let (Some(look), Exposure::Auto, false) = (look, job.exposure, is_told_by_the_loop) {
            print_note(&exposure_text(look.exposure_ev));
        }
        let terminal = if job.presentation.shows_frames { TerminalPictures::of_stderr() } else { None };
        if job.presentation.shows_frames && terminal.is_none() {
            print_warning("--show: this is no terminal that shows pictures or 24-bit colours");
        }
        Ok(Self { job, plan, look, terminal })
    }

    /// Shows a frame that is finished.
    pub(super) fn watch(&self, event: SequenceEvent<'_>, reporter: &Reporter) {
        let (SequenceEvent::FrameWritten(report), Some(terminal), Some(look)) =
            (event, self.terminal, self.look)
        else {
            return;
        };
        let planned = self.plan.frames.iter().find(|planned| planned.frame == report.frame);
        match planned.map(|planned| shown(self.job, planned, look)) {
            Some(Ok(picture)) => reporter.show(&terminal.text(&picture)),
            Some(Err(error)) => print_warning(&format!("--show: {error}")),
            None => {}
        }
    }

    /// Makes what is made of all frames, unless some are missing.
    pub(super) fn present(&self, summary: &Summary, cancel: &CancelFlag) -> Result<()> {
        let Some(look) = self.look else { return Ok(()) };
        if summary.is_interrupted || !summary.failed.is_empty() {
            for (path, option) in self.job.presentation.files() {
                print_warning(&format!(
                    "{option}: \"{}\" was not made, as frames are missing",
                    path.display()
                ));
            }
            return Ok(());
        }
        for path in present(self.job, self.plan, look, cancel)? {
            print_note(&format!("all frames together: {}", path.display()));
        }
        Ok(())
    }
}
