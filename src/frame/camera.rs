//! Posing a whole frame: its surfaces and lights, then the selected camera.

use glam::Mat4;

use super::auto_camera::auto_camera;
use super::posed_nodes::{PosedCamera, posed_camera};
use super::surfaces::{Frame, Scratch};
use super::transform;
use crate::scene::{Projection, Scene, SelectedCamera, Selection};

impl Frame {
    /// The scene at `time_seconds`.
    pub fn at(scene: &Scene, selection: &Selection, time_seconds: f64) -> Self {
        let mut frame = Self::default();
        frame.pose(scene, selection, time_seconds);
        frame
    }

    /// Poses `scene` at `time_seconds` and reuses the memory of `self`.
    ///
    /// A [`SelectedCamera::Auto`] is computed anew for a square image at each call. For several frames, resolve it once with
    /// [`super::resolve_auto_camera`].
    pub fn pose(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        self.pose_surfaces(scene, selection, time_seconds);
        let Scratch { pose, world, .. } = &self.scratch;
        self.camera = selected_camera(scene, selection, &pose.projections, world);
    }

    /// The camera alone at `time_seconds`.
    pub fn camera_at(scene: &Scene, selection: &Selection, time_seconds: f64) -> PosedCamera {
        let Scratch { mut pose, mut world, .. } = Scratch::default();
        pose.play(scene, selection, time_seconds, &mut Vec::new());
        transform::world_matrices(scene, &pose.local, &mut world);
        selected_camera(scene, selection, &pose.projections, &world)
    }
}

/// The selected camera in world space.
fn selected_camera(
    scene: &Scene,
    selection: &Selection,
    projections: &[Projection],
    world: &[Mat4],
) -> PosedCamera {
    let posed = match selection.camera {
        SelectedCamera::Auto => None,
        SelectedCamera::Fixed { world_from_camera, projection } => {
            Some(PosedCamera { world_from_camera, projection })
        }
        SelectedCamera::Node(node) => posed_camera(scene, projections, node, world),
    };
    posed.unwrap_or_else(|| auto_camera(scene, selection, 1.0))
}
