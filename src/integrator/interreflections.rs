//! Light that occluders of the environment receive from other surfaces.
//!
//! Whitted's tree lights the occluder of a lookup by the environment, behind a shadow ray. Where that ray is stopped, the light of other surfaces stands for it, by the
//! position and the normal of the occluder. Occluders around surfaces that the camera sees are sampled, by rays of two kinds: by the cosine, as light comes, and as shadow
//! rays. By the former they count with what they receive by radiosity, by the latter with how often their own shadow rays are stopped. The
//! quotient of both sums gives the right light on average.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::ambient_cubes::{AmbientCubes, kernel_weights};
use super::camera::CameraRays;
use super::environment_directions::EnvironmentDirections;
use super::radiosity::{ExchangeRays, Wall, is_open, lit_walls};
use super::random::{Seed, hash, r2_moved};
use super::unit_interval;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::scene::KeyLight;
use crate::scene_view::SceneView;

/// Camera rays along the width and along the height of an image.
const CAMERA_RAYS: [u32; 2] = [36, 24];
/// Rays of each kind from a surface that the camera sees.
const RAYS: u32 = 4;
/// Surfaces find the light of others by so many rays.
const EXCHANGE_RAYS: ExchangeRays = ExchangeRays { of_walls: 4, of_ends: 1 };
/// Shadow rays from an occluder.
const SHADOW_RAYS: u32 = 4;
/// Cells along the longest axis of the grid.
const CELLS: usize = 16;
/// Occluders around a point count up to [`REACH`] times the distance of the one after so many.
const NEAREST: usize = 12;
const REACH: f32 = 2.0;
/// The mean of all occluders counts as so many of them beside those around a point.
const MEAN_WEIGHT: f32 = 0.5;
/// Noise makes light no brighter than so many times the largest irradiance of a surface in the open.
const MOST: f32 = 1.25;
/// Channels of which occluders have less than this share of the brightest one count as if they had it: few rays would decide about much light.
const LEAST_CHANNEL: f32 = 0.1;

/// Irradiance by other surfaces of an occluder whose shadow ray is stopped.
#[derive(Clone, Debug)]
pub(super) struct Interreflections(Arc<AmbientCubes>);

/// An occluder. It counts by the balance heuristic (Veach 1997) of the rays that may find it.
#[derive(Clone, Copy, Debug)]
struct Occluder {
    position: Vec3,
    normal: Vec3,
    sums: Sums,
}

/// Sums over occluders, by channel.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Albedo times irradiance by other surfaces, as rays by the cosine find it.
    light: Vec3,
    /// Albedo times the share of shadow rays that are stopped, as shadow rays find it.
    hidden: Vec3,
}

impl Sums {
    /// With `weight` times others.
    fn plus(self, other: &Self, weight: f32) -> Self {
        Self { light: self.light + other.light * weight, hidden: self.hidden + other.hidden * weight }
    }

    fn quotient(&self) -> Vec3 {
        let Self { light, hidden } = *self;
        let least = (hidden.max_element() * LEAST_CHANNEL).max(f32::MIN_POSITIVE);
        light / hidden.max(Vec3::splat(least))
    }
}

/// What a ray from a seen surface finds.
#[derive(Clone, Copy, Debug)]
struct Found {
    wall: Wall,
    /// The density of its direction among rays by the cosine, and among shadow rays, over that of both together.
    by_cosine: f32,
    by_light: f32,
}

impl Interreflections {
    /// Those around the surfaces that the camera of a frame sees, with shadow rays along `directions`; `None` where no surface hides the environment from
    /// another.
    pub(super) fn new(view: SceneView<'_>, directions: &EnvironmentDirections) -> Option<Self> {
        let lights: Vec<KeyLight> =
            view.environment.key_light().into_iter().chain(view.environment.peaks()).collect();
        let seen = seen_surfaces(view, &lights);
        let found = found_occluders(view, &lights, directions, &seen);
        if found.is_empty() {
            return None;
        }
        let occluders = occluders(view, &lights, directions, &seen, &found);
        let share = 1.0 / occluders.len() as f32;
        let mean = occluders.iter().fold(Sums::default(), |sum, occluder| sum.plus(&occluder.sums, share));
        (mean.hidden != Vec3::ZERO).then(|| {
            let all = AllOccluders { most: most_irradiance(view, &lights), mean };
            let position_and_normal = |occluder: &Occluder| (occluder.position, occluder.normal);
            let irradiance = |point, around: &[Occluder]| all.irradiance_at(point, around);
            Self(Arc::new(AmbientCubes::new(&occluders, CELLS, position_and_normal, irradiance)))
        })
    }

    /// Irradiance of an occluder with this normal where its shadow ray is stopped.
    #[inline]
    pub(super) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        self.0.irradiance(position, normal)
    }
}

/// What is known of all occluders.
struct AllOccluders {
    /// The largest irradiance that the environment and its own lights have along an axis.
    most: Vec3,
    mean: Sums,
}

impl AllOccluders {
    /// Irradiance of those around a point where their shadow rays are stopped.
    fn irradiance_at(&self, point: Vec3, occluders: &[Occluder]) -> Vec3A {
        let distances = occluders.iter().map(|occluder| occluder.position.distance_squared(point)).collect();
        let weighted = occluders.iter().zip(kernel_weights(distances, NEAREST, REACH));
        let first = Sums::default().plus(&self.mean, MEAN_WEIGHT);
        let sums = weighted.fold(first, |sums, (occluder, weight)| sums.plus(&occluder.sums, weight));
        Vec3A::from(sums.quotient().min(self.most * MOST))
    }
}

/// The largest irradiance that the environment and its own lights have along an axis.
fn most_irradiance(view: SceneView<'_>, lights: &[KeyLight]) -> Vec3 {
    let normals = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let by_environment =
        normals.map(|normal| view.environment.irradiance(normal)).fold(Vec3::ZERO, Vec3::max);
    by_environment + lights.iter().map(|light| light.irradiance).sum::<Vec3>()
}

/// Surfaces that the camera sees, evenly spread over the image.
fn seen_surfaces(view: SceneView<'_>, lights: &[KeyLight]) -> Vec<Wall> {
    let [columns, rows] = CAMERA_RAYS;
    let rays = CameraRays::new(&view.frame.camera, (columns, rows), 0.0, None);
    let seen = (0..columns * rows).into_par_iter().filter_map(|index| {
        let position = Vec2::new((index % columns) as f32, (index / columns) as f32) + 0.5;
        Wall::along(view, lights, (index, &rays.ray(position, Seed::new((0, 0), 0.0, 0))))
    });
    seen.collect()
}

/// What rays of both kinds from `seen` surfaces find.
fn found_occluders(
    view: SceneView<'_>,
    lights: &[KeyLight],
    directions: &EnvironmentDirections,
    seen: &[Wall],
) -> Vec<Found> {
    let found = seen.par_iter().flat_map_iter(|surface| {
        let irradiance = luminance(view.environment.irradiance(surface.normal)).max(f32::MIN_POSITIVE);
        let by_cosine = surface.cosine_rays(!surface.number, RAYS);
        let rays = by_cosine.chain(shadow_rays(directions, surface, RAYS));
        rays.zip(CAMERA_RAYS[0] * CAMERA_RAYS[1] + 2 * RAYS * surface.number..).filter_map(
            move |(ray, number)| {
                let wall = Wall::along(view, lights, (number, &ray))?;
                // Of shadow rays over that of rays by the cosine
                let density = directions.luminance(ray.direction) * PI / irradiance;
                let by_cosine = 1.0 / (1.0 + density);
                Some(Found { wall, by_cosine, by_light: 1.0 - by_cosine })
            },
        )
    });
    found.collect()
}

/// The light of occluders, and how often their shadow rays are stopped.
fn occluders(
    view: SceneView<'_>,
    lights: &[KeyLight],
    directions: &EnvironmentDirections,
    seen: &[Wall],
    found: &[Found],
) -> Vec<Occluder> {
    let walls: Vec<Wall> = found.iter().map(|found| found.wall).chain(seen.iter().copied()).collect();
    let lit = lit_walls(view, lights, &walls, EXCHANGE_RAYS);
    let occluders = found.par_iter().zip(&lit).map(|(Found { wall, by_cosine, by_light }, lit)| {
        let rays = shadow_rays(directions, wall, SHADOW_RAYS);
        let stopped = rays.filter(|ray| !is_open(view, ray)).count() as f32 / SHADOW_RAYS as f32;
        let light = wall.albedo * (lit.irradiance - lit.by_environment) * *by_cosine;
        let sums = Sums { light, hidden: wall.albedo * (stopped * by_light) };
        Occluder { position: wall.origin, normal: wall.normal, sums }
    });
    occluders.collect()
}

/// `count` shadow rays of a diffuse lookup.
fn shadow_rays(directions: &EnvironmentDirections, surface: &Wall, count: u32) -> impl Iterator<Item = Ray> {
    let Wall { origin, normal, number, .. } = *surface;
    let bits = hash(number);
    let [x, y, random] = [bits, hash(bits), hash(hash(bits))].map(unit_interval);
    let sampled = (0..count).map(move |ray| {
        let random = (random + ray as f32 / count as f32).fract();
        directions.diffuse(normal, (r2_moved(Vec2::new(x, y), ray), random))
    });
    sampled.filter(move |wi| wi.dot(normal) > 0.0).map(move |wi| Ray::new(origin, wi))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn occluder(x: f32, light: f32, hidden: f32) -> Occluder {
        let color = Vec3::new(1.0, 0.5, 0.0);
        let sums = Sums { light: color * light, hidden: color * hidden };
        Occluder { position: Vec3::X * x, normal: Vec3::Y, sums }
    }

    fn all(mean: Sums) -> AllOccluders {
        AllOccluders { most: Vec3::splat(90.0), mean }
    }

    #[test]
    fn occluders_around_a_point_decide_about_its_light() {
        // Dark ones around 0, and bright ones around 10: half of their shadow rays are stopped.
        let occluders = (0..400).map(|index| match index % 4 {
            0 => occluder(0.0, 2.0, 0.0),
            1 => occluder(0.0, 0.0, 1.0),
            2 => occluder(10.0, 6.0, 0.0),
            _ => occluder(10.0, 0.0, 1.0),
        });
        let occluders: Vec<Occluder> = occluders.collect();
        let irradiance = |x: f32| all(Sums::default()).irradiance_at(Vec3::X * x, &occluders);
        assert!((irradiance(0.1).x - 2.0).abs() < 1e-4, "{}", irradiance(0.1));
        assert!((irradiance(9.9).x - 6.0).abs() < 1e-4, "{}", irradiance(9.9));
        let between = irradiance(4.99).x;
        assert!((between - 4.0).abs() < 0.1, "{between}");
        // The colour of the occluders is not counted twice, and a channel without any light has none.
        assert!((irradiance(0.1).y - 2.0).abs() < 1e-4 && irradiance(0.1).z == 0.0);
    }

    #[test]
    fn the_mean_stands_for_occluders_that_are_not_found() {
        let mean = Sums { light: Vec3::splat(2.0), hidden: Vec3::splat(0.5) };
        assert_eq!(all(mean).irradiance_at(Vec3::ZERO, &[]), Vec3A::splat(4.0));
        let without_light = [occluder(0.0, 0.0, 0.0); 3];
        assert_eq!(all(mean).irradiance_at(Vec3::ZERO, &without_light), Vec3A::splat(4.0));
        assert_eq!(all(Sums::default()).irradiance_at(Vec3::ZERO, &[]), Vec3A::ZERO);
    }

    #[test]
    fn noise_makes_no_light_much_brighter_than_all_that_comes_in() {
        let mean = Sums { light: Vec3::splat(2.0), hidden: Vec3::splat(0.01) };
        assert_eq!(all(mean).irradiance_at(Vec3::ZERO, &[]), Vec3A::splat(90.0 * MOST));
        // Rays in a faint channel decide about no more than ten times its light.
        let faint = Sums { light: Vec3::ONE, hidden: Vec3::new(1.0, 1e-6, 0.0) };
        assert_eq!(faint.quotient(), Vec3::new(1.0, 10.0, 10.0));
    }
}
