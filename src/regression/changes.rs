//! What changed between the scenes of two images, as their files tell.

use crate::image::RenderedScene;

/// Largest difference of a number of a camera's matrices that rounding explains, as a share of the number or of 1.
const ROUNDING: f32 = 1e-5;

/// A part of what an image is rendered from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Position, direction or lens of the camera.
    Camera,
    /// Vertices and poses.
    Geometry,
    /// Materials and textures.
    Materials,
    /// Lights and the environment.
    Lights,
}

/// The parts that differ. `None` unless both files tell their camera and their parts.
pub(super) fn changed_parts(actual: &RenderedScene, reference: &RenderedScene) -> Option<Vec<Part>> {
    let is_moved = has_moved(actual.camera.as_ref()?, reference.camera.as_ref()?);
    let (ours, theirs) = (actual.parts.as_ref()?, reference.parts.as_ref()?);
    let parts = [
        (Part::Camera, is_moved),
        (Part::Geometry, ours.geometry != theirs.geometry),
        (Part::Materials, ours.materials != theirs.materials),
        (Part::Lights, ours.lights != theirs.lights),
    ];
    Some(parts.into_iter().filter(|(_, differs)| *differs).map(|(part, _)| part).collect())
}

/// Whether the matrices of two cameras differ by more than rounding.
pub(super) fn has_moved(actual: &[[f32; 16]; 2], reference: &[[f32; 16]; 2]) -> bool {
    let numbers = actual.as_flattened().iter().zip(reference.as_flattened());
    numbers.into_iter().any(|(a, b)| (a - b).abs() > ROUNDING * if b.abs() > 1.0 { b.abs() } else { 1.0 })
}
