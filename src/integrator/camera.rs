//! Rays from the camera through a picture.

use glam::{Vec2, Vec3};

use super::{Footprint, MediaStack, Path, PathClass, Spectrum};
use crate::frame::PosedCamera;
use crate::geometry::Ray;
use crate::scene::Projection;

/// A camera with a picture in front of it.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays {
    camera: PosedCamera,
    resolution: Vec2,
    /// Half the picture at distance one (perspective) or in metres (orthographic).
    half_size: Vec2,
    footprint: Footprint,
    time_seconds: f32,
}

impl CameraRays {
    /// Prepares rays through a picture of `resolution` pixels.
    pub fn new(camera: &PosedCamera, resolution: (u32, u32), time_seconds: f32) -> Self {
        let resolution = Vec2::new(resolution.0 as f32, resolution.1 as f32);
        let half_size = camera.projection.half_size(resolution.x / resolution.y);
        let pixel = 2.0 * half_size.y / resolution.y;
        let footprint = match camera.projection {
            Projection::Perspective { .. } => Footprint { width: 0.0, spread: pixel },
            Projection::Orthographic { .. } => Footprint { width: pixel, spread: 0.0 },
        };
        Self { camera: *camera, resolution, half_size, footprint, time_seconds }
    }

    /// The ray through `position`, in pixels from the picture's top left corner.
    pub fn ray(&self, position: Vec2) -> Ray {
        let ndc = (position / self.resolution) * 2.0 - Vec2::ONE;
        let on_plane = Vec2::new(ndc.x, -ndc.y) * self.half_size;
        let (origin, direction, clip) = match self.camera.projection {
            Projection::Perspective { z_near, z_far, .. } => {
                let direction = on_plane.extend(-1.0);
                // Planes at z_near and z_far are this much farther along the slanted ray.
                let slant = direction.length();
                let far = z_far.map_or(f32::INFINITY, |z_far| z_far * slant);
                (Vec3::ZERO, direction / slant, (z_near * slant, far))
            }
            Projection::Orthographic { z_near, z_far, .. } => {
                (on_plane.extend(0.0), Vec3::NEG_Z, (z_near, z_far))
            }
        };
        let world_from_camera = &self.camera.world_from_camera;
        Ray {
            origin: world_from_camera.transform_point3(origin),
            direction: world_from_camera.transform_vector3(direction),
            t_min: clip.0,
            t_max: clip.1,
        }
    }

    /// The path of a ray that starts in `media`, for sample `sample` of a batch.
    pub fn path(&self, media: MediaStack, sample: u32) -> Path {
        Path {
            time_seconds: self.time_seconds,
            footprint: self.footprint,
            media,
            touching: None,
            weight: Vec3::ONE,
            class: PathClass::Camera,
            spectrum: Spectrum::White,
            depth: 0,
            sample,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn perspective(aspect_ratio: Option<f32>) -> Projection {
        // tan(45°) = 1: the authored half height is one.
        let fov_y_radians = std::f32::consts::FRAC_PI_2;
        Projection::Perspective { fov_y_radians, aspect_ratio, z_near: 0.1, z_far: None }
    }

    #[test]
    fn the_top_left_corner_is_up_and_left() {
        let camera = PosedCamera { projection: perspective(None), ..PosedCamera::default() };
        let rays = CameraRays::new(&camera, (4, 2), 0.0);
        let corner = rays.ray(Vec2::ZERO);
        assert!(corner.direction.abs_diff_eq(Vec3::new(-2.0, 1.0, -1.0).normalize(), 1e-6));
        // The near plane at 0.1 is 0.1 · |(−2, 1, −1)| along this ray.
        assert!((corner.t_min - 0.1 * libm::sqrtf(6.0)).abs() < 1e-6);
        let middle = rays.ray(Vec2::new(2.0, 1.0));
        assert_eq!(middle.direction, Vec3::NEG_Z);
    }
}
