//! Shots that were renamed: images without a reference that equal one that no shot renders.

use std::collections::BTreeMap;

use super::Suite;
use super::names::reference_path;
use crate::regression::exact::value_hash;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::regression::{Image, pixel_hash};

/// Adds the other name to the messages of missing images and orphaned references that are equal.
pub(super) fn name_renamed(suite: &Suite, shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    let frames = shots.iter_mut().flat_map(|shot| &mut shot.frames);
    let missing = frames.filter(|frame| frame.status == FrameStatus::Missing);
    let mut by_hash: BTreeMap<String, Vec<&mut FrameResult>> = BTreeMap::new();
    for frame in missing {
        if let Some(hash) = frame.value_hash.clone().or_else(|| frame.actual_hash.clone()) {
            by_hash.entry(hash).or_default().push(frame);
        }
    }
    if by_hash.is_empty() {
        return;
    }
    for reference in orphaned {
        let image = Image::read(&reference_path(&suite.references, &reference.name));
        // Reports that are merged hold the hash with the scene alone.
        let hashes = image.map(|image| vec![value_hash(&image), pixel_hash(&image)]).unwrap_or_default();
        let equal = hashes.iter().find(|hash| by_hash.get(*hash).is_some_and(|frames| !frames.is_empty()));
        // Of several equal images the first, by name.
        let Some(frame) = equal.and_then(|hash| by_hash.get_mut(hash)).map(|frames| frames.remove(0)) else {
            continue;
        };
        frame
            .messages
            .push(format!("equals the reference {}, which no shot renders: renamed?", reference.name));
        reference.messages.push(format!("equals the image {}, which has no reference: renamed?", frame.name));
    }
}
