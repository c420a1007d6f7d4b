//! Cameras that are not the file's, and what decides cameras.

use crate::scene::SelectedCamera;

/// What decided the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CameraRule {
    /// A camera of the file.
    OfFile,
    /// A camera of the file, with changes.
    Changed,
    /// The request.
    Requested,
    /// A turntable.
    Turntable,
    /// Automatic: the scene is seen from outside.
    Outside,
    /// Automatic: the scene is an interior, seen from inside.
    Inside,
}

/// A camera that is not the file's, and what decided it.
#[derive(Clone, Debug)]
pub(super) struct OwnCamera {
    pub(super) camera: SelectedCamera,
    pub(super) rule: CameraRule,
}
