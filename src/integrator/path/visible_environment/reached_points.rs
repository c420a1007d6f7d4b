//! Points of surfaces that paths reach.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::bsdf::cosine_direction;
use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::local_frame::local_frame;
use crate::integrator::random::hash;
use crate::integrator::unit_interval;
use crate::integrator::walls::is_wall;
use crate::integrator::{CameraRays, Seed};
use crate::interaction::SurfacePoint;
use crate::scene_view::SceneView;

/// Rays of the camera.
const CAMERA_RAYS: u32 = 2048;
/// Surfaces along the path of each.
const SURFACES: u32 = 3;
/// Surfaces of glass that a ray passes on its way to a wall.
const PANES_PASSED: u32 = 256;
/// The image that they cover, whatever the size of the one that is rendered: crops and tiles share the points. What only a taller image shows may have
/// no entry, and is lit by samples of the radiance alone.
const IMAGE: (u32, u32) = (1600, 900);

/// A point of a surface, on the side from which it was reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReachedPoint {
    pub(super) position: Vec3,
    /// Of the triangle.
    pub(super) normal: Vec3,
}

/// The first surfaces on paths from the camera that all surfaces scatter as a white wall does; glass is passed straight.
pub(super) fn reached_points(view: SceneView<'_>) -> Vec<ReachedPoint> {
    let camera = CameraRays::new(&view.frame.camera, IMAGE, 0.0, None);
    let image = Vec2::new(IMAGE.0 as f32, IMAGE.1 as f32);
    let paths = (0..CAMERA_RAYS).into_par_iter().map(|index| {
        let mut ray = camera.ray(random_point(index, u32::MAX) * image, Seed::default());
        let mut points = Vec::new();
        for surface in 0..SURFACES {
            let Some(point) = first_wall(view, &ray) else { break };
            points.push(point);
            let direction = cosine_direction(random_point(index, u32::MAX - 1 - surface));
            ray = Ray::new(point.position, local_frame(point.normal) * direction);
        }
        points
    });
    paths.collect::<Vec<_>>().concat()
}

/// The first surface that no light passes, behind fewer than [`PANES_PASSED`] of glass.
fn first_wall(view: SceneView<'_>, ray: &Ray) -> Option<ReachedPoint> {
    let hides = |hit: &Hit| is_wall(view, hit, |_| true);
    let mut after = None;
    for _ in 0..PANES_PASSED {
        let hit = view.bvh.closest_hit(ray, after, hides, &mut TraversalCounters::default())?;
        // Glass is found without the filter.
        if hides(&hit) {
            let point = SurfacePoint::flat(view, ray, &hit);
            return Some(ReachedPoint { position: point.origin_outside(), normal: point.geometric_normal });
        }
        after = Some(hit.order());
    }
    None
}

/// A random point of the unit square.
pub(in crate::integrator::path) fn random_point(index: u32, stream: u32) -> Vec2 {
    let bits = hash(index ^ hash(stream));
    Vec2::new(unit_interval(bits), unit_interval(hash(bits)))
}
