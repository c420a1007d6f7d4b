//! Cameras whose image the subject fits: perspective ones by their distance, parallel ones by their height.

use glam::{Mat3, Mat4, Vec2, Vec3};

use super::orbit::Direction;
use super::subject::Subject;
use crate::scene::Projection;

/// Share of the image that the subject fills in the direction in which it is largest.
const FILLED: f32 = 0.8;
/// Half of the framed extent at a distance of 1 beyond which a camera may stand on the nearest framed point: from about 150° on.
const VERY_WIDE: f32 = 3.0;
/// Least distance of such a camera from the nearest framed point, as a share of the framed diagonal.
const LEAST_DISTANCE: f32 = 1e-3;
/// Azimuths at which the subject must fit a turntable's image.
const TURNTABLE_AZIMUTHS: u16 = 32;

/// A camera that fits the subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    /// Rotation and translation; columns are right, up, backward, position.
    pub(super) world_from_camera: Mat4,
    /// Distance from the camera to the subject's centre along the viewing axis, metres.
    pub(super) distance: f32,
    /// Half the height of a parallel view, metres.
    pub(super) half_height: Option<f32>,
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
        backward,
    ];
    let supports = subject.supports(&sides);
    let center = subject.bounds.center();
    if supports.iter().any(|support| !support.is_finite()) {
        return around_center(axes, center, distance * 2.0 / size.min_element());
    }
    let x = (supports[0] - supports[1]) * 0.5;
    let y = (supports[2] - supports[3]) * 0.5;
    let z = ((supports[0] + supports[1]) * 0.5 / size.x).max((supports[2] + supports[3]) * 0.5 / size.y);
    // A very wide camera would see all from the nearest point itself.
    let z = if size.max_element() > VERY_WIDE {
        z.max(supports[4] + subject.bounds.extent().length() * LEAST_DISTANCE)
    } else {
        z
    };
    let from_center = nonzero(z - backward.dot(center), subject) * distance;
    let position = right * x + up * y + backward * (backward.dot(center) + from_center);
    Fitted { world_from_camera: camera(axes, position), distance: from_center, half_height: None }
}

/// The parallel view along `axes` that shows the whole subject in the middle of the image, `distance` times as high as it fits. The camera
/// stands beyond the subject.
pub(super) fn fit_parallel(subject: &Subject<'_>, axes: Mat3, aspect_ratio: f32, distance: f32) -> Fitted {
    let [right, up, backward] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let supports = subject.supports(&[right, -right, up, -up, backward]);
    let center = subject.bounds.center();
    let &[to_right, to_left, to_top, to_bottom, nearest] = supports.as_slice() else {
        return parallel_around_center(axes, center, distance, 1.0);
    };
    if supports.iter().any(|support| !support.is_finite()) {
        return parallel_around_center(axes, center, distance, 1.0);
    }
    let half = ((to_right + to_left) * 0.5 / aspect_ratio).max((to_top + to_bottom) * 0.5) / FILLED;
    let half_height = nonzero(half, subject) * distance;
    let [x, y] = [(to_right - to_left) * 0.5, (to_top - to_bottom) * 0.5];
    let position = right * x + up * y + backward * (nearest + half_height);
    let from_center = nearest + half_height - backward.dot(center);
    Fitted {
        world_from_camera: camera(axes, position),
        distance: from_center,
        half_height: Some(half_height),
    }
}

/// The nearest camera around the subject's centre that shows the subject at all azimuths, at the one of `from`.
pub(super) fn fit_turntable(
    subject: &Subject<'_>,
    from: &Direction,
    projection: &Projection,
    aspect_ratio: f32,
) -> Fitted {
    let size = fitting_size(projection, aspect_ratio);
    let mut sides = Vec::new();
    for axes in turned_axes(from) {
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
    around_center(from.axes(), center, nonzero(distance, subject) * from.orbit.distance)
}

/// The parallel view around the subject's centre that shows the subject at all azimuths, at the one of `from`.
pub(super) fn fit_parallel_turntable(subject: &Subject<'_>, from: &Direction, aspect_ratio: f32) -> Fitted {
    let (mut sides, mut scales) = (Vec::new(), Vec::new());
    for axes in turned_axes(from) {
        sides.extend([axes.x_axis, -axes.x_axis, axes.y_axis, -axes.y_axis, axes.z_axis]);
        scales.extend([1.0 / aspect_ratio, 1.0 / aspect_ratio, 1.0, 1.0, 0.0]);
    }
    let center = subject.bounds.center();
    let supports = subject.supports(&sides);
    let reaches: Vec<_> =
        supports.iter().zip(&sides).map(|(support, side)| support - side.dot(center)).collect();
    let axes = from.axes();
    if reaches.iter().any(|reach| !reach.is_finite()) {
        return parallel_around_center(axes, center, from.orbit.distance, 1.0);
    }
    let half = reaches.iter().zip(&scales).map(|(reach, scale)| reach * scale).fold(0.0, f32::max) / FILLED;
    let nearest = reaches.chunks_exact(5).map(|reaches| reaches[4]).fold(0.0, f32::max);
    parallel_around_center(axes, center, nonzero(half, subject) * from.orbit.distance, nearest)
}

/// The axes of [`TURNTABLE_AZIMUTHS`] around the vertical axis, from those of `from` on.
fn turned_axes(from: &Direction) -> impl Iterator<Item = Mat3> {
    let from = *from;
    (0..TURNTABLE_AZIMUTHS)
        .map(move |step| from.turned(f32::from(step) * (360.0 / f32::from(TURNTABLE_AZIMUTHS))).axes())
}

/// A point or nothing is seen from one metre or from the bounds' size.
fn nonzero(distance: f32, subject: &Subject<'_>) -> f32 {
    if distance > 0.0 { distance } else { subject.bounds.extent().max_element().max(1.0) }
}

fn around_center(axes: Mat3, center: Vec3, distance: f32) -> Fitted {
    let world_from_camera = camera(axes, center + axes.z_axis * distance);
    Fitted { world_from_camera, distance, half_height: None }
}

/// The parallel view of the centre, from beyond what reaches towards it.
fn parallel_around_center(axes: Mat3, center: Vec3, half_height: f32, reach: f32) -> Fitted {
    Fitted { half_height: Some(half_height), ..around_center(axes, center, reach + half_height) }
}

fn camera(axes: Mat3, position: Vec3) -> Mat4 {
    let mut camera = Mat4::from_mat3(axes);
    camera.w_axis = position.extend(1.0);
    camera
}
