//! Rendered images in the report of a build server, which `rayframe accept --from` makes references without rendering again.
//!
//! `images.json` lists them beside `index.html`; the files are in the folder `images`, named like the shots.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::names::{IMAGES, LIST, images_folder, name_below, possible_shots, reference_path};
use super::{Suite, discover};
use crate::error::{Error, Result, json_error_text};
use crate::image_file::{
    check_existing, is_own_exr, probe_folder, read_regular_file, remove_stale_temporaries, write_atomically,
    write_single_file,
};
use crate::regression::folder_files::all_files_below;
use crate::regression::result::{FrameResult, FrameStatus, SuiteResult};
use crate::regression::verdict::Verdict;
use crate::sequence::hex;

/// The supported version of the list.
const SCHEMA: u32 = 1;

/// An image that changed or fails, or an orphaned reference.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct RenderedImage {
    /// The name of the image.
    pub name: String,
    /// Whether it changed within the limits or failed.
    pub verdict: Verdict,
    /// The hash of its pixels ([`pixel_hash`](crate::regression::pixel_hash)). `None` for an orphaned reference.
    pub hash: Option<String>,
    /// SHA-256 of the file of the reference that it was compared with. `None` where there was none.
    pub reference: Option<String>,
}

/// The file `images.json`.
#[derive(Debug, Serialize, Deserialize)]
struct ImageList {
    schema: u32,
    images: Vec<RenderedImage>,
}

/// The path of the image `name` in the folder of a report.
pub(super) fn image_path(report: &Path, name: &str) -> PathBuf {
    report.join(image_name_in_report(name))
}

/// The path of the image `name` below the folder of a report.
pub(super) fn image_name_in_report(name: &str) -> String {
    format!("{IMAGES}/{name}.exr")
}

/// Stores a rendered image in the folder of a report.
pub(super) fn store_rendered(report: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let file = image_path(report, name);
    probe_folder(&file)?;
    write_atomically(&file, bytes)
}

/// Checks that in the folder of a report no file of another program has the name of the list, or of an image of a shot of `suite`. `overwrites`
/// permits to replace these.
///
/// # Errors
/// [`Error::CannotCreate`], and those of [`discover`].
pub fn check_images_place(suite: &Suite, report: &Path, overwrites: bool) -> Result<()> {
    let list = report.join(LIST);
    check_existing(&list, "a list of rendered images", overwrites, || is_list(&list))?;
    let mut images = all_files_below(&images_folder(report)).unwrap_or_default();
    images.retain(|file| file.extension().is_some_and(|extension| extension == "exr"));
    if images.is_empty() || overwrites {
        return Ok(());
    }
    // Some file systems ignore case.
    let shots: BTreeSet<_> = discover(suite)?.iter().map(|shot| shot.name.to_lowercase()).collect();
    let listed: BTreeSet<_> =
        listed_in_folder(report).into_iter().flatten().map(|image| image_path(report, &image.name)).collect();
    for image in images {
        let name = name_below(&images_folder(report), &image.with_extension("")).unwrap_or_default();
        if possible_shots(&name.to_lowercase()).any(|shot| shots.contains(shot)) {
            // Runs that were killed leave images without a list.
            let is_own = || Ok(listed.contains(&image) || is_own_exr(&image));
            check_existing(&image, "a rendered image", overwrites, is_own)?;
        }
    }
    Ok(())
}

/// Whether the file is a list of rendered images, of any version.
fn is_list(file: &Path) -> std::io::Result<bool> {
    Ok(serde_json::from_slice::<ImageList>(&std::fs::read(file)?).is_ok())
}

/// Removes the list of an earlier run, and the images that it lists. Other programs' files stay.
pub(super) fn remove_rendered(report: &Path) {
    for image in listed_in_folder(report).into_iter().flatten() {
        // One that stays is not on the new list.
        let _ = std::fs::remove_file(image_path(report, &image.name));
    }
    let list = report.join(LIST);
    let is_empty = std::fs::metadata(&list).is_ok_and(|metadata| metadata.len() == 0);
    if is_empty || is_list(&list).unwrap_or(false) {
        let _ = std::fs::remove_file(list);
    }
}

/// Writes the list of the images of `result` to the folder of a report, and removes what killed runs left of the images.
///
/// # Errors
/// [`Error::CannotCreate`] or [`Error::WriteFailed`].
pub(super) fn write_list(result: &SuiteResult, report: &Path) -> Result<()> {
    let can_accept =
        |frame: &&FrameResult| frame.verdict() != Verdict::Identical && frame.status != FrameStatus::Broken;
    let images = result.frames().filter(can_accept).map(|frame| RenderedImage {
        name: frame.name.clone(),
        verdict: frame.verdict(),
        hash: frame.actual_hash.clone(),
        reference: frame.reference_hash.clone(),
    });
    let paths: Vec<_> = result.frames().map(|frame| image_path(report, &frame.name)).collect();
    remove_stale_temporaries(&paths);
    let list = ImageList { schema: SCHEMA, images: images.collect() };
    let json = serde_json::to_string_pretty(&list);
    let json = json.map_err(|error| Error::Internal { message: error.to_string() })?;
    let file = report.join(LIST);
    write_single_file(&file, (json + "\n").as_bytes())
}

/// SHA-256 of the file of the reference `name`. `None` where there is none.
pub(super) fn reference_hash(suite: &Suite, name: &str) -> Option<String> {
    let reference = reference_path(&suite.references, name);
    Some(file_hash(&read_regular_file(&reference, u64::MAX).ok()?))
}

/// SHA-256 of the bytes of a file, hexadecimal.
pub(super) fn file_hash(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The list in `bytes`, the content of `file`.
///
/// # Errors
/// [`Error::Invalid`] for a malformed list.
pub(super) fn parse_list(file: &Path, bytes: &[u8]) -> Result<Vec<RenderedImage>> {
    let list: ImageList = serde_json::from_slice(bytes).map_err(|error| {
        Error::invalid(file, "", format!("is not a list of rendered images: {}", json_error_text(&error)))
    })?;
    if list.schema != SCHEMA {
        let message = format!("has schema {}; this version supports {SCHEMA}", list.schema);
        return Err(Error::invalid(file, "/schema", message));
    }
    check_names(file, "/images", list.images.iter().map(|image| &image.name))?;
    Ok(list.images)
}

fn listed_in_folder(report: &Path) -> Result<Vec<RenderedImage>> {
    let file = report.join(LIST);
    parse_list(&file, &read_regular_file(&file, u64::MAX)?)
}

/// Refuses names of images that lead out of a folder. Reports come from other machines.
pub(super) fn check_names<'a>(
    file: &Path,
    pointer: &str,
    mut names: impl Iterator<Item = &'a String>,
) -> Result<()> {
    match names.find(|name| !is_below(name)) {
        Some(name) => {
            let message = format!("the name \"{}\" leaves the folder", name.escape_debug());
            Err(Error::invalid(file, pointer, message))
        }
        None => Ok(()),
    }
}

/// Whether the path `name` stays in its folder.
pub(super) fn is_below(name: &str) -> bool {
    !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}
