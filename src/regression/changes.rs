//! What changed between the scenes of two images, as their files tell.

use crate::image::{PartHashes, RenderedScene};

/// Largest difference of a number of a camera's matrices that rounding explains, as a share of the number or of 1.
const ROUNDING: f32 = 1e-5;

/// A part of what an image is rendered from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Position, direction or lens of the camera.
    Camera,
    /// Vertices and poses.
    Geometry,
    /// Colours of vertices, and nothing else of geometry.
    VertexColors,
    /// Materials and textures.
    Materials,
    /// Lights and the environment.
    Lights,
    /// The plate behind the scene, or whether the environment shows.
    Background,
    /// Near or far plane of the camera.
    ClipPlanes,
}

/// The parts that differ. `None` unless both files tell their camera and their parts.
pub(super) fn changed_parts(actual: &RenderedScene, reference: &RenderedScene) -> Option<Vec<Part>> {
    let cameras = (actual.camera.as_ref()?, reference.camera.as_ref()?);
    let (is_moved, has_other_planes) =
        (has_moved(cameras.0, cameras.1), has_other_planes(cameras.0, cameras.1));
    let (ours, theirs) = (actual.parts.as_ref()?, reference.parts.as_ref()?);
    // Hashes of other rules differ in equal scenes. Those of the first have no number in files of earlier versions.
    if ours.rules.unwrap_or(1) != theirs.rules.unwrap_or(1) {
        return None;
    }
    let both = ours.background.as_ref().zip(theirs.background.as_ref());
    let others = [
        (Part::Camera, is_moved),
        (Part::ClipPlanes, !is_moved && has_other_planes),
        (Part::Background, both.is_some_and(|(ours, theirs)| ours != theirs)),
    ];
    let others = others.into_iter().filter(|(_, differs)| *differs).map(|(part, _)| part);
    Some(others.chain(different_parts(ours, theirs).map(|(part, _)| part)).collect())
}

/// The parts whose hashes differ, with their names.
fn different_parts(
    ours: &PartHashes,
    theirs: &PartHashes,
) -> impl Iterator<Item = (Part, &'static str)> + use<> {
    // Earlier versions hashed colours with the other vertices alone.
    let (has_other_shape, has_other_colors) = match (&ours.shape, &theirs.shape) {
        (Some(shape), Some(other)) => (shape != other, shape == other && ours.geometry != theirs.geometry),
        _ => (ours.geometry != theirs.geometry, false),
    };
    // Other geometry has other assignments.
    let has_other_assignments = ours.geometry == theirs.geometry && ours.assignments != theirs.assignments;
    let parts = [
        (Part::Geometry, "geometry", has_other_shape),
        (Part::VertexColors, "vertex colours", has_other_colors),
        (
            Part::Materials,
            "materials or textures",
            ours.materials != theirs.materials || has_other_assignments,
        ),
        (Part::Lights, "lights or the environment", ours.lights != theirs.lights),
    ];
    parts.into_iter().filter(|(.., differs)| *differs).map(|(part, name, _)| (part, name))
}

/// Whether both files name the rules of their hashes, and these are the same.
fn has_equal_rules(actual: &RenderedScene, reference: &RenderedScene) -> bool {
    let rules = |scene: &RenderedScene| scene.parts.as_ref().and_then(|parts| parts.rules);
    rules(actual).is_some() && rules(actual) == rules(reference)
}

/// What changed of the scene of an image of equal pixels, one line each. Empty unless both files tell their parts by the same rules.
pub(super) fn hidden_changes(actual: &RenderedScene, reference: &RenderedScene) -> Vec<String> {
    let Some((ours, theirs)) = actual.parts.as_ref().zip(reference.parts.as_ref()) else { return Vec::new() };
    if !has_equal_rules(actual, reference) {
        return Vec::new();
    }
    different_parts(ours, theirs)
        .map(|(_, name)| format!("{name} changed where this image does not show it"))
        .collect()
}

/// What changed of a scene that pixels need not show, one line each. Empty unless both files list their content, as references do.
pub(super) fn scene_changes(
    actual: &RenderedScene,
    reference: &RenderedScene,
    is_identical: bool,
) -> Vec<String> {
    let Some((ours, theirs)) = actual.content.as_ref().zip(reference.content.as_ref()) else {
        return Vec::new();
    };
    let mut lines = if is_identical { hidden_changes(actual, reference) } else { Vec::new() };
    // Checksums of motions belong to the rules of the other hashes.
    if has_equal_rules(actual, reference) {
        lines.extend(ours.alterations_since(theirs));
    }
    lines
}

/// Whether the matrices of two cameras differ by more than rounding. The row of depth in the second, to the display window, does not
/// count: near and far planes move nothing.
pub(super) fn has_moved(actual: &[[f32; 16]; 2], reference: &[[f32; 16]; 2]) -> bool {
    let numbers = |[camera, window]: &[[f32; 16]; 2]| {
        let shown = window.iter().enumerate().filter(|(index, _)| index % 4 != 2);
        camera.iter().copied().chain(shown.map(|(_, number)| *number)).collect::<Vec<_>>()
    };
    differ(&numbers(actual), &numbers(reference))
}

/// Whether two cameras that have not moved cut off other depths.
fn has_other_planes([_, actual]: &[[f32; 16]; 2], [_, reference]: &[[f32; 16]; 2]) -> bool {
    let depth = |window: &[f32; 16]| [2, 6, 10, 14].map(|index| window[index]);
    differ(&depth(actual), &depth(reference))
}

/// Whether numbers differ by more than rounding.
fn differ(actual: &[f32], reference: &[f32]) -> bool {
    let is_other =
        |(a, b): (&f32, &f32)| (a - b).abs() > ROUNDING * if b.abs() > 1.0 { b.abs() } else { 1.0 };
    actual.iter().zip(reference).any(is_other)
}
