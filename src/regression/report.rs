//! What is left for the eye when a picture differs.

use std::path::{Path, PathBuf};

use super::{Picture, Shot};
use crate::error::Result;

/// Writes the picture and, beside it, its absolute difference from the reference, below `folder`. Gives the files.
pub(super) fn write_difference(
    folder: &Path,
    shot: &Shot,
    actual: &Picture,
    reference: &Picture,
    time_seconds: f64,
) -> Result<Vec<PathBuf>> {
    let actual_path = folder.join(format!("{}.actual.exr", shot.name));
    actual.write(&actual_path, shot.frame, time_seconds)?;
    if actual.size != reference.size {
        return Ok(vec![actual_path]);
    }
    let difference_path = folder.join(format!("{}.difference.exr", shot.name));
    difference(actual, reference).write(&difference_path, shot.frame, time_seconds)?;
    Ok(vec![actual_path, difference_path])
}

/// The absolute difference of every colour, with the difference of alpha added to all three and full coverage, so
/// that any difference can be seen.
fn difference(actual: &Picture, reference: &Picture) -> Picture {
    let pixel = |(ours, theirs): (&[f32; 4], &[f32; 4])| {
        let [r, g, b, a] = [0, 1, 2, 3].map(|channel| (ours[channel] - theirs[channel]).abs());
        [r + a, g + a, b + a, 1.0]
    };
    Picture { size: actual.size, pixels: actual.pixels.iter().zip(&reference.pixels).map(pixel).collect() }
}
