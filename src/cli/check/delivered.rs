//! The files of a delivery: those that are named, and those of folders.

use std::path::{Path, PathBuf};

use rayframe::error::Result;
use rayframe::image_file::{OutputKind, is_output};
use rayframe::regression::{all_files_below, is_sequence, sequence_files};

/// A file of a delivery.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DeliveredFile {
    pub(super) path: PathBuf,
    /// Number of components of its path below the folder that was named; 1 for a file that was named itself.
    pub(super) depth: usize,
}

impl DeliveredFile {
    /// Whether a delivery has it without listing it: a hidden file, as temporary files and records of runs are, or the statistics of a run.
    pub(super) fn is_beside_frames(&self) -> bool {
        let mut names = self.path.iter().rev().take(self.depth);
        names.any(|name| name.to_string_lossy().starts_with('.'))
            || is_output(&self.path, OutputKind::Statistics)
    }
}

/// The file `path`, or the frames of the sequence or folder.
///
/// # Errors
/// Those of [`sequence_files`].
pub(super) fn frames(path: &Path) -> Result<Vec<DeliveredFile>> {
    let files = if is_sequence(path) { sequence_files(path)? } else { vec![path.to_owned()] };
    Ok(files.into_iter().map(|path| DeliveredFile { path, depth: 1 }).collect())
}

/// The same, but all files of the folder and of the folders below it.
///
/// # Errors
/// Those of [`frames`] and [`all_files_below`].
pub(super) fn all_files(path: &Path) -> Result<Vec<DeliveredFile>> {
    if !path.is_dir() {
        return frames(path);
    }
    let above = path.components().count();
    let below = |file: PathBuf| DeliveredFile { depth: file.components().count() - above, path: file };
    Ok(all_files_below(path)?.into_iter().filter(|file| file.is_file()).map(below).collect())
}
