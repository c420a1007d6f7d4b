//! What waits beside the references until somebody has looked at it.

use std::path::{Path, PathBuf};

use super::super::{Comparison, Image, compare};
use super::filter::Filter;
use super::names::{ReferenceFile, pending_path, reference_files, reference_path, removal_path};
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
    /// The shot that the picture belongs to.
    pub shot: Option<SuiteShot>,
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
/// nothing should be kept to be accepted, and [`accept`] refuses.
pub fn is_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "0" && value != "false")
}

/// All that waits, in the order of names, of the shot or picture called `word`, or else of all whose names contain it. `shots` are all of
/// the suite.
///
/// # Errors
/// [`Error::Missing`] when the references cannot be read, [`Error::Usage`] when nothing that is meant waits, unless `word` is empty.
pub fn pending(suite: &Suite, shots: &[SuiteShot], word: &str) -> Result<Vec<Pending>> {
    let files = reference_files(&suite.references)?;
    let names = files.iter().map(ReferenceFile::name);
    let filter = Filter::new(word, shots, names);
    let mut all = Vec::new();
    for file in files.iter().filter(|file| filter.matches_image(file.name())) {
        let name = file.name().to_owned();
        let is_removal = match file {
            ReferenceFile::Pending(_) => false,
            ReferenceFile::Removal(_) => true,
            ReferenceFile::Reference(_) => continue,
        };
        let reference = reference_path(&suite.references, &name);
        let kind = match (is_removal, reference.exists()) {
            (true, _) => PendingKind::Remove,
            (false, true) => PendingKind::Replace,
            (false, false) => PendingKind::Add,
        };
        let file = if is_removal { removal_path } else { pending_path }(&suite.references, &name);
        let shot = filter.owner(&name).and_then(|owner| shots.iter().find(|shot| shot.name == owner));
        all.push(Pending { name, kind, reference, file, shot: shot.cloned() });
    }
    if all.is_empty() && !word.is_empty() {
        let word = word.escape_debug();
        return Err(Error::usage(if filter.is_name() {
            format!("nothing of {word} waits; rayframe test finds what differs")
        } else {
            format!("nothing that waits is called \"{word}\"; rayframe test finds what differs")
        }));
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(all)
}

/// Makes the change.
///
/// # Errors
/// [`Error::Usage`] where `CI` is set; [`Error::Refused`] when the reference or the shots have changed since the picture was rendered, or
/// it is larger than the suite allows; [`Error::WriteFailed`] when the system refuses.
pub fn accept(suite: &Suite, pending: &Pending) -> Result<()> {
    check_acceptable(suite, pending)?;
    if pending.kind == PendingKind::Remove {
        remove_file(&pending.reference)?;
        return remove_file(&pending.file);
    }
    std::fs::rename(&pending.file, &pending.reference)
        .map_err(|source| Error::WriteFailed { path: pending.reference.clone(), source })
}

/// Finds out whether [`accept`] would refuse the change.
///
/// # Errors
/// As for [`accept`], but for what the system says to the change itself.
pub fn check_acceptable(suite: &Suite, pending: &Pending) -> Result<()> {
    if is_ci() {
        return Err(Error::usage(
            "CI is set, and references are written where somebody looks at them; accept them at home and commit them",
        ));
    }
    if let Some(why) = outdated(pending)? {
        let message = format!("{why} since this was found; run rayframe test and look again");
        return Err(Error::refused(&pending.file, "", message));
    }
    if pending.kind == PendingKind::Remove {
        return Ok(());
    }
    let bytes = std::fs::metadata(&pending.file).map_err(Error::missing(&pending.file))?.len();
    match suite.too_large(bytes) {
        Some(message) => Err(Error::refused(&pending.file, "", message)),
        None => Ok(()),
    }
}

/// What is not as it was when the change was found; `None` when all is.
fn outdated(pending: &Pending) -> Result<Option<&'static str>> {
    let modified = |path: &Path| std::fs::metadata(path).and_then(|metadata| metadata.modified());
    let found = modified(&pending.file).map_err(Error::missing(&pending.file))?;
    if modified(&pending.reference).is_ok_and(|reference| reference > found) {
        return Ok(Some("the reference has changed"));
    }
    if pending.kind == PendingKind::Remove {
        let owner = std::fs::read_to_string(&pending.file).map_err(Error::missing(&pending.file))?;
        if owner != owner_text(pending.shot.as_ref().map(|shot| shot.name.as_str())) {
            return Ok(Some("the shots of its name have changed"));
        }
    }
    Ok(None)
}

/// Forgets the change; the reference stays as it is.
///
/// # Errors
/// [`Error::WriteFailed`] when the system refuses.
pub fn reject(pending: &Pending) -> Result<()> {
    remove_file(&pending.file)
}

/// The picture that waits judged by its reference, with the limits of its shot.
///
/// # Errors
/// Those of reading the pictures and the shot's limits.
pub fn compare_pending(
    suite: &Suite,
    pending: &Pending,
    actual: &Image,
    expected: &Image,
) -> Result<Comparison> {
    let limits = pending.shot.as_ref().map_or(Ok(suite.limits), |shot| suite.limits_of(&shot.path))?;
    Ok(compare(actual, expected, &limits.limits))
}

/// Lets `bytes` wait to become the reference of the picture `name`.
pub(super) fn store_image(suite: &Suite, name: &str, bytes: &[u8]) -> Result<()> {
    let file = pending_path(&suite.references, name);
    probe_folder(&file)?;
    write_atomically(&file, bytes)
}

/// Forgets what waited to become the reference of the picture `name`.
pub(super) fn discard_image(suite: &Suite, name: &str) -> Result<()> {
    remove_file(&pending_path(&suite.references, name))
}

/// Forgets that the reference `name` waited for its end.
pub(super) fn discard_removal(suite: &Suite, name: &str) -> Result<()> {
    remove_file(&removal_path(&suite.references, name))
}

/// Lets the end of the reference `name` wait; `owner` is the shot that it would be of, which does not ask for it.
pub(super) fn store_removal(suite: &Suite, name: &str, owner: Option<&str>) -> Result<()> {
    write_atomically(&removal_path(&suite.references, name), owner_text(owner).as_bytes())
}

fn owner_text(owner: Option<&str>) -> String {
    owner.map_or_else(|| "no shot\n".to_owned(), |owner| format!("not asked for by {owner}\n"))
}

/// Removes a file, if it is there.
fn remove_file(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::WriteFailed { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}
