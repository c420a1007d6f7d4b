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
        // Other geometry has other assignments.
        (
            Part::Materials,
            ours.materials != theirs.materials
                || ours.geometry == theirs.geometry && ours.assignments != theirs.assignments,
        ),
        (Part::Lights, ours.lights != theirs.lights),
    ];
    Some(parts.into_iter().filter(|(_, differs)| *differs).map(|(part, _)| part).collect())
}

/// Whether the matrices of two cameras differ by more than rounding. The row of depth in the second, to the display window, does not
/// count: near and far planes move nothing.
pub(super) fn has_moved(actual: &[[f32; 16]; 2], reference: &[[f32; 16]; 2]) -> bool {
    let numbers = |[camera, window]: &[[f32; 16]; 2]| {
        let shown = window.iter().enumerate().filter(|(index, _)| index % 4 != 2);
        camera.iter().copied().chain(shown.map(|(_, number)| *number)).collect::<Vec<_>>()
    };
    numbers(actual)
        .into_iter()
        .zip(numbers(reference))
        .any(|(a, b)| (a - b).abs() > ROUNDING * if b.abs() > 1.0 { b.abs() } else { 1.0 })
}
