//! The light that walls receive from the environment and from each other.
//!
//! Each wall is sampled by rays, whose ends have the light of the sampled wall beside them (Goral et al. 1984, with rays for form factors).

mod wall;

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

pub(super) use wall::{Wall, is_open};

use crate::geometry::Ray;
use crate::scene::KeyLight;
use crate::scene_view::SceneView;

/// Roughness of the lobes in which rays see the environment: about as wide as the cells between them.
const LOBE_ROUGHNESS: f32 = 0.25;
/// Rays from walls that no sampled one is beside: only their mean counts.
const OTHER_RAYS: u32 = 4;
/// Ends of rays are beside a sampled wall up to this many times its distance to the fourth next one.
const BESIDE_DISTANCES: f32 = 2.0;
/// Cosine between the normals of walls that are beside each other, at least.
const BESIDE_COSINE: f32 = 0.7;
/// Share of the light that walls exchange which they lose at least: white ones without openings would be infinitely bright.
const MIN_LOSS: f32 = 1e-4;
/// Times that light is exchanged. It starts as that of an integrating sphere, so that this many reach what differs from it.
const EXCHANGES: u32 = 32;

/// A sampled wall and the light that it receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LitWall {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    /// Irradiance by the environment without its peaks and by other walls.
    pub(super) irradiance: Vec3,
    /// The part of it by the environment.
    pub(super) by_environment: Vec3,
    /// Share of the cosine lobe in which the environment is.
    pub(super) open_share: f32,
}

/// What a wall receives from outside, and what others send to it of their light.
#[derive(Clone)]
struct Received {
    albedo: Vec3,
    /// Irradiance by the environment.
    by_environment: Vec3,
    /// Irradiance by walls that are lit by the environment's lights, that are unlit, or that no sampled wall is beside.
    by_walls: Vec3,
    open_share: f32,
    /// Light of sampled walls, and the shares of it that arrive.
    links: Vec<(Sender, Vec3)>,
}

/// Whose light a ray finds.
#[derive(Clone, Copy)]
enum Sender {
    /// A sampled one.
    Wall(usize),
    /// What a sampled one receives of other walls.
    WallByWalls(usize),
    /// The mean of what all reflect.
    Mean,
}

/// Rays by which walls find light.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExchangeRays {
    /// Rays from each wall.
    pub(super) of_walls: u32,
    /// Rays to the environment from the ends of these; 0 where ends receive the same of it as the sampled wall beside them.
    pub(super) of_ends: u32,
}

/// The light of `walls`.
pub(super) fn lit_walls(
    view: SceneView<'_>,
    lights: &[KeyLight],
    walls: &[Wall],
    rays: ExchangeRays,
) -> Vec<LitWall> {
    let neighbours = Neighbours::new(walls);
    let received = |wall: &Wall| Received::new(view, lights, &neighbours, (wall, rays));
    let received: Vec<Received> = walls.par_iter().map(received).collect();
    let irradiances = exchanged(&received);
    let lit = walls.iter().zip(&received).zip(irradiances);
    lit.map(|((wall, received), irradiance)| LitWall {
        position: wall.origin,
        normal: wall.normal,
        irradiance,
        by_environment: received.by_environment,
        open_share: received.open_share,
    })
    .collect()
}

/// Sampled walls by the axes that they face.
struct Neighbours([Vec<Neighbour>; 6]);

#[derive(Clone, Copy)]
struct Neighbour {
    position: Vec3,
    /// The squared distance up to which others are beside it.
    squared_reach: f32,
    normal: Vec3,
    /// Among all walls.
    number: usize,
}

impl Neighbours {
    fn new(walls: &[Wall]) -> Self {
        let mut facing: [Vec<Neighbour>; 6] = Default::default();
        for (number, wall) in walls.iter().enumerate() {
            let Wall { origin: position, normal, .. } = *wall;
            facing[faced_axis(normal)].push(Neighbour { position, squared_reach: 0.0, normal, number });
        }
        for walls in &mut facing {
            let reaches: Vec<f32> = walls.par_iter().map(|wall| squared_reach(wall, walls)).collect();
            for (wall, reach) in walls.iter_mut().zip(reaches) {
                wall.squared_reach = reach;
            }
        }
        Self(facing)
    }

    /// The sampled wall beside another one.
    fn beside(&self, wall: &Wall) -> Option<usize> {
        let mut nearest = (None, f32::INFINITY);
        for other in &self.0[faced_axis(wall.normal)] {
            let distance = other.position.distance_squared(wall.origin);
            if distance < nearest.1
                && distance <= other.squared_reach
                && other.normal.dot(wall.normal) > BESIDE_COSINE
            {
                nearest = (Some(other.number), distance);
            }
        }
        nearest.0
    }
}

/// The longest axis of a normal, and its sign: 0 to 5.
fn faced_axis(normal: Vec3) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] > 0.0)
}

fn squared_reach(wall: &Neighbour, walls: &[Neighbour]) -> f32 {
    let mut nearest = [f32::INFINITY; 5];
    for other in walls.iter().filter(|other| other.normal.dot(wall.normal) > BESIDE_COSINE) {
        let distance = other.position.distance_squared(wall.position);
        let at = nearest.partition_point(|near| *near <= distance);
        if at < nearest.len() {
            nearest[at..].rotate_right(1);
            nearest[at] = distance;
        }
    }
    // The first is the wall itself.
    let finite = nearest.iter().rev().find(|distance| distance.is_finite());
    finite.copied().unwrap_or(0.0) * (BESIDE_DISTANCES * BESIDE_DISTANCES)
}

impl Received {
    fn new(
        view: SceneView<'_>,
        lights: &[KeyLight],
        neighbours: &Neighbours,
        (wall, ExchangeRays { of_walls: rays, of_ends }): (&Wall, ExchangeRays),
    ) -> Self {
        let share = 1.0 / rays as f32;
        let mut received = Self {
            albedo: wall.albedo,
            by_environment: Vec3::ZERO,
            by_walls: Vec3::ZERO,
            open_share: 0.0,
            links: Vec::new(),
        };
        for (ray_number, ray) in wall.cosine_rays(wall.number, rays).enumerate() {
            let first = wall.number * rays + ray_number as u32;
            let Some(other) = Wall::along(view, lights, (first, &ray)) else {
                received.by_environment += environment_along(view, &ray) * (PI * share);
                received.open_share += share;
                continue;
            };
            let sent = other.albedo * share;
            received.by_walls += sent * other.irradiance_by_lights + other.emitted * (PI * share);
            match neighbours.beside(&other) {
                Some(beside) if of_ends == 0 => received.links.push((Sender::Wall(beside), sent)),
                Some(beside) => {
                    received.by_walls += sent * by_environment(view, &other, of_ends).0;
                    received.links.push((Sender::WallByWalls(beside), sent));
                }
                None => {
                    let (irradiance, open_share) = by_environment(view, &other, OTHER_RAYS);
                    received.by_walls += sent * irradiance;
                    received.links.push((Sender::Mean, sent * (1.0 - open_share)));
                }
            }
        }
        received
    }
}

/// Irradiance of a wall by the environment, and the share of directions that are open, by so many rays.
fn by_environment(view: SceneView<'_>, wall: &Wall, rays: u32) -> (Vec3, f32) {
    let (mut irradiance, mut open) = (Vec3::ZERO, 0.0);
    for ray in wall.cosine_rays(wall.number, rays).filter(|ray| is_open(view, ray)) {
        irradiance += environment_along(view, &ray) * (PI / rays as f32);
        open += 1.0 / rays as f32;
    }
    (irradiance, open)
}

fn environment_along(view: SceneView<'_>, ray: &Ray) -> Vec3 {
    view.environment.prefiltered(ray.direction, LOBE_ROUGHNESS)
}

/// Irradiance of walls after all exchanges.
fn exchanged(walls: &[Received]) -> Vec<Vec3> {
    let count = walls.len().max(1) as f32;
    let source: Vec<Vec3> = walls.iter().map(|wall| wall.by_environment + wall.by_walls).collect();
    // An integrating sphere: the mean source is what walls lose.
    let mean_albedo = walls.iter().map(|wall| wall.albedo).sum::<Vec3>() / count;
    let kept = walls.iter().flat_map(|wall| &wall.links).map(|(sender, share)| match sender {
        Sender::Mean => *share * mean_albedo,
        Sender::Wall(_) | Sender::WallByWalls(_) => *share,
    });
    let kept: Vec3 = kept.sum();
    let by_walls_alone = walls.iter().flat_map(|wall| &wall.links).map(|(sender, share)| match sender {
        Sender::WallByWalls(index) => walls[*index].by_environment * share,
        Sender::Wall(_) | Sender::Mean => Vec3::ZERO,
    });
    let mean_source = source.iter().sum::<Vec3>() - by_walls_alone.sum::<Vec3>();
    let loss = (Vec3::ONE - kept / count).max(Vec3::splat(MIN_LOSS));
    let mut irradiances = vec![mean_source / count / loss; walls.len()];
    for _ in 0..EXCHANGES {
        let reflected = walls.iter().zip(&irradiances).map(|(wall, irradiance)| wall.albedo * *irradiance);
        let mean = reflected.sum::<Vec3>() / count;
        let received = |(wall, source): (&Received, &Vec3)| {
            let sent = wall.links.iter().map(|(sender, share)| match sender {
                Sender::Wall(index) => irradiances[*index] * share,
                Sender::WallByWalls(index) => (irradiances[*index] - walls[*index].by_environment) * share,
                Sender::Mean => mean * share,
            });
            *source + sent.sum::<Vec3>()
        };
        irradiances = walls.iter().zip(&source).map(received).collect();
    }
    irradiances
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(x: f32, normal: Vec3) -> Wall {
        let origin = Vec3::X * x;
        let (albedo, emitted, irradiance_by_lights) = (Vec3::ONE, Vec3::ZERO, Vec3::ZERO);
        Wall { number: 0, origin, normal, albedo, emitted, irradiance_by_lights }
    }

    fn received(source: f32, links: &[(Sender, f32)]) -> Received {
        Received {
            albedo: Vec3::ONE,
            by_environment: Vec3::splat(source),
            by_walls: Vec3::ZERO,
            open_share: 0.0,
            links: links.iter().map(|(sender, share)| (*sender, Vec3::splat(*share))).collect(),
        }
    }

    #[test]
    fn two_walls_light_each_other() {
        // a = 1 + b / 2 and b = a / 2
        let walls = [received(1.0, &[(Sender::Wall(1), 0.5)]), received(0.0, &[(Sender::Wall(0), 0.5)])];
        let found = exchanged(&walls);
        assert!((found[0].x - 4.0 / 3.0).abs() < 1e-5 && (found[1].y - 2.0 / 3.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn light_of_walls_may_leave_out_that_of_the_environment() {
        // a = 1 + b / 2 and b = 2 + (a - 1) / 2
        let walls =
            [received(1.0, &[(Sender::Wall(1), 0.5)]), received(2.0, &[(Sender::WallByWalls(0), 0.5)])];
        let found = exchanged(&walls);
        assert!((found[0].x - 7.0 / 3.0).abs() < 1e-5 && (found[1].y - 8.0 / 3.0).abs() < 1e-5, "{found:?}");
        // x = 0.1 + 0.99 (x - 0.1), exact at once
        let sphere = vec![received(0.1, &[(Sender::WallByWalls(1), 0.99)]); 3];
        assert!(exchanged(&sphere).iter().all(|found| (found - 0.1).length() < 1e-4));
    }

    #[test]
    fn an_integrating_sphere_is_exact_at_once() {
        // x = 0.1 + 0.96 x: after 32 exchanges from 0.1 it would be 0.74 of that.
        let sphere = vec![received(0.1, &[(Sender::Mean, 0.48), (Sender::Wall(2), 0.48)]); 5];
        for found in exchanged(&sphere) {
            assert!((found - 2.5).length() < 1e-4, "{found}");
        }
        // What is reflected counts, not what is received: x = 0.1 + 0.5 x.
        let grey = vec![Received { albedo: Vec3::splat(0.5), ..received(0.1, &[(Sender::Mean, 1.0)]) }; 5];
        assert!(exchanged(&grey).iter().all(|found| (found - 0.2).length() < 1e-4));
        // Without loss the light stays finite.
        let white = vec![received(0.1, &[(Sender::Mean, 1.0)]); 5];
        assert!(exchanged(&white).iter().all(|light| light.is_finite()));
        assert!(exchanged(&[]).is_empty());
    }

    #[test]
    fn the_nearest_wall_on_the_same_side_is_beside() {
        let mut walls: Vec<Wall> = (0..6).map(|x| wall(x as f32, Vec3::Y)).collect();
        walls.push(wall(2.1, Vec3::NEG_Y));
        let neighbours = Neighbours::new(&walls);
        // The fourth next one of the first is 4 m away, that of the third 2 m; the one that faces down has none.
        let reaches = [0, 2].map(|number| neighbours.0[3][number].squared_reach);
        assert_eq!((reaches, neighbours.0[2][0].squared_reach), ([64.0, 16.0], 0.0));
        let beside = |x, normal| neighbours.beside(&wall(x, normal));
        assert_eq!(beside(2.2, Vec3::Y), Some(2));
        assert_eq!((beside(14.0, Vec3::Y), beside(12.9, Vec3::Y)), (None, Some(5)));
        assert_eq!((beside(2.0, Vec3::X), beside(2.1, Vec3::NEG_Y)), (None, Some(6)));
        let tilted = Vec3::new(0.6, 0.8, 0.0);
        assert_eq!((beside(3.9, tilted), beside(3.9, Vec3::new(0.8, 0.6, 0.0))), (Some(4), None));
    }
}
