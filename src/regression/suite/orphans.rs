//! What no shot of a run asked for: references without a picture, and what earlier runs kept.

use std::collections::BTreeSet;
use std::path::Path;

use super::super::{EncodedImage, FrameStatus, Image, ReportedFrame};
use super::filter::Filter;
use super::names::{ReferenceFile, image_name, reference_files, reference_path};
use super::pending::{discard_image, discard_removal, store_removal};
use super::test_shot::reported;
use super::{ShotReader, ShotResult, Suite, SuiteShot};
use crate::error::{Error, Result};

/// The references of a suite that no shot asks for, without rendering anything.
///
/// # Errors
/// Those of reading the references, and of opening the shots.
pub fn orphaned_references(
    suite: &Suite,
    reader: &dyn ShotReader,
    shots: &[SuiteShot],
) -> Result<Vec<String>> {
    let mut asked = BTreeSet::new();
    for shot in shots {
        let (job, _) = reader.job(suite, &shot.path)?;
        asked.extend(job.frames.iter().map(|&frame| image_name(&shot.name, frame, job.frames.len())));
    }
    let files = reference_files(&suite.references)?;
    let references = files.iter().filter(|file| matches!(file, ReferenceFile::Reference(_)));
    Ok(references.map(|file| file.name().to_owned()).filter(|name| !asked.contains(name)).collect())
}

/// What is left after all shots: gives the references that no shot asks for, and why what waits beside them could not be changed; forgets
/// what earlier runs kept and this one would not. `shots` are all of the suite, `results` those that `word` means and that were tested.
///
/// # Errors
/// When the references cannot be read.
pub fn finish(
    suite: &Suite,
    shots: &[SuiteShot],
    results: &[ShotResult],
    word: &str,
    keeps_pending: bool,
) -> Result<(Vec<ReportedFrame>, Vec<Error>)> {
    let files = reference_files(&suite.references)?;
    let filter = Filter::new(word, shots, files.iter().map(ReferenceFile::name));
    let asked: BTreeSet<&str> =
        results.iter().flat_map(|shot| &shot.pictures).map(|picture| picture.name.as_str()).collect();
    // A shot that was not tested, or could not be opened, may ask for any frame.
    let is_known = |shot: &str| results.iter().any(|result| result.name == shot && !is_unopened(result));
    let is_settled = |name: &str| filter.owner(name).is_none_or(is_known);
    let mut orphaned = Vec::new();
    let mut not_kept = Vec::new();
    for file in &files {
        let name = file.name();
        let is_asked_for = asked.contains(name);
        let is_over = !is_asked_for && is_settled(name) && filter.matches_image(name);
        match file {
            ReferenceFile::Reference(_) if is_over => {
                orphaned.push(without_shot(suite, name));
                if keeps_pending {
                    not_kept.extend(store_removal(suite, name, filter.owner(name)).err());
                }
            }
            ReferenceFile::Pending(_) if is_over && keeps_pending => {
                not_kept.extend(discard_image(suite, name).err());
            }
            ReferenceFile::Removal(_) if keeps_pending && (is_asked_for || !is_settled(name)) => {
                not_kept.extend(discard_removal(suite, name).err());
            }
            _ => {}
        }
    }
    Ok((orphaned, not_kept))
}

/// Whether nothing is known of what the shot asks for.
fn is_unopened(result: &ShotResult) -> bool {
    matches!(&*result.pictures, [only] if only.status == FrameStatus::Broken && only.name == result.name)
}

fn without_shot(suite: &Suite, name: &str) -> ReportedFrame {
    let scenes = ["glb", "gltf"].map(|ending| suite.scenes.join(format!("{name}.{ending}")));
    let is_excluded = |scene: &Path| suite.excluded.iter().any(|excluded| scene.starts_with(excluded));
    let has_scene = scenes.iter().any(|scene| scene.exists() && !is_excluded(scene));
    let why = if has_scene { ", for a shot file names the scene of this name" } else { "" };
    let message = format!("no shot asks for this reference{why}");
    let expected = Image::read(&reference_path(&suite.references, name));
    let expected = expected.ok().as_ref().and_then(EncodedImage::new);
    ReportedFrame { expected, ..reported(name.to_owned(), None, FrameStatus::Orphaned, message) }
}
