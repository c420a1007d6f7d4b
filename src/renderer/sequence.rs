//! Sequences of files.

use std::path::{Path, PathBuf};

use crate::cancel::{CancelFlag, Cancelled};
use crate::error::{Error, Result};
use crate::sequence::{
    ExistingFiles, Plan, RunLock, SequenceEvent, SequenceJob, Summary, check_other_files,
    prepare_other_files, run, write_sequence_outputs,
};
use crate::settings::Settings;
use crate::shot::RenderJob;

/// A sequence that is ready to render to files.
#[derive(Debug)]
pub struct SequenceRenderer {
    job: SequenceJob,
    /// Files that must not be overwritten.
    inputs: Vec<PathBuf>,
    settings: Settings,
    cancel: CancelFlag,
}

impl SequenceRenderer {
    pub(super) fn new(job: RenderJob, settings: Settings, cancel: CancelFlag) -> Self {
        Self { job: job.sequence, inputs: job.inputs, settings, cancel }
    }

    /// Frame numbers in the order of rendering.
    pub fn frames(&self) -> &[i64] {
        &self.job.frames
    }

    /// Renders the frames that do not exist yet and writes their files; with the setting `overwrite` all frames. Folders are
    /// created. `on_event` is called from several threads. The first frame that fails ends the run; with the setting `keep_going`
    /// it does not, and [`Summary::failed`] holds the failures.
    ///
    /// # Errors
    /// What can be found without rendering: names, existing files of other content, also under the name of the movie or the contact sheet,
    /// folders, memory, and another process that renders the same frames ([`Error::Temporary`]). Then the first
    /// failure, [`Error::Interrupted`], and errors of writing a movie or a contact sheet.
    pub fn run(&self, on_event: impl Fn(SequenceEvent<'_>) + Sync) -> Result<Summary> {
        let others: Vec<_> = self.job.sequence_outputs.files().collect();
        let plan = self.plan(&others).map_err(|error| self.settings.locate(error))?;
        plan.prepare()?;
        prepare_other_files(&others)?;
        let _lock = RunLock::acquire(&self.job, &plan, &self.cancel)?;
        let summary = run(&self.job, &plan, &self.cancel, &on_event);
        if summary.is_interrupted || !(summary.failed.is_empty() || self.job.keep_going) {
            summary.outcome()?;
            return Err(Error::Interrupted(Cancelled));
        }
        if let (true, Some(look)) = (summary.failed.is_empty(), summary.look) {
            let (_, warnings) = write_sequence_outputs(&self.job, &plan, look, &self.cancel)?;
            for warning in &warnings {
                on_event(SequenceEvent::Warned(warning));
            }
        }
        Ok(summary)
    }

    fn plan(&self, others: &[(&Path, &'static str)]) -> Result<Plan> {
        let plan = Plan::new(&self.job)?;
        plan.check_collisions(others, &self.inputs)?;
        let overwrites = self.job.existing == ExistingFiles::Overwrite;
        check_other_files(others.iter().copied(), overwrites)?;
        Ok(plan)
    }
}
