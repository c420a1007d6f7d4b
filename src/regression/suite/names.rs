//! What belongs to a picture of a suite: its reference, what waits to become it, and the shot that asks for it.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Added to a reference's name for a picture that waits to become it.
const PENDING: &str = ".new";
/// Added to a reference's name where it waits to be removed.
const REMOVAL: &str = ".remove.new";
/// The ending of references.
const REFERENCE: &str = ".exr";

/// A picture's name: the shot's, and the frame's number where there are several.
pub(super) fn image_name(shot: &str, frame: i64, frames: usize) -> String {
    if frames > 1 { format!("{shot}.{frame:04}") } else { shot.to_owned() }
}

/// The shot that a picture would be a frame of, if it is called as one: `walk` for `walk.0012`.
pub(super) fn numbered_shot(picture: &str) -> Option<&str> {
    let (shot, number) = picture.rsplit_once('.')?;
    let digits = number.strip_prefix('-').unwrap_or(number);
    (digits.len() >= 3 && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(shot)
}

/// The reference of the picture `name` below `references`.
pub(super) fn reference_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}"))
}

/// What waits to become the reference of the picture `name`.
pub(super) fn pending_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{PENDING}"))
}

/// What says that the reference of the picture `name` waits to be removed.
pub(super) fn removal_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{REMOVAL}"))
}

/// What a file below the references is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ReferenceFile {
    /// The reference of a picture.
    Reference(String),
    /// What waits to become one.
    Pending(String),
    /// That one waits to be removed.
    Removal(String),
}

impl ReferenceFile {
    /// The picture.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Reference(name) | Self::Pending(name) | Self::Removal(name) => name,
        }
    }
}

/// All files below `references` that belong to pictures, in the order of their names; none where there is no such folder.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read.
pub(super) fn reference_files(references: &Path) -> Result<Vec<ReferenceFile>> {
    if !references.exists() {
        return Ok(Vec::new());
    }
    let files = files_below(references)?;
    Ok(files.iter().filter_map(|file| kind_of(&name_below(references, file)?)).collect())
}

fn kind_of(name: &str) -> Option<ReferenceFile> {
    let named = |ending: &str| name.strip_suffix(ending)?.strip_suffix(REFERENCE).map(str::to_owned);
    let reference = || name.strip_suffix(REFERENCE).map(str::to_owned);
    named(REMOVAL)
        .map(ReferenceFile::Removal)
        .or_else(|| named(PENDING).map(ReferenceFile::Pending))
        .or_else(|| reference().map(ReferenceFile::Reference))
}

/// The path of `file` below `folder`, with `/` on every system.
pub(super) fn name_below(folder: &Path, file: &Path) -> Option<String> {
    let below = file.strip_prefix(folder).ok()?;
    let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
    Some(parts.join("/"))
}

/// All files below `folder`, sorted; hidden ones and what lies in hidden folders are left out, links are followed.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read.
pub(super) fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    collect(folder, &mut Vec::new(), &mut files)?;
    files.sort();
    Ok(files)
}

/// Adds the files below `folder`, which lies in the folders `around` it.
fn collect(folder: &Path, around: &mut Vec<PathBuf>, files: &mut Vec<PathBuf>) -> Result<()> {
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let missing = Error::missing(place);
    let itself = place.canonicalize().map_err(missing)?;
    // A link that leads round in a circle.
    if around.contains(&itself) {
        return Ok(());
    }
    around.push(itself);
    for entry in std::fs::read_dir(place).map_err(missing)? {
        let entry = entry.map_err(missing)?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let path = folder.join(entry.file_name());
        if path.is_dir() {
            collect(&path, around, files)?;
        } else {
            files.push(path);
        }
    }
    around.pop();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_tell_what_they_are_by_their_names() {
        let references = Path::new("r");
        for name in ["light/point", "a.0012", "dots.in.name"] {
            let of = |path: PathBuf| kind_of(&name_below(references, &path).unwrap()).unwrap();
            assert_eq!(of(reference_path(references, name)), ReferenceFile::Reference(name.to_owned()));
            assert_eq!(of(pending_path(references, name)), ReferenceFile::Pending(name.to_owned()));
            assert_eq!(of(removal_path(references, name)), ReferenceFile::Removal(name.to_owned()));
        }
        assert_eq!(kind_of("notes.txt"), None);
    }

    #[test]
    fn frames_of_shots_are_called_by_number() {
        assert_eq!(image_name("walk", -3, 2), "walk.-003");
        assert_eq!(numbered_shot(&image_name("walk", -3, 2)), Some("walk"));
        assert_eq!(numbered_shot(&image_name("a/walk", 12, 9)), Some("a/walk"));
        assert_eq!(image_name("walk", 12, 1), "walk");
        assert_eq!((numbered_shot("v1.2"), numbered_shot("walk")), (None, None));
    }
}
