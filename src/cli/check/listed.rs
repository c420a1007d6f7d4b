//! The files that a manifest lists, and where they are now: a delivery may have been moved.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use rayframe::error::Result;
use rayframe::sequence::{ListedFile, Manifest};

use super::checked_file::{CheckedFile, FileStatus};

/// The files of a manifest, and frames that have none.
#[derive(Debug)]
pub(super) struct Listed {
    folder: PathBuf,
    files: Vec<ListedFile>,
    not_rendered: Vec<CheckedFile>,
}

/// Files of a manifest with their places, `None` for those that are missing.
#[derive(Debug)]
pub(super) struct Matched<'a> {
    pub(super) files: Vec<(ListedFile, Option<PathBuf>)>,
    pub(super) not_rendered: Vec<CheckedFile>,
    /// Files that are there and not listed.
    pub(super) unlisted: Vec<&'a Path>,
}

impl Listed {
    /// Reads a manifest.
    ///
    /// # Errors
    /// Those of [`Manifest::read`].
    pub(super) fn read(path: &Path) -> Result<Self> {
        let Manifest { files, not_rendered } = Manifest::read(path)?;
        let no_files = |(frame, status)| {
            let missing = CheckedFile::new(None, FileStatus::Missing, format!("has no files: {status}"));
            CheckedFile { frame: Some(frame), ..missing }
        };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, files, not_rendered: not_rendered.into_iter().map(no_files).collect() })
    }

    /// Finds the listed files among the `given` and, where they are no images, in the `folders` of which these are the images;
    /// without any given where the run wrote them, or beside the manifest.
    pub(super) fn matched<'a>(self, given: Option<&'a [PathBuf]>, folders: &[&Path]) -> Matched<'a> {
        let Self { folder, files, not_rendered } = self;
        let Some(given) = given else {
            let place = |file: ListedFile| {
                let found = found(&file.path, &folder);
                (file, found)
            };
            return Matched {
                files: files.into_iter().map(place).collect(),
                not_rendered,
                unlisted: Vec::new(),
            };
        };
        let mut by_name = BTreeMap::<OsString, Vec<&Path>>::new();
        for path in given {
            by_name.entry(path.file_name().unwrap_or_default().to_owned()).or_default().push(path);
        }
        let place = |file: ListedFile| {
            let name = file.path.file_name().unwrap_or_default();
            let candidates = by_name.entry(name.to_owned()).or_default();
            let closest = (0..candidates.len()).max_by_key(|&at| shared_end(candidates[at], &file.path));
            let in_folder = || folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file());
            let found = closest.map(|at| candidates.remove(at).to_owned()).or_else(in_folder);
            (file, found)
        };
        let files = files.into_iter().map(place).collect();
        Matched { files, not_rendered, unlisted: by_name.into_values().flatten().collect() }
    }
}

/// Number of components that two paths share at their ends.
fn shared_end(a: &Path, b: &Path) -> usize {
    a.components().rev().zip(b.components().rev()).take_while(|(a, b)| a == b).count()
}

/// The file where it was written, or below the folder of the manifest under as many of its folders as are there.
fn found(path: &Path, folder: &Path) -> Option<PathBuf> {
    if path.exists() {
        return Some(path.to_owned());
    }
    let parts: Vec<_> = path.components().collect();
    let ends = (0..parts.len()).map(|start| folder.join(parts[start..].iter().collect::<PathBuf>()));
    ends.filter(|end| end.starts_with(folder)).find(|end| end.is_file())
}
