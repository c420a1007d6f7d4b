//! File names of a suite: references, pending images and pending removals, and their shots.

use std::path::{Path, PathBuf};

use super::super::folder_files::files_below;
use super::Suite;
use crate::error::{Error, Result};

/// Suffix of pending images, after the name of the reference.
const PENDING: &str = ".new";
/// Suffix of pending images that changed within the limits, after the name of the reference.
const CHANGED: &str = ".changed.new";
/// Suffix of pending removals, after the name of the reference.
const REMOVAL: &str = ".remove.new";
/// Suffix of the file that tells with which reference a pending image was compared, after the name of the reference.
const COMPARED: &str = ".compared.new";
/// Extension of references.
const REFERENCE: &str = ".exr";
/// Name of the list of the images of a report, in its folder.
pub(super) const LIST: &str = "images.json";
/// Folder of the images of a report, beside the list.
pub(super) const IMAGES: &str = "images";

/// The name of an image: that of its shot, and the frame number in shots of several frames.
pub(super) fn image_name(shot: &str, frame: i64, frames: usize) -> String {
    if frames > 1 { format!("{shot}.{frame:04}") } else { shot.to_owned() }
}

/// The shot of an image whose name ends in a frame number, as [`image_name`] writes it: `walk` for `walk.0012` and `walk.-003`. Blender
/// ends names in three digits, `Camera.001`.
pub(super) fn numbered_shot(image: &str) -> Option<&str> {
    let (shot, number) = image.rsplit_once('.')?;
    let digits = number.strip_prefix('-').unwrap_or(number);
    (number.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(shot)
}

/// Names of shots that may render an image, the longest first: `walk@front.0012`, `walk@front` and `walk`.
pub(super) fn possible_shots(image: &str) -> impl Iterator<Item = &str> {
    let view = numbered_shot(image);
    let of_views = view.unwrap_or(image).rmatch_indices('@').map(|(at, _)| &image[..at]);
    std::iter::once(image).chain(view).chain(of_views)
}

/// The path of the reference of the image `name` below `references`.
pub(super) fn reference_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}"))
}

/// The path of the pending image `name`.
pub(super) fn pending_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{PENDING}"))
}

/// The path of the pending image `name` that changed within the limits.
pub(super) fn changed_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{CHANGED}"))
}

/// The path of the SHA-256 of the reference with which the pending image `name` was compared.
pub(super) fn compared_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{COMPARED}"))
}

/// The path of the pending removal of the reference `name`.
pub(super) fn removal_path(references: &Path, name: &str) -> PathBuf {
    references.join(format!("{name}{REFERENCE}{REMOVAL}"))
}

/// The paths of all files of an image below `references`.
pub(super) fn paths_of_image(references: &Path, name: &str) -> [PathBuf; 5] {
    [reference_path, pending_path, changed_path, compared_path, removal_path]
        .map(|path| path(references, name))
}

/// A file below the folder of references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ReferenceFile {
    /// A reference.
    Reference(String),
    /// A pending image.
    Pending(String),
    /// A pending image that changed within the limits.
    Changed(String),
    /// A pending removal.
    Removal(String),
    /// The SHA-256 of the reference with which a pending image was compared.
    Compared(String),
}

impl ReferenceFile {
    /// The name of the image.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Reference(name)
            | Self::Pending(name)
            | Self::Changed(name)
            | Self::Removal(name)
            | Self::Compared(name) => name,
        }
    }
}

/// The folder of the images of a report.
pub(super) fn images_folder(report: &Path) -> PathBuf {
    report.join(IMAGES)
}

/// Whether a folder holds the images of a report, of any run that ended.
pub(super) fn is_images_of_report(folder: &Path) -> bool {
    folder.file_name().is_some_and(|name| name == IMAGES) && folder.with_file_name(LIST).is_file()
}

/// References and pending files of a suite, sorted by path: files below the folder of references, except those of
/// reports and of the cache. Empty where the folder does not exist.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read.
pub(super) fn reference_files(suite: &Suite) -> Result<Vec<ReferenceFile>> {
    let references = &suite.references;
    // A folder that cannot be looked at is not an empty one.
    if !references.try_exists().map_err(Error::missing(references))? {
        return Ok(Vec::new());
    }
    let root = same_file(references);
    let below =
        |folder: &PathBuf| same_file(folder).strip_prefix(&root).ok().map(|below| references.join(below));
    let results: Vec<_> = [&suite.report, &suite.cache]
        .into_iter()
        .filter_map(below)
        .filter(|folder| folder != references)
        .collect();
    let mut files = files_below(references)?;
    files.retain(|file| {
        let mut folders = file.ancestors().skip(1).take_while(|folder| *folder != references);
        !folders.any(|folder| is_images_of_report(folder) || results.iter().any(|result| result == folder))
    });
    Ok(files.iter().filter_map(|file| kind_of(&name_below(references, file)?)).collect())
}

/// The file that has this path below the folder of references.
pub(super) fn kind_of(name: &str) -> Option<ReferenceFile> {
    let named = |ending: &str| name.strip_suffix(ending)?.strip_suffix(REFERENCE).map(str::to_owned);
    let reference = || name.strip_suffix(REFERENCE).map(str::to_owned);
    named(REMOVAL)
        .map(ReferenceFile::Removal)
        .or_else(|| named(CHANGED).map(ReferenceFile::Changed))
        .or_else(|| named(COMPARED).map(ReferenceFile::Compared))
        .or_else(|| named(PENDING).map(ReferenceFile::Pending))
        .or_else(|| reference().map(ReferenceFile::Reference))
}

/// The path of `file` below `folder`, with `/` on every system.
pub(super) fn name_below(folder: &Path, file: &Path) -> Option<String> {
    let below = file.strip_prefix(folder).ok()?;
    let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
    Some(parts.join("/"))
}

/// A canonical path, by which paths to one file are equal.
pub(super) fn same_file(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_recognised_by_their_names() {
        let references = Path::new("r");
        for name in ["light/point", "a.0012", "dots.in.name"] {
            let of = |path: PathBuf| kind_of(&name_below(references, &path).unwrap()).unwrap();
            assert_eq!(of(reference_path(references, name)), ReferenceFile::Reference(name.to_owned()));
            assert_eq!(of(pending_path(references, name)), ReferenceFile::Pending(name.to_owned()));
            assert_eq!(of(changed_path(references, name)), ReferenceFile::Changed(name.to_owned()));
            assert_eq!(of(removal_path(references, name)), ReferenceFile::Removal(name.to_owned()));
            assert_eq!(of(compared_path(references, name)), ReferenceFile::Compared(name.to_owned()));
        }
        assert_eq!(kind_of("notes.txt"), None);
    }

    #[test]
    fn images_of_views_belong_to_a_shot() {
        let shots = |image| possible_shots(image).collect::<Vec<_>>();
        assert_eq!(shots("a/walk"), ["a/walk"]);
        assert_eq!(shots("walk@far@run.0012"), ["walk@far@run.0012", "walk@far@run", "walk@far", "walk"]);
    }

    #[test]
    fn frames_of_shots_are_numbered() {
        assert_eq!(image_name("walk", -3, 2), "walk.-003");
        assert_eq!(numbered_shot(&image_name("walk", -3, 2)), Some("walk"));
        assert_eq!(numbered_shot(&image_name("a/walk", 12, 9)), Some("a/walk"));
        assert_eq!(image_name("walk", 12, 1), "walk");
        assert_eq!(numbered_shot(&image_name("walk", 123_456, 2)), Some("walk"));
        for name in ["v1.2", "walk", "chair.001", "walk.-01"] {
            assert_eq!(numbered_shot(name), None);
        }
    }
}
