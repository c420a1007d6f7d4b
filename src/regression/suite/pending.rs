//! What waits beside the references until somebody has looked at it.

use std::path::{Path, PathBuf};

use super::super::{Judgement, LayeredPicture, judge};
use super::names::{
    ReferenceFile, pending_path, reference_files, reference_path, removal_path, shots_of_picture,
};
use super::run::fitting;
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::{probe_folder, write_atomically};

/// A change of a reference that was found and not yet accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pending {
    /// The picture.
    pub name: String,
    /// What would be done.
    pub kind: PendingKind,
    /// The reference as it is, or will be.
    pub reference: PathBuf,
    /// The file that waits.
    pub file: PathBuf,
}

/// What accepting does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PendingKind {
    /// A picture becomes the first reference of its name.
    Add,
    /// A picture replaces a reference.
    Replace,
    /// A reference that no shot asks for is removed.
    Remove,
}

/// Whether a build server runs this, which has nobody to look at pictures: the variable `CI` is set, and does not say no. There
/// nothing should be kept to be accepted, and nothing be accepted.
pub fn is_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "0" && value != "false")
}

/// All that waits, in the order of names, of the pictures or shots that `filter` means (see [`super::RunOptions`]).
///
/// # Errors
/// [`Error::Missing`] when the references cannot be read.
pub fn pending(suite: &Suite, filter: &str) -> Result<Vec<Pending>> {
    let files = reference_files(&suite.references)?;
    let mut all = Vec::new();
    for file in files {
        let (name, is_removal) = match file {
            ReferenceFile::Pending(name) => (name, false),
            ReferenceFile::Removal(name) => (name, true),
            ReferenceFile::Reference(_) => continue,
        };
        let reference = reference_path(&suite.references, &name);
        let kind = match (is_removal, reference.exists()) {
            (true, _) => PendingKind::Remove,
            (false, true) => PendingKind::Replace,
            (false, false) => PendingKind::Add,
        };
        let file = if is_removal { removal_path } else { pending_path }(&suite.references, &name);
        all.push(Pending { name, kind, reference, file });
    }
    let names: Vec<String> =
        all.iter().flat_map(|one| shots_of_picture(&one.name).map(str::to_owned)).collect();
    let fits = fitting(filter, names.iter().map(String::as_str));
    all.retain(|one| shots_of_picture(&one.name).any(&fits));
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(all)
}

/// Makes the change.
///
/// # Errors
/// [`Error::Refused`] when the picture is larger than the suite allows, [`Error::WriteFailed`] when the system refuses.
pub fn accept(suite: &Suite, pending: &Pending) -> Result<()> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Error::WriteFailed { path, source }
    };
    if pending.kind == PendingKind::Remove {
        remove_file(&pending.reference)?;
        return remove_file(&pending.file);
    }
    let bytes = std::fs::metadata(&pending.file).map_err(Error::missing(&pending.file))?.len();
    if bytes > suite.max_reference_bytes {
        let message = format!(
            "has {} KiB and a reference at most {}; ask for fewer pixels or layers, or raise max_reference_kib",
            bytes.div_ceil(1024),
            suite.max_reference_bytes / 1024
        );
        return Err(Error::refused(&pending.file, "", message));
    }
    std::fs::rename(&pending.file, &pending.reference).map_err(failed(&pending.reference))
}

/// Forgets the change; the reference stays as it is.
///
/// # Errors
/// [`Error::WriteFailed`] when the system refuses.
pub fn reject(pending: &Pending) -> Result<()> {
    remove_file(&pending.file)
}

/// The picture that waits judged by its reference, with the limits of the one of `shots` that it belongs to.
///
/// # Errors
/// Those of reading the shot's limits.
pub fn judge_pending(
    suite: &Suite,
    shots: &[SuiteShot],
    pending: &Pending,
    actual: &LayeredPicture,
    expected: &LayeredPicture,
) -> Result<Judgement> {
    let shot = shots.iter().find(|shot| shots_of_picture(&pending.name).any(|name| name == shot.name));
    let limits = shot.map_or(Ok(suite.limits), |shot| suite.limits_of(&shot.path))?;
    Ok(judge(actual, expected, &limits.limits))
}

/// Lets `bytes` wait to become the reference of the picture `name`; nothing waits any more where there are none.
pub(super) fn keep(suite: &Suite, name: &str, bytes: Option<&[u8]>) -> Result<()> {
    let file = pending_path(&suite.references, name);
    match bytes {
        Some(bytes) => {
            probe_folder(&file)?;
            write_atomically(&file, bytes)
        }
        None => remove_file(&file),
    }
}

/// Removes a file, if it is there.
pub(super) fn remove_file(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::WriteFailed { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}
