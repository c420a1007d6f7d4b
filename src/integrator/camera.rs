//! Camera rays, from a pinhole or from a thin lens.
//!
//! Source of the lens: Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984. Rays through one point of the image start
//! all over the lens and converge at the focus distance.

use glam::{Mat4, Vec2, Vec3};

use super::random::{Purpose, Seed};
use crate::frame::PosedCamera;
use crate::geometry::{F32Lanes, LANES, Ray, Vec3Lanes, concentric_disk_point};
use crate::interaction::RayDifferential;
use crate::scene::Projection;

/// Generator of the rays of one camera and image size.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays {
    camera: PosedCamera,
    resolution: Vec2,
    /// Half the image at distance one (perspective) or in metres (orthographic).
    half_size: Vec2,
    /// World-space steps from one sample to the next along rows and columns, at distance one or in metres.
    sample_steps: [Vec3; 2],
    /// See [`Seed::hashed_time`].
    hashed_time: u32,
    lens: Option<ThinLens>,
}

/// The differentials of several rays.
#[derive(Debug, Default)]
pub(super) struct DifferentialLanes {
    pub(super) origin: [Vec3Lanes; 2],
    pub(super) direction: [Vec3Lanes; 2],
}

impl DifferentialLanes {
    /// The differential of a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> RayDifferential {
        let pair = |lanes: &[Vec3Lanes; 2]| [lanes[0].get(lane), lanes[1].get(lane)];
        RayDifferential { origin: pair(&self.origin), direction: pair(&self.direction) }
    }
}

/// A thin, round, ideal lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// Metres.
    pub radius: f32,
    /// Distance of the focal plane along the axis of the lens, metres; may be infinite.
    pub focus_distance: f32,
}

impl CameraRays {
    /// Prepares rays through an image of `resolution` pixels. Without a lens everything is in focus.
    pub fn new(
        camera: &PosedCamera,
        resolution: (u32, u32),
        time_seconds: f32,
        lens: Option<ThinLens>,
    ) -> Self {
        let resolution = Vec2::new(resolution.0 as f32, resolution.1 as f32);
        let half_size = camera.projection.half_size(resolution.x / resolution.y);
        let step = half_size / resolution * 2.0;
        let world_from_camera = &camera.world_from_camera;
        let sample_steps =
            [Vec3::X * step.x, Vec3::NEG_Y * step.y].map(|step| world_from_camera.transform_vector3(step));
        Self {
            camera: *camera,
            resolution,
            half_size,
            sample_steps,
            hashed_time: Seed::hashed_time(time_seconds),
            lens,
        }
    }

    /// The same rays with the spacing of `samples` samples per pixel.
    #[must_use]
    pub fn sharing_pixels(self, samples: u32) -> Self {
        let scale = 1.0 / libm::sqrtf(samples as f32);
        Self { sample_steps: self.sample_steps.map(|step| step * scale), ..self }
    }

    /// The ray through `position`, in pixels from the top left corner of the image.
    pub fn ray(&self, position: Vec2, seed: Seed) -> Ray {
        let on_plane = self.image_plane().point(position);
        let (origin, direction) = match self.camera.projection {
            Projection::Perspective { .. } => (Vec3::ZERO, on_plane.extend(-1.0)),
            Projection::Orthographic { .. } => (on_plane.extend(0.0), Vec3::NEG_Z),
        };
        let (origin, direction) = match self.lens {
            Some(lens) => lens.refocus(origin, direction, seed),
            None => (origin, direction),
        };
        let (z_near, z_far) = self.depth_range();
        let world_from_camera = &self.camera.world_from_camera;
        let (direction, slant) = world_direction(world_from_camera, direction);
        let origin = world_from_camera.transform_point3(origin);
        Ray { origin, direction, t_min: z_near * slant, t_max: z_far * slant }
    }

    /// Whether all rays start in one point and do not depend on their seeds.
    pub(super) fn is_pinhole(&self) -> bool {
        self.lens.is_none() && matches!(self.camera.projection, Projection::Perspective { .. })
    }

    /// Replaces `rays` with the rays through `positions`, by columns and rows: [`CameraRays::ray`] of a pinhole, several at once.
    #[inline(always)]
    pub(super) fn pinhole_rays(&self, positions: [&[f32]; 2], rays: &mut Vec<Ray>) {
        let (image_plane, world_from_camera) = (self.image_plane(), self.camera.world_from_camera);
        let (z_near, z_far) = self.depth_range();
        let origin = world_from_camera.transform_point3(Vec3::ZERO);
        rays.clear();
        let [columns, rows] = positions;
        for (columns, rows) in columns.chunks(LANES).zip(rows.chunks(LANES)) {
            // The last chunk is filled up with zeros.
            let (mut x, mut y) = (F32Lanes::default(), F32Lanes::default());
            x[..columns.len()].copy_from_slice(columns);
            y[..rows.len()].copy_from_slice(rows);
            let (mut directions, mut slants) = (Vec3Lanes::default(), F32Lanes::default());
            for lane in 0..LANES {
                let on_plane = image_plane.point(Vec2::new(x[lane], y[lane]));
                let (direction, slant) = world_direction(&world_from_camera, on_plane.extend(-1.0));
                directions.set(lane, direction);
                slants[lane] = slant;
            }
            let ray = |lane: usize| {
                let (direction, slant) = (directions.get(lane), slants[lane]);
                Ray { origin, direction, t_min: z_near * slant, t_max: z_far * slant }
            };
            rays.extend((0..columns.len()).map(ray));
        }
    }

    /// Distances along the axis between which surfaces are seen.
    fn depth_range(&self) -> (f32, f32) {
        match self.camera.projection {
            Projection::Perspective { z_near, z_far, .. } => (z_near, z_far.unwrap_or(f32::INFINITY)),
            Projection::Orthographic { z_near, z_far, .. } => (z_near, z_far),
        }
    }

    fn image_plane(&self) -> ImagePlane {
        ImagePlane { resolution: self.resolution, half_size: self.half_size }
    }

    /// The differential of a camera ray: the steps to the neighbouring samples.
    pub fn differential(&self, ray: &Ray) -> RayDifferential {
        self.differential_along(ray.direction)
    }

    /// [`CameraRays::differential`] of several rays.
    #[inline(always)]
    pub(super) fn differentials(&self, directions: &Vec3Lanes, out: &mut DifferentialLanes) {
        for lane in 0..LANES {
            let RayDifferential { origin, direction } = self.differential_along(directions.get(lane));
            for axis in 0..2 {
                out.origin[axis].set(lane, origin[axis]);
                out.direction[axis].set(lane, direction[axis]);
            }
        }
    }

    #[inline(always)]
    fn differential_along(&self, direction: Vec3) -> RayDifferential {
        match self.camera.projection {
            Projection::Orthographic { .. } => {
                RayDifferential { origin: self.sample_steps, direction: [Vec3::ZERO; 2] }
            }
            Projection::Perspective { .. } => {
                RayDifferential { origin: [Vec3::ZERO; 2], direction: self.turned(direction) }
            }
        }
    }

    /// Changes of the direction of a perspective ray to the neighbouring samples.
    #[inline(always)]
    fn turned(&self, direction: Vec3) -> [Vec3; 2] {
        // D = d / |d| for the d that reaches distance one along the axis: D' = (d' − D (D·d')) / |d|.
        let per_length = -direction.dot(self.camera.world_from_camera.z_axis.truncate());
        let turned = |step: Vec3| (step - direction * direction.dot(step)) * per_length;
        let [row, column] = self.sample_steps;
        [turned(row), turned(column)]
    }

    /// The seed of sample `index` of a pixel.
    pub fn seed(&self, pixel: (u32, u32), index: u32) -> Seed {
        Seed::of_hashed_time(self.hashed_time, pixel, index)
    }
}

/// The image at distance one (perspective) or in metres (orthographic).
#[derive(Clone, Copy)]
struct ImagePlane {
    resolution: Vec2,
    half_size: Vec2,
}

impl ImagePlane {
    /// The point at `position`, in pixels from the top left corner; x to the right, y upwards.
    #[inline(always)]
    fn point(self, position: Vec2) -> Vec2 {
        let ndc = (position / self.resolution) * 2.0 - Vec2::ONE;
        Vec2::new(ndc.x, -ndc.y) * self.half_size
    }
}

/// The unit vector in world space along a direction in camera space. Distances along the slanted ray exceed those along the axis
/// by the returned factor.
#[inline(always)]
fn world_direction(world_from_camera: &Mat4, direction: Vec3) -> (Vec3, f32) {
    let slant = direction.dot(direction).sqrt();
    (world_from_camera.transform_vector3(direction / slant), slant)
}

impl ThinLens {
    /// Moves the origin of a ray from the lens centre to another point of the lens, and turns it to the same point in focus. The
    /// direction is (…, …, −1) before and after.
    fn refocus(self, origin: Vec3, direction: Vec3, seed: Seed) -> (Vec3, Vec3) {
        let offset = (concentric_disk_point(seed.point(Purpose::Lens)) * self.radius).extend(0.0);
        (origin + offset, direction - offset / self.focus_distance)
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
        let rays = CameraRays::new(&camera, (4, 2), 0.0, None);
        let corner = rays.ray(Vec2::ZERO, Seed::default());
        assert!(corner.direction.abs_diff_eq(Vec3::new(-2.0, 1.0, -1.0).normalize(), 1e-6));
        // The near plane at 0.1 is 0.1 · |(−2, 1, −1)| along this ray.
        assert!((corner.t_min - 0.1 * libm::sqrtf(6.0)).abs() < 1e-6);
        let center = rays.ray(Vec2::new(2.0, 1.0), Seed::default());
        assert_eq!(center.direction, Vec3::NEG_Z);
    }

    #[test]
    fn differentials_are_the_differences_of_neighbouring_rays() {
        let rotation = glam::Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let world_from_camera = glam::Mat4::from_rotation_translation(rotation, Vec3::new(1.0, 2.0, 3.0));
        let orthographic = Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.1, z_far: 9.0 };
        for projection in [perspective(None), orthographic] {
            let camera = PosedCamera { world_from_camera, projection };
            // Four samples a pixel lie half a pixel apart.
            let rays = CameraRays::new(&camera, (400, 200), 0.0, None).sharing_pixels(4);
            let at = |position| rays.ray(position, Seed::default());
            for position in [Vec2::new(200.0, 100.0), Vec2::new(3.0, 190.0)] {
                let ray = at(position);
                let differential = rays.differential(&ray);
                for (axis, step) in [Vec2::X, Vec2::Y].into_iter().enumerate() {
                    let (before, after) = (at(position - step * 0.25), at(position + step * 0.25));
                    let (moved, turned) = (after.origin - before.origin, after.direction - before.direction);
                    assert!((differential.origin[axis] - moved).length() < 1e-5);
                    assert!((differential.direction[axis] - turned).length() < 1e-5, "{turned}");
                    assert!(moved.length() + turned.length() > 1e-4);
                }
            }
        }
    }

    #[test]
    fn rays_from_all_over_the_lens_cross_in_focus_and_start_at_the_near_plane() {
        let orthographic = Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.1, z_far: 50.0 };
        for projection in [perspective(None), orthographic] {
            let camera = PosedCamera { projection, ..PosedCamera::default() };
            let lens = ThinLens { radius: 0.25, focus_distance: 3.0 };
            let rays = CameraRays::new(&camera, (4, 2), 0.0, Some(lens));
            let pinhole = CameraRays::new(&camera, (4, 2), 0.0, None);
            let at_focus = |ray: &Ray| ray.at((-3.0 - ray.origin.z) / ray.direction.z);
            for index in 0..50 {
                let seed = rays.seed((1, 1), index);
                let position = Vec2::new(1.25, 0.5);
                let ray = rays.ray(position, seed);
                assert!(at_focus(&ray).abs_diff_eq(at_focus(&pinhole.ray(position, seed)), 1e-5));
                assert!((ray.at(ray.t_min).z + 0.1).abs() < 1e-6);
                assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_lens_focused_at_infinity_sees_parallel_rays() {
        let camera = PosedCamera { projection: perspective(None), ..PosedCamera::default() };
        let lens = ThinLens { radius: 0.5, focus_distance: f32::INFINITY };
        let rays = CameraRays::new(&camera, (4, 2), 0.0, Some(lens));
        let ray = |index| rays.ray(Vec2::new(1.0, 1.5), rays.seed((1, 1), index));
        assert_eq!(ray(0).direction, ray(1).direction);
        assert_ne!(ray(0).origin, ray(1).origin);
    }
}
