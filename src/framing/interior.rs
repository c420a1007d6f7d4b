//! Scenes that are seen from inside.

use super::{CameraRule, resolve_camera};
use crate::error::Result;
use crate::scene::{CameraRequest, ClipSelection, Scene, Selection, SelectionRequest, ViewRequest};

/// Whether the automatic camera sees the default scene from inside.
///
/// # Errors
/// Those of selecting the default scene.
pub fn is_interior(scene: &Scene) -> Result<bool> {
    let request = SelectionRequest {
        clips: ClipSelection::None,
        camera: Some(CameraRequest::Auto),
        ..Default::default()
    };
    let (selection, _) = Selection::resolve(&request, scene)?;
    Ok(resolve_camera(scene, selection, &ViewRequest::default(), 16.0 / 9.0).rule == CameraRule::Inside)
}
