//! The ground below what a camera frames.

use glam::Vec3;

use super::subject::Subject;
use crate::scene::{Ground, Scene, Selection};

/// Gap between the lowest point and the ground, as a share of the framed diagonal: wide enough for the rounding of rays that a
/// camera sends from a hundred diagonals away, and less than a tenth of a pixel in an image of 2000 rows.
const GAP: f32 = 1.0 / 32_768.0;
/// The gap's least size, as a share of the largest coordinate: eight steps between numbers of single precision.
const LEAST_GAP: f32 = 8.0 * f32::EPSILON;
/// A floor lies at most this share of the framed diagonal below the lowest framed point. Lower ones belong to skies.
const FLOOR_DEPTH: f32 = 0.5;

/// The plane perpendicular to `up` just below the lowest point of the scene over the whole animation, or below its own floor, so that
/// no shadow is caught twice. `None` where nothing is visible.
pub fn ground_below(
    scene: &Scene,
    selection: &Selection,
    up: Option<Vec3>,
    is_mirror: bool,
) -> Option<Ground> {
    let up = up.and_then(Vec3::try_normalize).unwrap_or(Vec3::Y);
    let subject = Subject::measure(scene, selection, None);
    if subject.is_empty {
        return None;
    }
    let lowest = -subject.supports(&[-up])[0];
    let diagonal = subject.bounds.extent().length();
    let is_near = |height: &f32| lowest - height <= diagonal * FLOOR_DEPTH;
    let lowest = subject.floor_heights(up).into_iter().filter(is_near).fold(lowest, f32::min);
    let farthest = subject.bounds.min.abs().max(subject.bounds.max.abs()).max_element();
    let (gap, least) = (diagonal * GAP, farthest * LEAST_GAP);
    Some(Ground { up, height: lowest - if gap > least { gap } else { least }, is_mirror })
}
