//! Distances at which the subject fits the image.

use glam::{Mat3, Mat4, Vec2, Vec3};

use super::orbit::axes;
use super::subject::Subject;
use crate::scene::{Orbit, Projection};

/// Share of the image that the subject fills in the direction in which it is largest.
const FILLED: f32 = 0.8;
/// Azimuths at which the subject must fit a turntable's image.
const TURNTABLE_AZIMUTHS: u16 = 32;

/// A camera that fits the subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    /// Rotation and translation; columns are right, up, backward, position.
    pub(super) world_from_camera: Mat4,
    /// Distance from the camera to the subject's centre along the viewing axis, metres.
    pub(super) distance: f32,
}

/// Half the width and height, at distance one, in which the subject must fit.
fn fitting_size(projection: &Projection, aspect_ratio: f32) -> Vec2 {
    projection.half_size(aspect_ratio) * FILLED
}

/// The nearest camera along `axes` that shows the whole subject in the middle of the image, moved away by the factor `distance`.
///
/// Every corner p lies within the four sides of the view: |p.x − c.x| ≤ size.x (c.z − p.z) in the camera's axes, and alike for y.
/// The largest p.x + size.x p.z and −p.x + size.x p.z give c.x and the least c.z; y gives another least c.z.
pub(super) fn fit(
    subject: &Subject<'_>,
    axes: Mat3,
    projection: &Projection,
    aspect_ratio: f32,
    distance: f32,
) -> Fitted {
    let size = fitting_size(projection, aspect_ratio);
    let [right, up, backward] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let sides = [
        right + backward * size.x,
        backward * size.x - right,
        up + backward * size.y,
        backward * size.y - up,
    ];
    let supports = subject.supports(&sides);
    let center = subject.bounds.center();
    if supports.iter().any(|support| !support.is_finite()) {
        return around_center(axes, center, distance * 2.0 / size.min_element());
    }
    let x = (supports[0] - supports[1]) * 0.5;
    let y = (supports[2] - supports[3]) * 0.5;
    let z = ((supports[0] + supports[1]) * 0.5 / size.x).max((supports[2] + supports[3]) * 0.5 / size.y);
    let from_center = nonzero(z - backward.dot(center), subject) * distance;
    let position = right * x + up * y + backward * (backward.dot(center) + from_center);
    Fitted { world_from_camera: camera(axes, position), distance: from_center }
}

/// The nearest camera around the subject's centre that shows the subject at all azimuths, at the one of `orbit`.
pub(super) fn fit_turntable(
    subject: &Subject<'_>,
    orbit: &Orbit,
    up: Vec3,
    projection: &Projection,
    aspect_ratio: f32,
) -> Fitted {
    let size = fitting_size(projection, aspect_ratio);
    let mut sides = Vec::new();
    for step in 0..TURNTABLE_AZIMUTHS {
        let turned = f32::from(step) * (360.0 / f32::from(TURNTABLE_AZIMUTHS));
        let axes = axes(&Orbit { azimuth_degrees: orbit.azimuth_degrees + turned, ..*orbit }, up);
        for (side, size) in [(axes.x_axis, size.x), (axes.y_axis, size.y)] {
            sides.push(axes.z_axis + side / size);
            sides.push(axes.z_axis - side / size);
        }
    }
    let center = subject.bounds.center();
    let supports = subject.supports(&sides);
    let distances = supports.iter().zip(&sides).map(|(support, side)| support - side.dot(center));
    let distance = distances.fold(f32::NEG_INFINITY, f32::max);
    let distance = if distance.is_finite() { distance } else { 2.0 / size.min_element() };
    around_center(axes(orbit, up), center, nonzero(distance, subject) * orbit.distance)
}

/// A point or nothing is seen from one metre or from the bounds' size.
fn nonzero(distance: f32, subject: &Subject<'_>) -> f32 {
    if distance > 0.0 { distance } else { subject.bounds.extent().max_element().max(1.0) }
}

fn around_center(axes: Mat3, center: Vec3, distance: f32) -> Fitted {
    Fitted { world_from_camera: camera(axes, center + axes.z_axis * distance), distance }
}

fn camera(axes: Mat3, position: Vec3) -> Mat4 {
    let mut camera = Mat4::from_mat3(axes);
    camera.w_axis = position.extend(1.0);
    camera
}
