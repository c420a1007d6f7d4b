//! The ground below what a camera frames.

use glam::Vec3;

use super::shared::SharedFraming;
use super::subject::Subject;
use crate::geometry::Aabb;
use crate::scene::{Ground, Scene, Selection, ViewRequest};

/// Gap between the lowest point and the ground, as a share of the framed diagonal: wide enough for the rounding of rays that a
/// camera sends from a hundred diagonals away, and less than a tenth of a pixel in an image of 2000 rows.
const GAP: f32 = 1.0 / 32_768.0;
/// The gap's least size, as a share of the largest coordinate, those of floors included: eight steps between numbers of single
/// precision, so that a floor of large triangles hides the ground.
const LEAST_GAP: f32 = 8.0 * f32::EPSILON;
/// A floor lies at most this share of the framed diagonal below the lowest framed point. Lower ones belong to skies.
const FLOOR_DEPTH: f32 = 0.5;

/// The plane perpendicular to the view's direction up just below the lowest point of the scene over the whole animation, or below its
/// own floor, so that no shadow is caught twice. `None` where nothing is visible.
pub fn ground_below(
    scene: &Scene,
    selection: &Selection,
    view: &ViewRequest,
    is_mirror: bool,
) -> Option<Ground> {
    SharedFraming::of_one(scene).ground_below(selection, view, is_mirror)
}

impl SharedFraming<'_> {
    /// [`ground_below`] of the scene.
    pub(crate) fn ground_below(
        &self,
        selection: &Selection,
        view: &ViewRequest,
        is_mirror: bool,
    ) -> Option<Ground> {
        let up = view.up.and_then(Vec3::try_normalize).unwrap_or(Vec3::Y);
        let level = ViewRequest {
            up: Some(up),
            measured_clips: view.measured_clips.clone(),
            ..ViewRequest::default()
        };
        let make = || below(&self.subject(selection, None, &view.measured_clips), up);
        let ground = self.ground(Self::framed(selection, &level, 1.0), make);
        ground.map(|ground| Ground { is_mirror, ..ground })
    }
}

/// The ground below a subject.
fn below(subject: &Subject<'_>, up: Vec3) -> Option<Ground> {
    if subject.is_empty {
        return None;
    }
    let lowest = -subject.supports(&[-up])[0];
    let diagonal = subject.bounds.extent().length();
    let mut floors = subject.floors(up);
    floors.retain(|(height, _)| lowest - height <= diagonal * FLOOR_DEPTH);
    let lowest = floors.iter().map(|(height, _)| *height).fold(lowest, f32::min);
    let bounds = floors.iter().map(|(_, bounds)| *bounds).fold(subject.bounds, Aabb::union);
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let (gap, least) = (diagonal * GAP, farthest * LEAST_GAP);
    Some(Ground { up, height: lowest - if gap > least { gap } else { least }, is_mirror: false })
}
