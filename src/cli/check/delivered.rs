//! The files of a delivery: those that are named, and those of folders.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use rayframe::error::{Error, Result};
use rayframe::image_file::{OutputKind, is_output};
use rayframe::regression::{all_files_below, is_sequence, readable_sequence_files};
use rayframe::sequence::canonical;

/// Files that Windows adds to folders.
const OF_WINDOWS: [&str; 2] = ["Thumbs.db", "desktop.ini"];

/// A file of a delivery.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DeliveredFile {
    pub(super) path: PathBuf,
    /// Number of components of its path below the folder that was named; 1 for a file that was named itself.
    pub(super) depth: usize,
}

impl DeliveredFile {
    /// Whether a delivery has it without listing it: a hidden file, as temporary files and records of runs are, the statistics or the manifest
    /// of a run, or what Windows adds to folders.
    pub(super) fn is_beside_frames(&self) -> bool {
        let mut names = self.path.iter().rev().take(self.depth);
        let is_named = |name: &&str| self.path.file_name().is_some_and(|own| own.eq_ignore_ascii_case(name));
        names.any(|name| name.to_string_lossy().starts_with('.'))
            || OF_WINDOWS.iter().any(is_named)
            || [OutputKind::Statistics, OutputKind::Manifest]
                .into_iter()
                .any(|kind| is_output(&self.path, kind))
    }
}

/// Files, and the errors of folders that cannot be read.
pub(super) type Found = (Vec<DeliveredFile>, Vec<Error>);

/// The file `path`, or the frames of the sequence, or of the folder and the folders below it.
///
/// # Errors
/// Those of [`is_sequence`] and [`readable_sequence_files`].
pub(super) fn frames(path: &Path) -> Result<Found> {
    let (files, unreadable) =
        if is_sequence(path)? { readable_sequence_files(path)? } else { (vec![path.to_owned()], Vec::new()) };
    Ok((files.into_iter().map(|path| DeliveredFile { path, depth: 1 }).collect(), unreadable))
}

/// The same, but all files of the folder and of the folders below it, whatever they are.
///
/// # Errors
/// Those of [`frames`] and [`all_files_below`].
pub(super) fn all_files(path: &Path) -> Result<Found> {
    if !path.is_dir() {
        return frames(path);
    }
    let above = path.components().count();
    let below = |file: PathBuf| DeliveredFile { depth: file.components().count() - above, path: file };
    Ok((all_files_below(path)?.into_iter().map(below).collect(), Vec::new()))
}

/// The files, each once: a file may be named twice, or with its folder.
pub(super) fn each_once(mut files: Vec<DeliveredFile>) -> Vec<DeliveredFile> {
    let mut known = HashSet::new();
    files.retain(|file| known.insert(canonical(&file.path)));
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_named_twice_count_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| DeliveredFile { path: folder.path().join(name), depth: 1 };
        std::fs::create_dir(folder.path().join("below")).unwrap();
        let names = ["a.exr", "a.exr", "./a.exr", "b.exr", "below/../a.exr", "below/a.exr"];
        let files = each_once(names.map(file).to_vec());
        assert_eq!(files, ["a.exr", "b.exr", "below/a.exr"].map(file));
    }
}
