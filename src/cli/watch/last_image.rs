//! The last full image, which replaces a coarse one that no full one follows.

use std::path::PathBuf;

use rayframe::error::Result;
use rayframe::image_file::write_atomically;
use rayframe::sequence::{OutputFormat, Plan, SequenceJob};

use super::coarse;

/// The image under the output's name.
#[derive(Debug)]
pub(super) struct LastImage {
    path: PathBuf,
    format: OutputFormat,
    /// The last full one.
    full: Option<Vec<u8>>,
}

impl LastImage {
    /// Keeps the existing image, unless it is coarse: then `last` has the full one, if it is of the same file.
    ///
    /// # Errors
    /// Those of restoring that of another file.
    pub(super) fn keep(last: &mut Option<Self>, job: &SequenceJob, plan: &Plan) -> Result<()> {
        let format = job.output.format();
        for planned in &plan.frames {
            if let Some(other) = last.take_if(|last| last.path != planned.path) {
                other.finish()?;
            }
            let last = last.get_or_insert_with(|| Self { path: planned.path.clone(), format, full: None });
            if !coarse::is_coarse(format, &planned.path) {
                last.full = std::fs::read(&planned.path).ok();
            }
        }
        Ok(())
    }

    /// Replaces a coarse image by the last full one. The first image of a file stays as it is.
    ///
    /// # Errors
    /// Those of writing the file.
    pub(super) fn restore(&self) -> Result<()> {
        match &self.full {
            Some(full) if coarse::is_coarse(self.format, &self.path) => write_atomically(&self.path, full),
            _ => Ok(()),
        }
    }

    /// Replaces a coarse image by the last full one, or removes it: nothing follows it any more.
    ///
    /// # Errors
    /// Those of writing the file.
    pub(super) fn finish(&self) -> Result<()> {
        if self.full.is_none() && coarse::is_coarse(self.format, &self.path) {
            // A file that cannot be removed is marked as coarse.
            let _ = std::fs::remove_file(&self.path);
        }
        self.restore()
    }
}
