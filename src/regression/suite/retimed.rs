//! Clips that last longer or shorter: their first, middle and last frames have other numbers, and other references.

use super::Suite;
use super::names::possible_shots;
use super::renamed::name_renamed;
use crate::image::DURATION;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};

/// Explains missing images and orphaned references: by shots that were renamed, and by durations of clips.
pub(super) fn explain_unpaired(suite: &Suite, shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    name_renamed(suite, shots, orphaned);
    name_durations(shots, orphaned);
}

/// Adds the durations of clips that images of a shot tell to the messages of its missing images and of orphaned references of its name.
fn name_durations(shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    for shot in shots {
        let durations = durations_of(shot);
        let missing = shot.frames.iter_mut().filter(|frame| frame.status == FrameStatus::Missing);
        let is_of_shot = |image: &str| possible_shots(image).any(|name| name == shot.name);
        let orphaned = orphaned.iter_mut().filter(|frame| is_of_shot(&frame.name));
        for frame in missing.chain(orphaned) {
            frame.messages.extend_from_slice(&durations);
        }
    }
}

fn durations_of(shot: &ShotResult) -> Vec<String> {
    let comparisons = shot.frames.iter().filter_map(|frame| frame.comparison.as_ref());
    let changes = comparisons.flat_map(|comparison| &comparison.scene_changes);
    let mut durations: Vec<_> = changes.filter(|line| line.starts_with(DURATION)).cloned().collect();
    durations.sort_unstable();
    durations.dedup();
    durations
}
