//! The light of the environment in the closed space around a camera: what comes in through its openings, and what its walls reflect.

mod enclosed_light;

use glam::Vec3;
use rayon::prelude::*;

pub use enclosed_light::EnclosedLight;

use super::radiosity::{ExchangeRays, LitWall, Wall, is_open, lit_walls};
use crate::geometry::{Ray, smoothstep, spiral_direction};
use crate::scene::KeyLight;
use crate::scene_view::SceneView;

/// Directions in which a camera looks for openings.
const DIRECTIONS: u32 = 2048;
/// Directions in which it looks for walls, each of which looks for another one.
const WALL_DIRECTIONS: u32 = 300;
/// The light of walls is exchanged by so many rays.
const EXCHANGE_RAYS: ExchangeRays = ExchangeRays { of_walls: 32, of_ends: 0 };
/// The environment arrives as if nothing were in between where neither a camera nor the walls see any of it, and only through openings from the second of
/// these shares of their directions on.
const OPENINGS: [f32; 2] = [0.0, 0.01];

/// The share of all directions in which a point sees the environment, past glass and surfaces that are more than half transparent.
pub(super) fn open_share(view: SceneView<'_>, position: Vec3) -> f32 {
    let directions = (0..DIRECTIONS).into_par_iter().map(|index| spiral_direction(index, DIRECTIONS));
    let open = directions.filter(|direction| is_open(view, &Ray::new(position, *direction)));
    open.count() as f32 / DIRECTIONS as f32
}

/// Walls around a point and the light that they receive.
#[derive(Clone, Debug)]
pub(super) struct ClosedSpace {
    walls: Vec<LitWall>,
    /// Whether any light comes in; else it is that of the environment as if nothing were in between.
    is_lit: bool,
}

impl ClosedSpace {
    /// The space around a point. Its light is without that of the environment's peaks and key light, but for what walls reflect of them.
    pub(super) fn around(view: SceneView<'_>, position: Vec3) -> Self {
        let lights: Vec<KeyLight> =
            view.environment.key_light().into_iter().chain(view.environment.peaks()).collect();
        let directions = (0..WALL_DIRECTIONS).into_par_iter();
        let walls = directions.filter_map(|index| {
            let ray = Ray::new(position, spiral_direction(index, WALL_DIRECTIONS));
            Wall::along(view, &lights, (index, &ray))
        });
        let mut walls: Vec<Wall> = walls.collect();
        // Near a wall, most of these are beside it.
        let others = walls.par_iter().filter_map(|wall| {
            let ray = wall.cosine_rays(!wall.number, 1).next()?;
            Wall::along(view, &lights, (WALL_DIRECTIONS + wall.number, &ray))
        });
        let others: Vec<Wall> = others.collect();
        walls.extend(others);
        Self { walls: lit_walls(view, &lights, &walls, EXCHANGE_RAYS), is_lit: true }
    }

    /// The share of the directions in which its walls see the environment, by the cosine.
    pub(super) fn open_share(&self) -> f32 {
        self.walls.iter().map(|wall| wall.open_share).sum::<f32>() / self.walls.len().max(1) as f32
    }

    /// The space with the unoccluded environment as far as it has no openings: `open_share` is the share of directions in which light comes in.
    pub(super) fn with_openings(mut self, view: SceneView<'_>, open_share: f32) -> Self {
        let share = smoothstep(OPENINGS, open_share);
        for wall in &mut self.walls {
            let unoccluded = view.environment.irradiance(wall.normal);
            wall.irradiance = unoccluded + (wall.irradiance - unoccluded) * share;
        }
        self.is_lit = share > 0.0 && !self.walls.is_empty();
        self
    }

    /// One whose walls all receive `irradiance`, for tests.
    #[cfg(test)]
    pub(super) fn uniform(irradiance: f32, is_lit: bool) -> Self {
        let (position, irradiance) = (Vec3::ZERO, Vec3::splat(irradiance));
        let by_environment = irradiance;
        let wall = LitWall { position, normal: Vec3::Y, irradiance, by_environment, open_share: 0.1 };
        Self { walls: vec![wall], is_lit }
    }
}
