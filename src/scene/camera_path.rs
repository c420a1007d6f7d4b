//! Camera that moves along keys of its own, or as the animated camera of another file.

use std::sync::Arc;

use glam::{DVec3, Mat4, Vec3};

use super::animation::first_key_seconds;
use super::camera_curve::{KeyedPoint, KeyedValue};
use super::camera_placement::{look_along, rolled};
use super::{AnimationIndex, NodeIndex, Projection, Scene};

/// Camera that moves along a path. Time is in seconds from frame 0.
#[derive(Clone, Debug)]
pub struct CameraPath {
    /// What moves the camera.
    pub motion: CameraMotion,
    /// Text that is equal exactly for equal paths.
    pub content_key: String,
    /// Name for messages.
    pub label: String,
    /// Time of the last key, or the length of a loop.
    pub duration_seconds: f64,
    /// Whether the path closes, so that its end is its beginning.
    pub is_loop: bool,
}

impl CameraPath {
    /// Time of the first key; 0 for a loop, which has none.
    pub fn start_seconds(&self) -> f64 {
        match &self.motion {
            _ if self.is_loop => 0.0,
            CameraMotion::Keys(keys) => keys.position.start_seconds(),
            CameraMotion::Scene { scene, clips, .. } => {
                f64::from(first_key_seconds(&scene.animations, clips))
            }
        }
    }
}

impl PartialEq for CameraPath {
    fn eq(&self, other: &Self) -> bool {
        self.content_key == other.content_key
    }
}

/// What moves the camera of a path.
#[derive(Clone, Debug)]
pub enum CameraMotion {
    /// Keys.
    Keys(Box<CameraKeys>),
    /// Camera of another scene, which plays its own clips.
    Scene {
        /// The scene.
        scene: Arc<Scene>,
        /// Clips that play together.
        clips: Vec<AnimationIndex>,
        /// Node of the camera.
        node: NodeIndex,
    },
}

/// Position, target, roll and field of view over time.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraKeys {
    /// Position, metres.
    pub position: KeyedPoint,
    /// Point in the centre of the image, metres.
    pub target: KeyedPoint,
    /// Rotation about the viewing axis, degrees, where any key has it.
    pub roll_degrees: Option<KeyedValue>,
    /// Vertical field of view, degrees, where any key has it.
    pub fov_degrees: Option<KeyedValue>,
}

impl CameraKeys {
    /// The camera at `time_seconds`, with +Y up, and its field of view where the keys have one.
    pub fn at(&self, time_seconds: f64) -> (Mat4, Option<Projection>) {
        let point = |keyed: &KeyedPoint| -> Vec3 { DVec3::from_array(keyed.at(time_seconds)).as_vec3() };
        let position = point(&self.position);
        let camera = look_along(position, position - point(&self.target), Vec3::Y);
        let roll = self.roll_degrees.as_ref().map_or(0.0, |roll| roll.at(time_seconds));
        let projection = self.fov_degrees.as_ref().map(|fov| Projection::Perspective {
            fov_y_radians: fov.at(time_seconds).to_radians() as f32,
            aspect_ratio: None,
            z_near: 0.0,
            z_far: None,
        });
        (rolled(camera, roll.to_radians() as f32), projection)
    }
}
