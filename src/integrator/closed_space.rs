//! The light of the environment in the closed space around a camera: what comes in through its openings, and what its walls reflect.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::enclosed_light::EnclosedLight;
use super::local_frame::local_frame;
use super::random::{hash, r2_moved};
use super::unit_interval;
use super::walls::is_wall;
use crate::bsdf::cosine_direction;
use crate::bvh::{Hit, TraversalCounters};
use crate::color::luminance;
use crate::geometry::{Ray, smoothstep, spiral_direction};
use crate::interaction::{BlurredMaterial, SurfacePoint};
use crate::scene::{Environment, KeyLight};
use crate::scene_view::SceneView;

/// Directions in which a camera looks for openings and walls.
const DIRECTIONS: u32 = 2048;
/// Of this many walls that it sees, rays from one find what light arrives there.
const SEEN_WALLS_A_SAMPLE: usize = 8;
/// Rays from each of these. Openings are small: with few rays most walls would see none, and one all of its light.
const SEEN_WALL_RAYS: u32 = 64;
/// The same for walls that those walls see: many with few rays, since only the mean counts.
const OTHER_WALLS_A_SAMPLE: usize = 2;
const OTHER_WALL_RAYS: u32 = 8;
/// Roughness of the lobes in which those rays see the environment: about as wide as the cells between them.
const LOBE_ROUGHNESS: f32 = 0.25;
/// The environment arrives as if nothing were in between where neither a camera nor the walls see any of it, and only through openings from the second of
/// these shares of their directions on.
const OPENINGS: [f32; 2] = [0.0, 0.01];
/// Share of the light that walls exchange which they lose at least: white ones without openings would be infinitely bright.
const MIN_LOSS: f32 = 1e-4;

/// Unit vectors of equal solid angles.
fn directions() -> impl IndexedParallelIterator<Item = Vec3> {
    (0..DIRECTIONS).into_par_iter().map(|index| spiral_direction(index, DIRECTIONS))
}

/// The share of all directions in which a point sees the environment, past glass and surfaces that are more than half transparent.
pub(super) fn open_share(view: SceneView<'_>, position: Vec3) -> f32 {
    let open = directions().filter(|direction| is_open(view, &Ray::new(position, *direction)));
    open.count() as f32 / DIRECTIONS as f32
}

/// The light of the environment around a point that sees it in `open_share` of all directions, without the lights of its peaks; `None` where no light comes in.
///
/// Walls are flat and diffuse, or unlit and of their colour, as domes with a sky are. Each receives the environment that it sees, and its peaks and key light, and from elsewhere the light that walls send on average:
/// X = mean(ρ E) / (1 − mean(ρ c)), where ρ is the albedo of a wall, E the irradiance that it receives from the environment, and c the share of other
/// walls around it. It is the light in an integrating sphere. The means are those of the walls that the seen ones see: such rays reach all walls by their area,
/// also what is far or at a grazing angle. All of the light is then scaled so that the walls are as bright as this says, in the mean of
/// square roots, as displays show them: the point may be farther from the openings than they are.
pub(super) fn enclosed_light(view: SceneView<'_>, position: Vec3, open_share: f32) -> Option<EnclosedLight> {
    let lights: Vec<KeyLight> =
        view.environment.key_light().into_iter().chain(view.environment.peaks()).collect();
    let seen: Vec<(Vec3, Option<Wall>)> = directions()
        .map(|direction| (direction, Wall::along(view, &lights, &Ray::new(position, direction))))
        .collect();
    let walls: Vec<(Vec3, &Wall)> =
        seen.iter().filter_map(|(direction, wall)| Some((*direction, wall.as_ref()?))).collect();
    let sampled: Vec<(Vec3, SampledWall<'_>)> = walls
        .par_iter()
        .step_by(SEEN_WALLS_A_SAMPLE)
        .enumerate()
        .map(|(index, (direction, wall))| {
            (*direction, SampledWall::new(view, wall, index as u32, SEEN_WALL_RAYS))
        })
        .collect();
    let share = smoothstep(OPENINGS, largest_opening(open_share, &sampled));
    if share == 0.0 {
        return None;
    }
    let exchanged = exchanged_irradiance(view, &lights, &walls);

    // Openings, the light of lights on all walls, and the rest of that of the walls which stand for all
    let weight = 1.0 / DIRECTIONS as f32;
    let sampled_weight = walls.len() as f32 * weight / sampled.len().max(1) as f32;
    let unoccluded = |direction: Vec3| view.environment.prefiltered(direction, LOBE_ROUGHNESS);
    let open = seen.iter().filter(|(_, wall)| wall.is_none());
    let open = open.map(|(direction, _)| (*direction, unoccluded(*direction), weight));
    let by_lights = walls.iter().map(|(direction, wall)| {
        (*direction, (wall.albedo * wall.irradiance_by_lights * FRAC_1_PI + wall.emitted) * share, weight)
    });
    let reflected = sampled.iter().map(|(direction, wall)| {
        let without = unoccluded(*direction);
        let sent = wall.wall.albedo * wall.received(exchanged) * FRAC_1_PI;
        (*direction, without + (sent - without) * share, sampled_weight)
    });
    let light = EnclosedLight::new(open.chain(by_lights).chain(reflected));
    Some(light.scaled(1.0 + (looked_up_factor(&sampled, &light, exchanged) - 1.0) * share))
}

/// The share of all directions in which a point or the walls that it sees see the environment, whichever is larger: a point may be where it sees no opening.
fn largest_opening(open_share: f32, walls: &[(Vec3, SampledWall<'_>)]) -> f32 {
    let of_walls: f32 = walls.iter().map(|(_, wall)| 1.0 - wall.closed_share).sum();
    let of_walls = of_walls / walls.len().max(1) as f32;
    if of_walls > open_share { of_walls } else { open_share }
}

/// The factor by which walls that look up `light` are as bright as in the light that they receive.
fn looked_up_factor(walls: &[(Vec3, SampledWall<'_>)], light: &EnclosedLight, exchanged: Vec3) -> f32 {
    let (mut received, mut looked_up) = (0.0_f32, 0.0_f32);
    for (_, sampled) in walls {
        let shown = |irradiance: Vec3| luminance(sampled.wall.albedo * irradiance).sqrt();
        received += shown(sampled.received(exchanged));
        looked_up += shown(light.irradiance(sampled.wall.normal));
    }
    if looked_up > 0.0 { (received / looked_up).powi(2) } else { 1.0 }
}

/// The light of the environment if nothing were in between.
pub(super) fn unenclosed_light(environment: &Environment) -> EnclosedLight {
    let radiance = |direction| (direction, environment.prefiltered(direction, LOBE_ROUGHNESS));
    let radiances: Vec<(Vec3, Vec3)> = directions().map(radiance).collect();
    let weight = 1.0 / DIRECTIONS as f32;
    EnclosedLight::new(radiances.into_iter().map(|(direction, radiance)| (direction, radiance, weight)))
}

/// Irradiance that walls receive on average from those around them.
fn exchanged_irradiance(view: SceneView<'_>, lights: &[KeyLight], walls: &[(Vec3, &Wall)]) -> Vec3 {
    let others = walls.par_iter().enumerate().filter_map(|(index, (_, wall))| {
        let direction = local_frame(wall.normal) * cosine_direction(random_point(index as u32));
        Wall::along(view, lights, &Ray::new(wall.origin, direction))
    });
    let others: Vec<Wall> = others.collect();
    let sampled = others.par_iter().step_by(OTHER_WALLS_A_SAMPLE).enumerate();
    let sampled: Vec<SampledWall<'_>> =
        sampled.map(|(index, wall)| SampledWall::new(view, wall, index as u32, OTHER_WALL_RAYS)).collect();
    let by_lights = others.iter().map(|wall| wall.albedo * wall.irradiance_by_lights + wall.emitted * PI);
    let by_lights: Vec3 = by_lights.sum();
    let (mut reflected, mut kept) = (Vec3::ZERO, Vec3::ZERO);
    for SampledWall { wall, irradiance, closed_share } in &sampled {
        reflected += wall.albedo * irradiance;
        kept += wall.albedo * closed_share;
    }
    let [all, sampled] = [others.len(), sampled.len()].map(|count| count.max(1) as f32);
    let loss = Vec3::ONE - kept / sampled;
    (reflected / sampled + by_lights / all) / loss.max(Vec3::splat(MIN_LOSS))
}

/// A random point of the unit square.
fn random_point(index: u32) -> Vec2 {
    let bits = hash(index);
    Vec2::new(unit_interval(bits), unit_interval(hash(bits)))
}

/// A surface that hides the environment.
struct Wall {
    origin: Vec3,
    normal: Vec3,
    albedo: Vec3,
    /// Radiance without any light: that of unlit materials.
    emitted: Vec3,
    /// Irradiance by the peaks and the key light of the environment.
    irradiance_by_lights: Vec3,
}

impl Wall {
    /// The wall that a ray hits, if any.
    fn along(view: SceneView<'_>, lights: &[KeyLight], ray: &Ray) -> Option<Self> {
        let hides = |hit: &Hit| is_wall(view, hit, |_| true);
        let hit = view.bvh.closest_hit_of_any_side(ray, None, hides, &mut TraversalCounters::default())?;
        let point = SurfacePoint::flat(view, ray, &hit);
        let (origin, normal) = (point.origin_outside(), point.geometric_normal);
        let mut irradiance_by_lights = Vec3::ZERO;
        for light in lights {
            let cosine = light.direction_to_light.dot(normal);
            if cosine > 0.0 && is_open(view, &Ray::new(origin, light.direction_to_light)) {
                irradiance_by_lights += light.irradiance * cosine;
            }
        }
        let color = BlurredMaterial::at(view, &hit).color.max(Vec3::ZERO);
        let material = &view.frame.materials[point.instance.material.index()];
        let (albedo, emitted) =
            if material.unlit { (Vec3::ZERO, color) } else { (color.min(Vec3::ONE), Vec3::ZERO) };
        Some(Self { origin, normal, albedo, emitted, irradiance_by_lights })
    }
}

/// A wall with the light that it receives from around it.
struct SampledWall<'w> {
    wall: &'w Wall,
    /// Irradiance by the environment without its peaks.
    irradiance: Vec3,
    /// Share of the cosine lobe in which other walls are.
    closed_share: f32,
}

impl<'w> SampledWall<'w> {
    fn new(view: SceneView<'_>, wall: &'w Wall, index: u32, rays: u32) -> Self {
        let first = random_point(index);
        let world_from_local = local_frame(wall.normal);
        let (mut irradiance, mut open) = (Vec3::ZERO, 0.0);
        for number in 0..rays {
            let wi = world_from_local * cosine_direction(r2_moved(first, number));
            if is_open(view, &Ray::new(wall.origin, wi)) {
                irradiance += view.environment.prefiltered(wi, LOBE_ROUGHNESS) * (PI / rays as f32);
                open += 1.0 / rays as f32;
            }
        }
        Self { wall, irradiance, closed_share: 1.0 - open }
    }

    /// Irradiance by the environment and by other walls, which send `exchanged` on average.
    fn received(&self, exchanged: Vec3) -> Vec3 {
        self.irradiance + exchanged * self.closed_share
    }
}

/// Whether a ray reaches the environment, past glass and surfaces that are more than half transparent.
fn is_open(view: SceneView<'_>, ray: &Ray) -> bool {
    let hides = |hit: &Hit| is_wall(view, hit, |_| true);
    !view.bvh.occluded(ray, hides, &mut TraversalCounters::default())
}
