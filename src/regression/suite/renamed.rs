//! Shots that were renamed: images without a reference that equal one that no shot renders.

use std::collections::BTreeMap;

use super::Suite;
use super::names::reference_path;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::regression::{Image, pixel_hash};

/// Adds the other name to the messages of missing images and orphaned references that are equal.
pub(super) fn name_renamed(suite: &Suite, shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    let frames = shots.iter_mut().flat_map(|shot| &mut shot.frames);
    let missing = frames.filter(|frame| frame.status == FrameStatus::Missing);
    let mut by_hash: BTreeMap<String, Vec<&mut FrameResult>> = BTreeMap::new();
    for frame in missing {
        if let Some(hash) = frame.actual_hash.clone() {
            by_hash.entry(hash).or_default().push(frame);
        }
    }
    if by_hash.is_empty() {
        return;
    }
    for reference in orphaned {
        let image = Image::read(&reference_path(&suite.references, &reference.name));
        let equal = image.ok().and_then(|image| by_hash.get_mut(&pixel_hash(&image)));
        // Of several equal images the first, by name.
        let Some(frame) = equal.filter(|frames| !frames.is_empty()).map(|frames| frames.remove(0)) else {
            continue;
        };
        frame
            .messages
            .push(format!("equals the reference {}, which no shot renders: renamed?", reference.name));
        reference.messages.push(format!("equals the image {}, which has no reference: renamed?", frame.name));
    }
}
