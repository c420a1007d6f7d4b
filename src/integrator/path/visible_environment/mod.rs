//! Which part of the environment is seen from where: in closed spaces, shadow rays aim at windows.
//!
//! Paths sample the environment by its radiance. Where walls hide most of it, nearly all of these samples are in vain. So a frame
//! first asks, with few rays, how much of each sector of the environment arrives at points that paths reach, by cubes of a grid and by the axis
//! that is nearest to the normal. Samples then follow the light that arrives, and some of them the radiance alone, so that none is missed (Georgiev,
//! Křivánek, Popov and Slusallek, "Importance Caching for Complex Illumination", Eurographics 2012, for the environment and by place). What is found
//! decides the density of samples, and so the noise, but not the mean.

mod entry;
mod point_grid;
mod probes;
mod reached_points;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use self::entry::Entry;
pub(in crate::integrator) use self::entry::VisibleEntry;
use self::point_grid::PointGrid;
use self::probes::Probes;
pub(super) use self::reached_points::random_point;
use self::reached_points::reached_points;
use crate::geometry::DirectionSample;
use crate::scene::EnvironmentSectors;
use crate::scene_view::SceneView;

/// Where more of the environment's light arrives than this share, samples by radiance alone serve as well.
const OPEN_SHARE: f32 = 0.1;

/// What is seen of the environment of a frame.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct VisibleEnvironment<'a> {
    sectors: EnvironmentSectors<'a>,
    grid: PointGrid,
    entries: Vec<Entry>,
}

impl<'a> VisibleEnvironment<'a> {
    /// What the surfaces of a frame see; `None` where that is much of the environment or nothing, or where it is dark.
    pub(in crate::integrator) fn new(view: SceneView<'a>) -> Option<Self> {
        if !view.environment.is_lit() {
            return None;
        }
        let points = reached_points(view);
        if points.is_empty() {
            return None;
        }
        let sectors = view.environment.sectors()?;
        let probes = Probes::new(view, sectors, &points);
        if probes.arriving_share() > OPEN_SHARE {
            return None;
        }
        let (mut grid, groups) = PointGrid::new(&points);
        let found: Vec<Option<Entry>> = groups.par_iter().map(|group| probes.entry(&group.points)).collect();
        let mut entries = Vec::new();
        for (group, entry) in groups.iter().zip(found) {
            if let Some(entry) = entry {
                grid.set(group.key, entries.len() as VisibleEntry);
                entries.push(entry);
            }
        }
        grid.fill();
        (!entries.is_empty()).then_some(Self { sectors, grid, entries })
    }

    /// The entry of a surface that scatters light of its own side; `None` where nothing is known.
    pub(in crate::integrator) fn entry(&self, position: Vec3, normal: Vec3) -> Option<VisibleEntry> {
        self.grid.get(position, normal)
    }

    /// Samples a direction where an entry sees the environment.
    pub(in crate::integrator) fn sample(&self, entry: VisibleEntry, u: Vec2) -> DirectionSample {
        let (sector, probability, u) = self.entries[usize::from(entry)].sample(u);
        let in_sector = self.sectors.sample(sector, u);
        DirectionSample { pdf: probability * in_sector.pdf, ..in_sector }
    }

    /// The density of a unit direction by solid angle.
    pub(in crate::integrator) fn pdf(&self, entry: VisibleEntry, direction: Vec3) -> f32 {
        let (sector, density) = self.sectors.find(direction);
        self.entries[usize::from(entry)].probability(sector) * density
    }
}

#[cfg(test)]
mod tests;
