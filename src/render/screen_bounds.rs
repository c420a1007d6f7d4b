//! The part of the image in which camera rays may hit surfaces.
//!
//! The boxes of the hierarchy's root are projected into the image. Samples outside all of their rectangles see the background, and
//! their rays are not traced. Boxes and rectangles are widened by more than the roundings of rays and of their traversal.

use glam::{DVec2, DVec3, Vec2};

use super::projector::Projector;
use crate::geometry::{Aabb, BOX_PADDING};
use crate::scene_view::SceneView;

/// Pixels by which rectangles are grown.
const MARGIN: f64 = 0.25;
/// Bound of the error of a ray's direction.
const DIRECTION_ERROR: f64 = 1.0 / (1 << 20) as f64;

/// Rectangles of the image outside which no surface is seen.
#[derive(Clone, Debug)]
pub(super) struct ScreenBounds {
    /// `None` where surfaces may be anywhere.
    rectangles: Option<Vec<Rectangle>>,
}

/// Lowest and highest columns and rows, pixels.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl ScreenBounds {
    /// Bounds for any camera.
    pub(super) const EVERYWHERE: Self = Self { rectangles: None };

    /// The bounds of what a camera without a lens sees.
    pub(super) fn new(view: &SceneView<'_>, resolution: (u32, u32)) -> Self {
        let camera = &view.frame.camera;
        let projector = Projector::new(camera, resolution);
        // Traversal moves the start of a ray by less than this.
        let start = camera.world_from_camera.w_axis.truncate().abs().max_element();
        let half_size = camera.projection.half_size(resolution.0 as f32 / resolution.1 as f32).as_dvec2();
        let pixels = DVec2::new(f64::from(resolution.0), f64::from(resolution.1));
        let direction_error = pixels / half_size * (DIRECTION_ERROR * (1.0 + half_size.length_squared()));
        let margin = direction_error + DVec2::splat(MARGIN);
        let rectangle = |bounds: Aabb| {
            // Parallel rays start beside the camera.
            let reach = start + bounds.extent().max_element();
            projected(&projector, &bounds.grown(reach * (4.0 * BOX_PADDING)), margin)
        };
        let boxes = view.bvh.outer_boxes();
        Self { rectangles: boxes.and_then(|boxes| boxes.into_iter().map(rectangle).collect()) }
    }

    /// Whether samples at these `offsets` in some pixels may see surfaces.
    pub(super) fn may_cover(&self, pixels: &[(u32, u32)], offsets: &[Vec2]) -> bool {
        let Some(rectangles) = &self.rectangles else { return true };
        let corners = pixels.iter().map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y)));
        let pixels = Rectangle::around(corners);
        let offsets = Rectangle::around(offsets.iter().map(|offset| offset.as_dvec2()));
        let (low, high) = (pixels.low + offsets.low, pixels.high + offsets.high);
        rectangles.iter().any(|rectangle| rectangle.low.cmple(high).all() && rectangle.high.cmpge(low).all())
    }
}

impl Rectangle {
    /// No part of the image.
    const NOWHERE: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn around(points: impl Iterator<Item = DVec2>) -> Self {
        points.fold(Self::NOWHERE, |all, point| Self { low: all.low.min(point), high: all.high.max(point) })
    }
}

/// The rectangle around a box; `None` where only a part of it is in front of the camera.
fn projected(projector: &Projector, bounds: &Aabb, margin: DVec2) -> Option<Rectangle> {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let corners: [Option<DVec2>; 8] = std::array::from_fn(|index| {
        let side = |axis: usize| if index >> axis & 1 == 0 { min[axis] } else { max[axis] };
        projector.pixel_of_point(DVec3::new(side(0), side(1), side(2)))
    });
    if corners.iter().all(Option::is_none) {
        return Some(Rectangle::NOWHERE);
    }
    let corners: Vec<DVec2> = corners.into_iter().collect::<Option<_>>()?;
    let rectangle = Rectangle::around(corners.into_iter());
    let is_finite = rectangle.low.is_finite() && rectangle.high.is_finite();
    is_finite.then(|| Rectangle { low: rectangle.low - margin, high: rectangle.high + margin })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::bvh::{BuildSettings, Builder, TraversalCounters};
    use crate::cancel::CancelFlag;
    use crate::frame::{Frame, PosedCamera};
    use crate::gltf::{ImportOptions, import};
    use crate::integrator::{CameraRays, Seed};
    use crate::scene::{Environment, Projection, Selection, SelectionRequest};

    #[test]
    fn rays_outside_the_bounds_hit_nothing() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf");
        let scene = import(&path, &ImportOptions::default()).unwrap();
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let mut frame = Frame::at(&scene, &selection, 0.0);
        let (build, cancel) = (BuildSettings::default(), CancelFlag::new());
        let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, &cancel, None).unwrap();
        let boxes = bvh.outer_boxes().unwrap();
        let bounds = boxes.into_iter().reduce(Aabb::union).unwrap();

        // From afar, so that the scene fills a part of the image
        let distance = bounds.extent().length() * 3.0;
        let perspective =
            Projection::Perspective { fov_y_radians: 0.9, aspect_ratio: None, z_near: 0.0, z_far: None };
        let (x_mag, y_mag) = (distance, distance);
        let orthographic = Projection::Orthographic { x_mag, y_mag, z_near: 0.0, z_far: 2.0 * distance };
        for projection in [perspective, orthographic] {
            let eye = bounds.center() + glam::Vec3::new(0.3, 0.2, 1.0) * distance;
            let world_from_camera = glam::Mat4::from_translation(eye);
            frame.camera = PosedCamera { world_from_camera, projection };
            let view = SceneView { scene: &scene, frame: &frame, bvh: &bvh, environment: &Environment::None };
            let resolution = (96, 64);
            let screen = ScreenBounds::new(&view, resolution);
            let rays = CameraRays::new(&frame.camera, resolution, 0.0, None);
            let (mut outside, mut hits) = (0, 0);
            for index in 0..96 * 64 {
                let pixel = (index % 96, index / 96);
                let center = Vec2::splat(0.5);
                let ray = rays.ray(Vec2::new(pixel.0 as f32, pixel.1 as f32) + center, Seed::default());
                let hit =
                    bvh.closest_hit_of_any_side(&ray, None, |_| true, &mut TraversalCounters::default());
                let may_cover = screen.may_cover(&[pixel], &[center]);
                assert!(may_cover || hit.is_none(), "{pixel:?}");
                outside += u32::from(!may_cover);
                hits += u32::from(hit.is_some());
            }
            assert!(outside > 2000 && hits > 20, "{outside} {hits}");
        }
    }

    #[test]
    fn boxes_around_the_camera_may_be_anywhere_and_those_behind_it_nowhere() {
        let projection =
            Projection::Perspective { fov_y_radians: 0.9, aspect_ratio: None, z_near: 0.0, z_far: None };
        let camera = PosedCamera { projection, ..PosedCamera::default() };
        let projector = Projector::new(&camera, (16, 16));
        let around = |z: f32| Aabb::from_points(&[glam::Vec3::Z * z]).grown(1.0);
        assert!(projected(&projector, &around(0.0), DVec2::ZERO).is_none());
        let behind = projected(&projector, &around(3.0), DVec2::ZERO).unwrap();
        assert_eq!((behind.low, behind.high), (DVec2::INFINITY, DVec2::NEG_INFINITY));
        // tan(0.45) = 0.483: at distance 2, a half width of 1 takes 8 / 0.483 / 2 = 8.28 pixels.
        let ahead = projected(&projector, &around(-3.0), DVec2::ZERO).unwrap();
        assert!((ahead.high - DVec2::splat(16.28)).length() < 0.01, "{ahead:?}");
    }
}
