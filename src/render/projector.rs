//! Projection of points and directions into the image of a camera: the inverse of a pinhole camera ray.

use glam::{DMat4, DVec2, DVec3};

use crate::frame::PosedCamera;
use crate::scene::Projection;

/// Projection of one camera and image size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projector {
    camera_from_world: DMat4,
    is_perspective: bool,
    resolution: DVec2,
    /// Half the image at distance one (perspective) or in metres (orthographic).
    half_size: DVec2,
}

impl Projector {
    pub(super) fn new(camera: &PosedCamera, (width, height): (u32, u32)) -> Self {
        Self {
            camera_from_world: camera.world_from_camera.as_dmat4().inverse(),
            is_perspective: matches!(camera.projection, Projection::Perspective { .. }),
            resolution: DVec2::new(f64::from(width), f64::from(height)),
            half_size: camera.projection.half_size(width as f32 / height as f32).as_dvec2(),
        }
    }

    /// Position of a point in pixels from the top left corner; `None` for points that are not in front of the camera.
    pub(super) fn pixel_of_point(&self, point: DVec3) -> Option<DVec2> {
        let point = self.camera_from_world.transform_point3(point);
        let depth = -point.z;
        let distance = if self.is_perspective { depth } else { 1.0 };
        (depth > 0.0).then(|| self.pixel(point.truncate() / distance))
    }

    /// Position of an infinitely distant point in the given direction. `None` behind the camera, and for orthographic cameras, whose
    /// parallel rays all see the same distant point.
    pub(super) fn pixel_of_direction(&self, direction: DVec3) -> Option<DVec2> {
        let direction = self.camera_from_world.transform_vector3(direction);
        let is_ahead = self.is_perspective && direction.z < 0.0;
        is_ahead.then(|| self.pixel(direction.truncate() / -direction.z))
    }

    fn pixel(&self, on_plane: DVec2) -> DVec2 {
        let ndc = on_plane / self.half_size;
        (DVec2::new(ndc.x, -ndc.y) + DVec2::ONE) * 0.5 * self.resolution
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Quat, Vec2, Vec3};

    use super::*;
    use crate::integrator::{CameraRays, Seed};

    #[test]
    fn points_on_a_camera_ray_project_to_its_pixel() {
        let rotation = Quat::from_xyzw(0.6, 0.0, 0.0, 0.8);
        let world_from_camera = Mat4::from_rotation_translation(rotation, Vec3::new(1.0, -2.0, 3.0));
        for projection in [
            Projection::Perspective { fov_y_radians: 0.7, aspect_ratio: None, z_near: 0.1, z_far: None },
            Projection::Orthographic { x_mag: 2.0, y_mag: 3.0, z_near: 0.1, z_far: 9.0 },
        ] {
            let camera = PosedCamera { world_from_camera, projection };
            let rays = CameraRays::new(&camera, (64, 48), 0.0, None);
            let projector = Projector::new(&camera, (64, 48));
            for position in [Vec2::new(0.5, 0.5), Vec2::new(40.25, 7.0)] {
                let ray = rays.ray(position, Seed::default());
                let pixel = projector.pixel_of_point(ray.at(5.0).as_dvec3()).unwrap();
                assert!((pixel - position.as_dvec2()).length() < 1e-4, "{pixel}");
                assert_eq!(projector.pixel_of_point(ray.at(-5.0).as_dvec3()), None);
                let far = projector.pixel_of_direction(ray.direction.as_dvec3());
                let is_near = |far: DVec2| (far - position.as_dvec2()).length() < 1e-4;
                assert_eq!(far.is_some_and(is_near), projector.is_perspective);
            }
        }
    }
}
