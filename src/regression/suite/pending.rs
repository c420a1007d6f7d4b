//! Pending images and removals: files beside the references that a person accepts or rejects.

use std::path::{Path, PathBuf};

use super::filter::Filter;
use super::names::{
    ReferenceFile, changed_path, compared_path, pending_path, reference_files, reference_path, removal_path,
};
use super::referenced_inputs::ReferencedInputs;
use super::rendered_images::reference_hash;
use super::stored_reference::{is_there, is_unreadable_link};
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::{is_own_exr, probe_folder, write_atomically};
use crate::regression::compare::compare;
use crate::regression::comparison::Comparison;
use crate::regression::result::FrameResult;
use crate::regression::{Image, Verdict};

/// A pending change of a reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pending {
    /// The name of the image.
    pub name: String,
    /// The kind of change.
    pub kind: PendingKind,
    /// The path of the reference, which may not exist yet.
    pub reference: PathBuf,
    /// The pending file.
    pub file: PathBuf,
    /// The shot that renders the image.
    pub shot: Option<SuiteShot>,
}

/// The effect of accepting a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PendingKind {
    /// Adds a reference.
    Add,
    /// Replaces a reference from which the image differs beyond the limits.
    Replace,
    /// Replaces a reference from which the image differs within the limits.
    ReplaceWithinLimits,
    /// Removes an orphaned reference.
    Remove,
    /// Keeps a file without a shot, which this program did not write.
    Keep,
}

impl PendingKind {
    /// The kind of a pending removal of the file `reference`.
    pub(super) fn of_removal(reference: &Path) -> Self {
        // A run that was killed has removed it. A link to nothing has no content that another program wrote.
        let is_lost = || !is_there(reference) || is_unreadable_link(reference);
        if is_own_exr(reference) || is_lost() { Self::Remove } else { Self::Keep }
    }

    /// Whether no image becomes the reference.
    pub(super) fn is_removal(self) -> bool {
        matches!(self, Self::Remove | Self::Keep)
    }
}

/// Whether this runs on a build server: the environment variable `CI` is set to something other than empty, `0` and `false`. No
/// pending images should be stored there, and [`Acceptance`](super::Acceptance) refuses.
pub fn is_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "0" && value != "false")
}

/// Pending changes that `filter` selects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PendingSelection {
    /// The changes, sorted by name.
    pub changes: Vec<Pending>,
    /// Whether the filter is the exact name of a shot or image.
    pub is_by_name: bool,
}

/// Pending changes that `filter` selects. `shots` are all shots of the suite.
///
/// # Errors
/// [`Error::Missing`] when the references cannot be read, [`Error::Usage`] when a filter selects no shot and no image.
pub fn pending(suite: &Suite, shots: &[SuiteShot], filter: &str) -> Result<PendingSelection> {
    let files = reference_files(suite)?;
    let names = files.iter().map(ReferenceFile::name);
    let selection = Filter::new(suite, filter, shots, names);
    let inputs = ReferencedInputs::new(suite, shots);
    let mut all = Vec::new();
    for file in files.iter().filter(|file| selection.matches_image(file.name())) {
        let name = file.name().to_owned();
        let reference = reference_path(&suite.references, &name);
        let (kind, file): (_, fn(&Path, &str) -> PathBuf) = match file {
            ReferenceFile::Pending(_) if is_there(&reference) => (PendingKind::Replace, pending_path),
            ReferenceFile::Pending(_) => (PendingKind::Add, pending_path),
            ReferenceFile::Changed(_) => (PendingKind::ReplaceWithinLimits, changed_path),
            ReferenceFile::Removal(_) if inputs.contains(&name) => continue,
            ReferenceFile::Removal(_) => (PendingKind::of_removal(&reference), removal_path),
            ReferenceFile::Reference(_) | ReferenceFile::Compared(_) => continue,
        };
        let file = file(&suite.references, &name);
        let shot = selection.owner(&name).and_then(|owner| shots.iter().find(|shot| shot.name == owner));
        all.push(Pending { name, kind, reference, file, shot: shot.cloned() });
    }
    let selects_any = || {
        shots.iter().any(|shot| selection.matches_shot(&shot.name))
            || files.iter().any(|file| selection.matches_image(file.name()))
    };
    if all.is_empty() && !filter.is_empty() && !selects_any() {
        let word = filter.escape_debug();
        let message = format!(
            "no shot or image has the name \"{word}\", or contains it; rayframe test --list prints all names"
        );
        return Err(Error::usage(message));
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(PendingSelection { changes: all, is_by_name: selection.is_name() })
}

/// Discards the change. The reference stays.
///
/// # Errors
/// [`Error::WriteFailed`] when the file cannot be removed.
pub fn reject(suite: &Suite, pending: &Pending) -> Result<()> {
    remove_file(&pending.file)?;
    match pending.kind {
        kind if kind.is_removal() => Ok(()),
        _ => remove_file(&compared_path(&suite.references, &pending.name)),
    }
}

/// Removes what tells with which reference an image was compared, where somebody deleted the pending image, of the images that `filter`
/// selects. `shots` are all shots of the suite.
///
/// # Errors
/// [`Error::Missing`] when the references cannot be read, [`Error::WriteFailed`] when a file cannot be removed.
pub fn discard_stray_comparisons(suite: &Suite, shots: &[SuiteShot], filter: &str) -> Result<()> {
    let files = reference_files(suite)?;
    let selection = Filter::new(suite, filter, shots, files.iter().map(ReferenceFile::name));
    let selected = files.iter().filter(|file| selection.matches_image(file.name()));
    let compared = selected.filter(|file| matches!(file, ReferenceFile::Compared(_)));
    compared.map(ReferenceFile::name).try_for_each(|name| discard_stray_comparison(suite, name))
}

/// The same for the image `name`.
pub(super) fn discard_stray_comparison(suite: &Suite, name: &str) -> Result<()> {
    let images = [pending_path, changed_path].map(|path| path(&suite.references, name));
    if images.iter().any(|image| image.exists()) {
        return Ok(());
    }
    remove_file(&compared_path(&suite.references, name))
}

/// Compares a pending image with its reference, within the limits of its shot.
///
/// # Errors
/// Errors of reading the shot's limits.
pub fn compare_pending(
    suite: &Suite,
    pending: &Pending,
    actual: &Image,
    expected: &Image,
) -> Result<Comparison> {
    let limits = pending.shot.as_ref().map_or(Ok(suite.limits), |shot| suite.limits_of(&shot.path))?;
    Ok(compare(actual, expected, &limits.limits))
}

/// Stores `bytes` as the pending image of `frame`, instead of any other pending image of its name.
pub(super) fn store_image(suite: &Suite, frame: &FrameResult, bytes: &[u8]) -> Result<()> {
    let [failed, changed, compared] =
        [pending_path, changed_path, compared_path].map(|path| path(&suite.references, &frame.name));
    let is_changed = frame.verdict() == Verdict::Changed;
    let (file, other) = if is_changed { (changed, failed) } else { (failed, changed) };
    probe_folder(&file)?;
    write_atomically(&file, bytes)?;
    remove_file(&other)?;
    match &frame.reference_hash {
        Some(hash) => write_atomically(&compared, format!("{hash}\n").as_bytes()),
        None => remove_file(&compared),
    }
}

/// Discards the pending image `name`, if any.
pub(super) fn discard_image(suite: &Suite, name: &str) -> Result<()> {
    let paths = [pending_path, changed_path, compared_path].map(|path| path(&suite.references, name));
    paths.iter().try_for_each(|path| remove_file(path))
}

/// Discards the pending removal of the reference `name`, if any.
pub(super) fn discard_removal(suite: &Suite, name: &str) -> Result<()> {
    remove_file(&removal_path(&suite.references, name))
}

/// Stores a pending removal of the reference `name`. `owner` is the shot of that name, which does not render it.
pub(super) fn store_removal(suite: &Suite, name: &str, owner: Option<&str>) -> Result<()> {
    let compared = reference_hash(suite, name).unwrap_or_default();
    let text = format!("{}\n{compared}\n", owner_text(owner));
    write_atomically(&removal_path(&suite.references, name), text.as_bytes())
}

/// The first line of a pending removal. The SHA-256 of the reference follows.
pub(super) fn owner_text(owner: Option<&str>) -> String {
    owner.map_or_else(|| "no shot".to_owned(), |owner| format!("not asked for by {owner}"))
}

/// Removes a file, if it exists.
pub(super) fn remove_file(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::WriteFailed { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}
