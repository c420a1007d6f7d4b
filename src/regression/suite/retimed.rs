//! Clips that last longer or shorter: their first, middle and last frames have other numbers, and other references.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;

use super::Suite;
use super::names::{numbered_shot, possible_shots};
use super::renamed::name_renamed;
use crate::image::DURATION;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::settings::file_name_part;

/// Explains missing images and orphaned references: by shots that were renamed, and by durations of clips.
pub(super) fn explain_unpaired(suite: &Suite, shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    name_renamed(suite, shots, orphaned);
    name_durations(shots, orphaned);
}

/// Adds the durations of clips that images of a shot tell to the messages of its missing images and of orphaned references of its name.
fn name_durations(shots: &mut [ShotResult], orphaned: &mut [FrameResult]) {
    for shot in shots {
        let durations = durations_of(shot);
        if durations.is_empty() {
            continue;
        }
        let missing = shot.frames.iter_mut().filter(|frame| frame.status == FrameStatus::Missing);
        let is_of_shot = |image: &str| possible_shots(image).any(|name| name == shot.name);
        let orphaned = orphaned.iter_mut().filter(|frame| is_of_shot(&frame.name));
        for frame in missing.chain(orphaned) {
            let told = durations.iter().filter(|(line, views)| {
                let view = view_of(&frame.name);
                view == shot.name || views.contains(view) || names_clip(view, line)
            });
            frame.messages.extend(told.map(|(line, _)| line.clone()));
        }
    }
}

/// Lines on durations, with the views whose images tell them.
fn durations_of(shot: &ShotResult) -> BTreeMap<String, BTreeSet<String>> {
    let mut durations = BTreeMap::<_, BTreeSet<_>>::new();
    for frame in &shot.frames {
        let changes = frame.comparison.iter().flat_map(|comparison| &comparison.scene_changes);
        for line in changes.filter(|line| line.starts_with(DURATION)) {
            durations.entry(line.clone()).or_default().insert(view_of(&frame.name).to_owned());
        }
    }
    durations
}

/// The name of an image without its frame number.
fn view_of(image: &str) -> &str {
    numbered_shot(image).unwrap_or(image)
}

/// Whether a view plays the clip of a line, by their names.
fn names_clip(view: &str, line: &str) -> bool {
    let clip = line.strip_prefix(DURATION).and_then(|rest| rest.trim_start().strip_prefix('"'));
    let clip =
        clip.and_then(|rest| rest.rsplit_once("\": ")).map(|(clip, _)| file_name_part(OsStr::new(clip)));
    clip.is_some_and(|clip| view.split('@').skip(1).any(|label| clip == *label))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_named_after_their_clips() {
        let line = format!("{DURATION} \"run\": 0.500 s → 1.000 s");
        for (image, is_of_clip) in [
            ("robot@run.0024", true),
            ("a/robot@far@run.0024", true),
            ("robot@walk.0012", false),
            ("run", false),
        ] {
            assert_eq!(names_clip(view_of(image), &line), is_of_clip, "{image}");
        }
    }
}
