//! Orphaned references, and pending images of earlier runs that no longer apply.

use std::collections::BTreeSet;
use std::path::Path;

use super::covered_jobs::jobs_of;
use super::filter::Filter;
use super::names::{ReferenceFile, paths_of_image, possible_shots, reference_files, reference_path};
use super::pending::{discard_image, discard_removal, store_removal};
use super::rendered_images::file_hash;
use super::{RunOptions, Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::remove_stale_temporaries;
use crate::regression::Image;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};

/// References of a suite that no shot renders. Renders nothing.
///
/// # Errors
/// Those of reading the references, and of opening the shots.
pub fn orphaned_references(suite: &Suite, shots: &[SuiteShot]) -> Result<Vec<String>> {
    let mut rendered = BTreeSet::new();
    for shot in shots {
        for covered in jobs_of(suite, shot)? {
            let frames = &covered.job.sequence.frames;
            rendered.extend(frames.iter().map(|&frame| covered.image_name(&shot.name, frame)));
        }
    }
    let files = reference_files(&suite.references)?;
    let references = files.iter().filter(|file| matches!(file, ReferenceFile::Reference(_)));
    Ok(references.map(|file| file.name().to_owned()).filter(|name| !rendered.contains(name)).collect())
}

/// Finds orphaned references after all shots were tested, and updates pending images: marks the orphaned references for removal, and
/// discards pending images and removals of earlier runs that no longer apply. Returns the orphaned references, and errors of the
/// update. `shots` are all shots of the suite; `results` those that `options` select.
///
/// # Errors
/// When the references cannot be read.
pub fn finish(
    suite: &Suite,
    shots: &[SuiteShot],
    results: &[ShotResult],
    options: &RunOptions,
) -> Result<(Vec<FrameResult>, Vec<Error>)> {
    let files = reference_files(&suite.references)?;
    let keeps_pending = options.keeps_pending;
    let filter = Filter::new(&options.filter, shots, files.iter().map(ReferenceFile::name));
    let rendered: BTreeSet<&str> =
        results.iter().flat_map(|shot| &shot.frames).map(|frame| frame.name.as_str()).collect();
    // A shot that was not tested, or could not be opened, may render any frame.
    let is_known = |shot: &str| results.iter().any(|result| result.name == shot && !is_unopened(result));
    // Without a shot, it belongs to the part that its shot would belong to.
    let is_here = |name: &str| {
        options.shard.is_none_or(|shard| shard.includes(possible_shots(name).last().unwrap_or(name)))
    };
    let is_decided = |name: &str| filter.owner(name).map_or_else(|| is_here(name), is_known);
    // A shot of this name may render it.
    let is_doubtful = |name: &str| filter.owner(name).is_some_and(|shot| !is_known(shot));
    if keeps_pending {
        let names = rendered.iter().copied().chain(files.iter().map(ReferenceFile::name));
        let paths = names.flat_map(|name| paths_of_image(&suite.references, name));
        remove_stale_temporaries(&paths.collect::<Vec<_>>());
    }
    let mut orphaned = Vec::new();
    let mut not_kept = Vec::new();
    for file in &files {
        let name = file.name();
        let is_rendered = rendered.contains(name);
        let is_orphaned = !is_rendered && is_decided(name) && filter.matches_image(name);
        match file {
            ReferenceFile::Reference(_) if is_orphaned => {
                orphaned.push(without_shot(suite, name));
                if keeps_pending {
                    not_kept.extend(store_removal(suite, name, filter.owner(name)).err());
                }
            }
            ReferenceFile::Pending(_) | ReferenceFile::Changed(_) if is_orphaned && keeps_pending => {
                not_kept.extend(discard_image(suite, name).err());
            }
            // Those without a shot that belong to another part are left to it.
            ReferenceFile::Removal(_) if keeps_pending && (is_rendered || is_doubtful(name)) => {
                not_kept.extend(discard_removal(suite, name).err());
            }
            _ => {}
        }
    }
    Ok((orphaned, not_kept))
}

/// Whether the shot could not be opened, so that its frames are unknown.
fn is_unopened(result: &ShotResult) -> bool {
    matches!(&*result.frames, [only] if only.status == FrameStatus::Broken && only.name == result.name)
}

pub(super) fn without_shot(suite: &Suite, name: &str) -> FrameResult {
    let scenes = ["glb", "gltf"].map(|ending| suite.scenes.join(format!("{name}.{ending}")));
    let is_excluded = |scene: &Path| suite.excluded.iter().any(|excluded| scene.starts_with(excluded));
    let has_scene = scenes.iter().any(|scene| scene.exists() && !is_excluded(scene));
    let why = if has_scene { ", because a shot file names the scene of this name" } else { "" };
    let message = format!("no shot renders this reference{why}");
    let reference = reference_path(&suite.references, name);
    let bytes = std::fs::read(&reference).ok();
    let image = bytes.as_ref().and_then(|bytes| Image::decode(&reference, bytes).ok());
    FrameResult {
        expected: image.as_ref().and_then(EncodedImage::new),
        reference_hash: bytes.as_deref().map(file_hash),
        ..FrameResult::new(name.to_owned(), None, FrameStatus::Orphaned, message)
    }
}
