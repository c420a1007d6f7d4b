//! Sequences of files.

use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::sequence::{Plan, SequenceEvent, SequenceJob, Summary, run, write_sequence_outputs};

/// A sequence that is ready to render to files.
#[derive(Debug)]
pub struct SequenceRenderer {
    job: SequenceJob,
    cancel: CancelFlag,
}

impl SequenceRenderer {
    pub(super) fn new(job: SequenceJob, cancel: CancelFlag) -> Self {
        Self { job, cancel }
    }

    /// Frame numbers in the order of rendering.
    pub fn frames(&self) -> &[i64] {
        &self.job.frames
    }

    /// Renders the frames that do not exist yet and writes their files; with the setting `overwrite` all frames. Folders are
    /// created. `on_event` is called from several threads. A frame that fails is in [`Summary::failed`]; the others follow
    /// only with the setting `keep_going`.
    ///
    /// # Errors
    /// What can be found without rendering: names, existing files of other content, folders, memory. Afterwards, errors of
    /// writing a movie or a contact sheet.
    pub fn run(&self, on_event: impl Fn(SequenceEvent<'_>) + Sync) -> Result<Summary> {
        let plan = Plan::new(&self.job)?;
        plan.prepare()?;
        let summary = run(&self.job, &plan, &self.cancel, &on_event);
        Ok(summary)
    }
}
