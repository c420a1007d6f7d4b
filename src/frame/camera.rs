//! Posing a whole frame: its surfaces and lights, then the selected camera.

use std::f32::consts::FRAC_PI_4;

use glam::Mat4;

use super::animation::ScenePose;
use super::posed_nodes::{PosedCamera, posed_camera};
use super::surface_pose::SurfacePose;
use super::surfaces::Frame;
use crate::scene::{CameraChanges, CameraMotion, CameraPath, Projection, Scene, SelectedCamera, Selection};

/// Projection of keys without a field of view: 45 degrees, as other requested cameras have.
const PATH_PROJECTION: Projection =
    Projection::Perspective { fov_y_radians: FRAC_PI_4, aspect_ratio: None, z_near: 0.0, z_far: None };

impl Frame {
    /// The scene at `time_seconds`.
    pub fn at(scene: &Scene, selection: &Selection, time_seconds: f64) -> Self {
        let mut frame = Self::default();
        frame.pose(scene, selection, time_seconds);
        frame
    }

    /// Poses `scene` at `time_seconds` and reuses the memory of `self`.
    ///
    /// [`crate::framing::resolve_camera`] replaces a [`SelectedCamera::Auto`] before; posed, it stands in the origin.
    pub fn pose(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        self.pose_surfaces(scene, selection, time_seconds);
        self.pose_camera(scene, selection);
    }

    /// Poses the camera of `selection` after the surfaces, at their time.
    pub(crate) fn pose_camera(&mut self, scene: &Scene, selection: &Selection) {
        let SurfacePose { pose, world, .. } = &self.scratch.now;
        self.camera = selected_camera(scene, selection, self.time_seconds, pose, world);
    }

    /// Poses a frame anew that was posed at any time with the same scene and selection. Without clips only its camera moves, and instances
    /// that are as before keep their vertices and triangles, which nothing else may have changed. Returns whether any triangle may have changed.
    pub fn pose_again(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) -> bool {
        if selection.clips.is_empty() && self.has_parts() {
            self.time_seconds = time_seconds;
            self.camera = Self::camera_at(scene, selection, time_seconds);
            false
        } else {
            let is_moved = self.pose_surfaces_again(scene, selection, time_seconds);
            self.pose_camera(scene, selection);
            is_moved
        }
    }

    /// The camera alone at `time_seconds`.
    pub fn camera_at(scene: &Scene, selection: &Selection, time_seconds: f64) -> PosedCamera {
        let (mut pose, mut world) = (ScenePose::default(), Vec::new());
        pose.play(scene, selection, time_seconds, &mut Vec::new());
        scene.world_matrices(&pose.local, &mut world);
        selected_camera(scene, selection, time_seconds, &pose, &world)
    }
}

/// The selected camera at `time_seconds` in world space.
fn selected_camera(
    scene: &Scene,
    selection: &Selection,
    time_seconds: f64,
    pose: &ScenePose,
    world: &[Mat4],
) -> PosedCamera {
    match &selection.camera {
        SelectedCamera::Auto => PosedCamera::default(),
        &SelectedCamera::Fixed { world_from_camera, projection } => {
            PosedCamera { world_from_camera, projection }
        }
        SelectedCamera::Turntable(turntable) => {
            PosedCamera { world_from_camera: turntable.at(time_seconds), projection: turntable.projection }
        }
        SelectedCamera::Node(node) => {
            let own = posed_camera(scene, pose, *node, world).unwrap_or_default();
            changed(own, &selection.camera_changes)
        }
        SelectedCamera::Path(path) => changed(on_path(path, time_seconds), &selection.camera_changes),
    }
}

fn changed(own: PosedCamera, changes: &CameraChanges) -> PosedCamera {
    if *changes == CameraChanges::default() {
        return own;
    }
    PosedCamera {
        world_from_camera: changes.apply(own.world_from_camera),
        // Planes may be animated.
        projection: changes
            .projection
            .map_or(own.projection, |projection| projection.with_planes_of(&own.projection)),
    }
}

fn on_path(path: &CameraPath, time_seconds: f64) -> PosedCamera {
    match &path.motion {
        CameraMotion::Scene { scene, clips, node } => {
            let selection = Selection {
                roots: Vec::new(),
                clips: clips.clone(),
                camera: SelectedCamera::Node(*node),
                camera_changes: CameraChanges::default(),
                image_light: None,
                variant: None,
            };
            Frame::camera_at(scene, &selection, time_seconds)
        }
        CameraMotion::Keys(keys) => {
            let (world_from_camera, projection) = keys.at(time_seconds);
            let projection = projection.unwrap_or(PATH_PROJECTION);
            PosedCamera { world_from_camera, projection }
        }
    }
}
