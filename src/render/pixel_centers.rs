//! Pixel-centre samples, for AOVs that must not be blended: one ray per pixel, at the frame's time and without a lens.
//!
//! The motion of a pixel is that of the surface point that it shows: the same point of the same triangle, posed in the adjacent
//! frames and seen by their cameras. It is computed in f64, since it is a small difference of large numbers.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::projector::Projector;
use super::tile_grid::{pixels_in_morton_order, tiles};
use crate::bvh::{Hit, TraversalCounters};
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{Film, FilmAovs, PixelCenterSample, PixelWindow};
use crate::frame::{Frame, PosedCamera};
use crate::geometry::Ray;
use crate::integrator::{CameraRays, Seed};
use crate::interaction::{SurfacePoint, alpha_at, catches_shadows, surface_at};
use crate::scene_view::SceneView;

/// Surfaces of a lower alpha are ignored.
const MIN_ALPHA: f32 = 0.5;

/// The same scene posed one frame earlier and one frame later.
#[derive(Clone, Copy, Debug)]
pub struct AdjacentFrames<'a> {
    /// The frame before.
    pub before: &'a Frame,
    /// The frame after.
    pub after: &'a Frame,
}

/// Fills [`FilmAovs::centers`] of `film`, if it has them, in parallel on the current rayon pool.
pub fn render_pixel_centers(
    film: &mut Film,
    view: &SceneView<'_>,
    adjacent: AdjacentFrames<'_>,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    if film.aovs.centers.is_none() {
        return Ok(());
    }
    let renderer = CenterRenderer::new(*view, adjacent, film.resolution);
    let tiles = tiles(film.window);
    let rendered: Vec<FilmAovs> = tiles
        .par_iter()
        .map(|tile| {
            cancel.check()?;
            Ok(FilmAovs { centers: Some(renderer.render(*tile)), ..FilmAovs::default() })
        })
        .collect::<Result<_, Cancelled>>()?;
    for (tile, aovs) in tiles.iter().zip(&rendered) {
        film.write_aov_tile(*tile, aovs);
    }
    Ok(())
}

/// Renders the pixel-centre samples of tiles.
struct CenterRenderer<'a> {
    view: SceneView<'a>,
    rays: CameraRays,
    current: ProjectedFrame<'a>,
    before: ProjectedFrame<'a>,
    after: ProjectedFrame<'a>,
}

/// A frame with the projection of its camera.
struct ProjectedFrame<'a> {
    frame: &'a Frame,
    projector: Projector,
}

impl<'a> CenterRenderer<'a> {
    fn new(view: SceneView<'a>, adjacent: AdjacentFrames<'a>, resolution: (u32, u32)) -> Self {
        let frame = view.frame;
        let projected = |frame: &'a Frame| {
            let projector = Projector::new(&frame.camera, resolution);
            ProjectedFrame { frame, projector }
        };
        Self {
            view,
            rays: CameraRays::new(&frame.camera, resolution, frame.time_seconds as f32, None),
            current: projected(frame),
            before: projected(adjacent.before),
            after: projected(adjacent.after),
        }
    }

    /// The samples of a tile, row by row.
    fn render(&self, tile: PixelWindow) -> Vec<PixelCenterSample> {
        let pixels: Vec<(u32, u32)> = pixels_in_morton_order(tile).collect();
        let center = |&(x, y): &(u32, u32)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let rays: Vec<Ray> =
            pixels.iter().map(|pixel| self.rays.ray(center(pixel), Seed::default())).collect();
        let mut hits = vec![None; rays.len()];
        let view = self.view;
        let is_visible = |_, hit: &Hit| alpha_at(view, hit) >= MIN_ALPHA && !catches_shadows(view, hit);
        view.bvh.closest_hits(&rays, is_visible, &mut hits, &mut TraversalCounters::default());

        let mut samples = vec![PixelCenterSample::default(); rays.len()];
        for ((&(x, y), ray), hit) in pixels.iter().zip(&rays).zip(&hits) {
            samples[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = match hit {
                Some(hit) => self.surface_sample(ray, hit),
                None => self.background_sample(ray),
            };
        }
        samples
    }

    fn surface_sample(&self, ray: &Ray, hit: &Hit) -> PixelCenterSample {
        let frame = self.view.frame;
        let (point, material) = surface_at(self.view, ray, hit, &self.rays.differential(ray));
        let motion_to = |other| self.surface_motion(&point, other);
        PixelCenterSample {
            instance: Some(frame.instance_of_triangle[hit.triangle as usize]),
            depth: depth(&frame.camera, &point),
            position: point.position,
            geometric_normal: point.geometric_normal,
            shading_normal: point.shading_normal,
            albedo: material.base_color,
            uv: point.texture_coordinates(self.view.scene, 0),
            motion_forward: motion_to(&self.after),
            motion_back: motion_to(&self.before),
        }
    }

    fn background_sample(&self, ray: &Ray) -> PixelCenterSample {
        let direction = ray.direction.as_dvec3();
        let pixel_in = |frame: &ProjectedFrame<'_>| frame.projector.pixel_of_direction(direction);
        let motion_to = |other| difference(pixel_in(&self.current), pixel_in(other));
        PixelCenterSample {
            motion_forward: motion_to(&self.after),
            motion_back: motion_to(&self.before),
            ..PixelCenterSample::default()
        }
    }

    fn surface_motion(&self, point: &SurfacePoint<'_>, to: &ProjectedFrame<'_>) -> Vec2 {
        let pixel_in = |other: &ProjectedFrame<'_>| {
            point.position_in(other.frame).and_then(|point| other.projector.pixel_of_point(point))
        };
        difference(pixel_in(&self.current), pixel_in(to))
    }
}

/// Distance of a point along the camera's axis, metres.
fn depth(camera: &PosedCamera, point: &SurfacePoint<'_>) -> f32 {
    let (backward, eye) = (camera.world_from_camera.z_axis, camera.world_from_camera.w_axis);
    (eye.truncate() - point.position).dot(backward.truncate())
}

/// The step between two positions; zero where one of them is unknown.
fn difference(from: Option<DVec2>, to: Option<DVec2>) -> Vec2 {
    let motion = from.zip(to).map(|(from, to)| (to - from).as_vec2());
    motion.filter(|motion| motion.is_finite()).unwrap_or(Vec2::ZERO)
}
