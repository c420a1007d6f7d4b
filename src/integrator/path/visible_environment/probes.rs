//! Rays that find what is seen of the environment.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::entry::Entry;
use super::reached_points::{ReachedPoint, random_point};
use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::walls::is_wall;
use crate::scene::{EnvironmentSectors, SECTOR_COLUMNS, SECTOR_ROWS, SECTORS, interval, prefix_sums};
use crate::scene_view::SceneView;

/// Share of the samples that follow the radiance alone.
const DEFENSIVE_SHARE: f32 = 0.1;

/// A round sends a sector one ray for each such share of the power, 1 to [`DIRECTIONS`].
const SHARE_OF_RAY: f32 = 1.0 / 256.0;
/// Directions to a sector, which the rays of all points share.
const DIRECTIONS: usize = 8;

/// Rounds of rays. All but the first are for sectors around those that are seen.
const ROUNDS: usize = 3;

/// Weight of the neighbours' mean for a sector of one ray a round: a few rays can miss a window that the sector only partly contains.
const NEIGHBORHOOD_SHARE: f32 = 0.7;

/// Shadow rays to the environment from points of surfaces.
pub(super) struct Probes<'p, 'v> {
    view: SceneView<'v>,
    powers: &'v [f32],
    points: &'p [ReachedPoint],
    /// Directions by the radiance of each sector; none where that is dark.
    directions: Vec<Vec<Vec3>>,
}

/// Rays that are traced together.
#[derive(Default)]
struct Batch {
    rays: Vec<Ray>,
    /// For each ray, its sector and its cosine.
    targets: Vec<(usize, f32)>,
    is_occluded: Vec<bool>,
}

impl<'p, 'v> Probes<'p, 'v> {
    pub(super) fn new(
        view: SceneView<'v>,
        sectors: EnvironmentSectors<'v>,
        points: &'p [ReachedPoint],
    ) -> Self {
        let powers = sectors.powers();
        let of_sector = |sector: usize| {
            let count = if powers[sector] > 0.0 { DIRECTIONS } else { 0 };
            (0..count)
                .map(|number| sectors.sample(sector, random_point(number as u32, sector as u32)).direction)
                .collect()
        };
        Self { view, powers, points, directions: (0..SECTORS).map(of_sector).collect() }
    }

    /// Share of the environment's light that arrives at the points, by one ray from each.
    pub(super) fn arriving_share(&self) -> f32 {
        let mut sums = [0.0; SECTORS + 1];
        prefix_sums(self.powers.iter().map(|&power| f64::from(power)), &mut sums);
        let cosines: Vec<[f32; 2]> = (0..self.points.len() as u32)
            .into_par_iter()
            .map(|index| {
                let point = &self.points[index as usize];
                let Vec2 { x: u_sector, y: u_direction } = random_point(index, SECTORS as u32);
                let directions = &self.directions[interval(&sums, u_sector).0];
                let direction = directions[(u_direction * DIRECTIONS as f32) as usize];
                let cosine = direction.dot(point.normal).max(0.0);
                [cosine, if cosine > 0.0 && self.sees(point, direction) { cosine } else { 0.0 }]
            })
            .collect();
        let total: f32 = cosines.iter().map(|[all, _]| all).sum();
        let arriving: f32 = cosines.iter().map(|[_, arriving]| arriving).sum();
        if total > 0.0 { arriving / total } else { 0.0 }
    }

    fn sees(&self, point: &ReachedPoint, direction: Vec3) -> bool {
        let ray = Ray::new(point.position, direction);
        !self.view.bvh.occluded(&ray, |hit| self.hides(hit), &mut TraversalCounters::default())
    }

    /// As for the shadow rays of paths to the environment, which pass thin walls of glass.
    fn hides(&self, hit: &Hit) -> bool {
        is_wall(self.view, hit, |material| !material.is_volume())
    }

    /// The probabilities of the sectors from the points of a group; `None` if no light is found to arrive there.
    pub(super) fn entry(&self, group: &[u32]) -> Option<Entry> {
        let arriving = self.arriving(group);
        let mut weights: [f32; SECTORS] = std::array::from_fn(|sector| {
            let (mut sum, mut count) = (0.0, 0);
            for neighbor in around(sector) {
                sum += arriving[neighbor];
                count += 1;
            }
            let mean = sum / count as f32;
            let share = NEIGHBORHOOD_SHARE / self.rays_of_round(sector) as f32;
            self.powers[sector] * ((1.0 - share) * arriving[sector] + share * mean)
        });
        let total: f32 = weights.iter().sum();
        if total <= 0.0 {
            return None;
        }
        for (weight, power) in weights.iter_mut().zip(self.powers) {
            *weight = (1.0 - DEFENSIVE_SHARE) * *weight / total + DEFENSIVE_SHARE * power;
        }
        Entry::new(&weights)
    }

    /// For each sector, the mean over rays from the points of a group: the cosine of those that arrive, 0 of others.
    fn arriving(&self, group: &[u32]) -> [f32; SECTORS] {
        let (mut sums, mut counts) = ([0.0; SECTORS], [0_usize; SECTORS]);
        let mut batch = Batch::default();
        for round in 0..ROUNDS {
            for (sector, count) in counts.iter_mut().enumerate() {
                if round == 0 || around(sector).any(|neighbor| sums[neighbor] > 0.0) {
                    let rays = self.rays_of_round(sector);
                    for number in round * rays..(round + 1) * rays {
                        self.add(&mut batch, group, (sector, number));
                    }
                    *count += rays;
                }
            }
            batch.trace(self, &mut sums);
        }
        std::array::from_fn(|sector| sums[sector] / counts[sector] as f32)
    }

    fn rays_of_round(&self, sector: usize) -> usize {
        ((self.powers[sector] / SHARE_OF_RAY) as usize).clamp(1, DIRECTIONS)
    }

    /// Adds ray `number` to a sector from one of the points, if it leaves the surface. The rays of a round have different directions.
    fn add(&self, batch: &mut Batch, group: &[u32], (sector, number): (usize, usize)) {
        let directions = &self.directions[sector];
        if directions.is_empty() {
            return;
        }
        let first = random_point(sector as u32, group[0]).x * DIRECTIONS as f32;
        let direction = directions[(first as usize + number) % DIRECTIONS];
        let ray = SECTORS + sector * ROUNDS * DIRECTIONS + number;
        let chosen = random_point(ray as u32, group[0]).x * group.len() as f32;
        let point = &self.points[group[chosen as usize] as usize];
        let cosine = direction.dot(point.normal);
        if cosine > 0.0 {
            batch.rays.push(Ray::new(point.position, direction));
            batch.targets.push((sector, cosine));
        }
    }
}

impl Batch {
    /// Traces and removes all rays, and adds the cosines of those that arrive.
    fn trace(&mut self, probes: &Probes<'_, '_>, sums: &mut [f32; SECTORS]) {
        self.is_occluded.resize(self.rays.len(), false);
        probes.view.bvh.occluded_rays(
            &self.rays,
            |_, hit| probes.hides(hit),
            &mut self.is_occluded,
            &mut TraversalCounters::default(),
        );
        for (&(sector, cosine), is_occluded) in self.targets.iter().zip(&self.is_occluded) {
            if !is_occluded {
                sums[sector] += cosine;
            }
        }
        self.rays.clear();
        self.targets.clear();
    }
}

/// For each row of sectors, the columns to each side that are as near as the next row: the reciprocal sine of the polar angle, rounded.
const REACH: [usize; SECTOR_ROWS] = [10, 3, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 3, 10];

/// A sector and its neighbours.
fn around(sector: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (sector / SECTOR_COLUMNS, sector % SECTOR_COLUMNS);
    (row.saturating_sub(1)..=(row + 1).min(SECTOR_ROWS - 1)).flat_map(move |row| {
        let columns = SECTOR_COLUMNS - REACH[row]..=SECTOR_COLUMNS + REACH[row];
        columns.map(move |step| row * SECTOR_COLUMNS + (column + step) % SECTOR_COLUMNS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighborhoods_are_round() {
        for (row, reach) in REACH.into_iter().enumerate() {
            let sine = libm::sinf((row as f32 + 0.5) * std::f32::consts::PI / SECTOR_ROWS as f32);
            assert_eq!(reach, (1.0 / sine).round() as usize);
        }
        let of = |sector| around(sector).collect::<Vec<_>>();
        let middle = 7 * SECTOR_COLUMNS;
        assert_eq!(of(middle)[..3], [middle - 1, middle - SECTOR_COLUMNS, middle - SECTOR_COLUMNS + 1]);
        assert_eq!(of(middle).len(), 9);
        assert_eq!(of(0).len(), 21 + 7);
        assert_eq!(of(SECTORS - 1).len(), 21 + 7);
    }
}
