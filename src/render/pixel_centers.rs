//! What the middle of each pixel shows, for layers that must not be blended: one ray a pixel, at one time and without a lens.
//!
//! Motion is that of the point that is seen: the same place on the same triangle, posed in the frames before and after and seen
//! by the cameras there. It is worked out in f64, since it is a small difference of large numbers.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::projector::Projector;
use super::tile::pixels_in_z_order;
use super::tiles;
use crate::bvh::{Hit, TraversalCounters};
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{Film, FilmAovs, PixelCenterSample, PixelWindow};
use crate::frame::{Frame, PosedCamera};
use crate::geometry::Ray;
use crate::integrator::{CameraRays, Seed};
use crate::interaction::{SurfacePoint, alpha_at, catches_shadows, surface_at};
use crate::scene_view::SceneView;

/// Surfaces that cover less are looked through.
const LEAST_ALPHA: f32 = 0.5;

/// The same scene posed one frame earlier and one later.
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
    neighbours: AdjacentFrames<'_>,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    if film.aovs.centers.is_none() {
        return Ok(());
    }
    let centres = Centres::new(*view, neighbours, film.resolution);
    let tiles = tiles(film.window);
    let rendered: Vec<FilmAovs> = tiles
        .par_iter()
        .map(|tile| {
            cancel.check()?;
            Ok(FilmAovs { centers: Some(centres.of_tile(*tile)), ..FilmAovs::default() })
        })
        .collect::<Result<_, Cancelled>>()?;
    for (tile, layers) in tiles.iter().zip(&rendered) {
        film.write_aov_tile(*tile, layers);
    }
    Ok(())
}

/// What all tiles share.
struct Centres<'a> {
    view: SceneView<'a>,
    rays: CameraRays,
    now: Moment<'a>,
    before: Moment<'a>,
    after: Moment<'a>,
}

/// A frame with its picture.
struct Moment<'a> {
    frame: &'a Frame,
    projector: Projector,
}

impl<'a> Centres<'a> {
    fn new(view: SceneView<'a>, neighbours: AdjacentFrames<'a>, resolution: (u32, u32)) -> Self {
        let frame = view.frame;
        let moment =
            |frame: &'a Frame| Moment { frame, projector: Projector::new(&frame.camera, resolution) };
        Self {
            view,
            rays: CameraRays::new(&frame.camera, resolution, frame.time_seconds as f32, None),
            now: moment(frame),
            before: moment(neighbours.before),
            after: moment(neighbours.after),
        }
    }

    /// The samples of a tile, row by row.
    fn of_tile(&self, tile: PixelWindow) -> Vec<PixelCenterSample> {
        let pixels = pixels_in_z_order(tile);
        let middle = |&(x, y): &(u32, u32)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let rays: Vec<Ray> =
            pixels.iter().map(|pixel| self.rays.ray(middle(pixel), Seed::default())).collect();
        let mut hits = vec![None; rays.len()];
        let view = self.view;
        let is_met = |_, hit: &Hit| alpha_at(view, hit) >= LEAST_ALPHA && !catches_shadows(view, hit);
        view.bvh.closest_hits(&rays, is_met, &mut hits, &mut TraversalCounters::default());

        let mut samples = vec![PixelCenterSample::default(); rays.len()];
        for ((&(x, y), ray), hit) in pixels.iter().zip(&rays).zip(&hits) {
            samples[((y - tile.y0) * tile.width() + x - tile.x0) as usize] = match hit {
                Some(hit) => self.of_surface(ray, hit),
                None => self.of_background(ray),
            };
        }
        samples
    }

    fn of_surface(&self, ray: &Ray, hit: &Hit) -> PixelCenterSample {
        let frame = self.view.frame;
        let (point, material) = surface_at(self.view, ray, hit, &self.rays.differential(ray));
        let to = |moment| self.surface_motion(&point, moment);
        PixelCenterSample {
            instance: Some(frame.instance_of_triangle[hit.triangle as usize]),
            depth: depth(&frame.camera, &point),
            position: point.position,
            geometric_normal: point.geometric_normal,
            shading_normal: point.shading_normal,
            albedo: material.base_color,
            uv: point.texture_coordinates(self.view.scene, 0),
            motion_forward: to(&self.after),
            motion_back: to(&self.before),
        }
    }

    fn of_background(&self, ray: &Ray) -> PixelCenterSample {
        let direction = ray.direction.as_dvec3();
        let pixel_at = |moment: &Moment<'_>| moment.projector.pixel_of_direction(direction);
        let to = |moment| difference(pixel_at(&self.now), pixel_at(moment));
        PixelCenterSample {
            motion_forward: to(&self.after),
            motion_back: to(&self.before),
            ..PixelCenterSample::default()
        }
    }

    fn surface_motion(&self, point: &SurfacePoint<'_>, to: &Moment<'_>) -> Vec2 {
        let pixel_at = |moment: &Moment<'_>| {
            point.position_in(moment.frame).and_then(|point| moment.projector.pixel_of_point(point))
        };
        difference(pixel_at(&self.now), pixel_at(to))
    }
}

/// Along the camera's axis, metres.
fn depth(camera: &PosedCamera, point: &SurfacePoint<'_>) -> f32 {
    let (backward, eye) = (camera.world_from_camera.z_axis, camera.world_from_camera.w_axis);
    (eye.truncate() - point.position).dot(backward.truncate())
}

/// From here to there; zero where one of them is nowhere.
fn difference(here: Option<DVec2>, there: Option<DVec2>) -> Vec2 {
    let moved = here.zip(there).map(|(here, there)| (there - here).as_vec2());
    moved.filter(|moved| moved.is_finite()).unwrap_or(Vec2::ZERO)
}
