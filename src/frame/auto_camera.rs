//! Automatic camera for scenes without one: looks along −Z and frames the bounds of the whole animation.

use glam::{Mat4, Vec3};

use super::posed_nodes::PosedCamera;
use super::surfaces::Frame;
use crate::bvh::TriangleFlags;
use crate::geometry::Aabb;
use crate::scene::{Projection, Scene, SelectedCamera, Selection};

/// Times at which the bounds are sampled, evenly over the selected clips, both ends included.
const TIMES: usize = 65;
/// Empty margin around the bounds, as a fraction of half the image size.
const MARGIN: f32 = 0.05;

/// A camera that frames the scene's bounds over 65 evenly spaced times of the selected clips, for an image of `aspect_ratio`
/// (width over height).
///
/// The result depends on the clips only, never on the frames that are rendered.
pub(super) fn auto_camera(scene: &Scene, selection: &Selection, aspect_ratio: f32) -> PosedCamera {
    let mut bounds = Aabb::EMPTY;
    let mut frame = Frame::default();
    for time in sample_times(scene, selection) {
        frame.pose_surfaces(scene, selection, time);
        let visible =
            frame.triangles.iter().zip(&frame.flags).filter(|(_, flags)| !flags.has(TriangleFlags::HIDDEN));
        bounds = visible.fold(bounds, |bounds, (triangle, _)| bounds.union(triangle.bounds()));
    }
    frame_bounds(bounds, aspect_ratio)
}

/// Replaces an automatic camera by a fixed one for images of `aspect_ratio`; other cameras remain unchanged.
pub fn resolve_auto_camera(scene: &Scene, selection: Selection, aspect_ratio: f32) -> Selection {
    if selection.camera != SelectedCamera::Auto {
        return selection;
    }
    let PosedCamera { world_from_camera, projection } = auto_camera(scene, &selection, aspect_ratio);
    Selection { camera: SelectedCamera::Fixed { world_from_camera, projection }, ..selection }
}

/// [`TIMES`] times, or one if the clips have no duration.
fn sample_times(scene: &Scene, selection: &Selection) -> Vec<f64> {
    let durations = selection.clips.iter().map(|&clip| scene.animations[clip.index()].duration_seconds());
    let duration = f64::from(durations.fold(0.0, |a, b| if b > a { b } else { a }));
    if duration > 0.0 {
        (0..TIMES).map(|i| duration * i as f64 / (TIMES - 1) as f64).collect()
    } else {
        vec![0.0]
    }
}

fn frame_bounds(bounds: Aabb, aspect_ratio: f32) -> PosedCamera {
    let fov_y_radians = std::f32::consts::FRAC_PI_4;
    let bounds = if bounds.is_empty() { Aabb { min: -Vec3::ONE, max: Vec3::ONE } } else { bounds };
    let center = bounds.center();
    let half = bounds.extent() * 0.5;
    let tan_y = libm::tanf(fov_y_radians * 0.5) * (1.0 - MARGIN);
    let tan_x = tan_y * aspect_ratio;

    // The front face of the bounds appears largest in perspective. It must fit in both directions.
    let fit = (half.y / tan_y).max(half.x / tan_x);
    let distance = if fit > 0.0 { fit } else { half.max_element().max(1.0) };
    let position = Vec3::new(center.x, center.y, bounds.max.z + distance);
    let projection = Projection::Perspective { fov_y_radians, aspect_ratio: None, z_near: 0.0, z_far: None };
    PosedCamera { world_from_camera: Mat4::from_translation(position), projection }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_of_the_bounds_fills_the_image_up_to_the_margin() {
        let camera =
            frame_bounds(Aabb { min: Vec3::new(-2.0, -1.0, -5.0), max: Vec3::new(2.0, 1.0, 5.0) }, 1.0);
        // Square image, half width 2: distance · tan 22.5° · 0.95 = 2.
        let distance = 2.0 / (libm::tanf(std::f32::consts::FRAC_PI_8) * 0.95);
        let position = camera.world_from_camera.w_axis.truncate();
        assert!(position.abs_diff_eq(Vec3::new(0.0, 0.0, 5.0 + distance), 1e-4), "{position}");
    }

    #[test]
    fn empty_and_point_bounds_give_a_finite_camera() {
        for bounds in [Aabb::EMPTY, Aabb::from_point(Vec3::ONE)] {
            assert!(frame_bounds(bounds, 1.0).world_from_camera.is_finite());
        }
    }
}
