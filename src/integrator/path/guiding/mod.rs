//! Guiding of paths: diffuse surfaces send rays to where photons came from.
//!
//! Light that smooth surfaces focus is found by sampled rays alone, since no shadow ray passes a mirror or bent glass. Rays of
//! diffuse surfaces find it by chance, and its noise outlasts all other. So a frame whose emissive triangles shine on mirrors or glass first
//! follows photons to the diffuse surfaces where they land (Jensen, "Importance Driven Path Tracing Using the Photon Map", Rendering
//! Techniques 1995). Cells with equal numbers of photons each hold a density of the directions from which these came, as a
//! quadtree (Müller, Gross and Novák, "Practical Path Guiding for Efficient Light-Transport Simulation", EGSR 2017), and part of the rays
//! follow it. What is found decides the noise, but not the mean.
//!
//! Photons of the environment are not followed.

mod direction_tree;
mod photon_sources;
mod photons;
mod point_tree;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use self::direction_tree::{Arrival, DirectionTree};
use self::photons::indirect_photons;
pub(in crate::integrator) use self::photons::{LandedPhoton, PhotonPath};
use self::point_tree::PointTree;
use crate::geometry::Aabb;
use crate::integrator::IntegratorContext;

/// Share of the samples of a diffuse lobe that follow photons.
const GUIDED_SHARE: f32 = 0.8;

/// Photons of a cell. Few miss light that comes from small parts of a cell's surroundings.
const CELL_PHOTONS: usize = 2048;

/// Where the indirect light of a frame's diffuse surfaces comes from.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct PathGuide {
    cells: PointTree,
    /// By cell.
    directions: Vec<DirectionTree>,
}

/// How a surface guides its rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guidance<'g> {
    directions: &'g DirectionTree,
    /// Share of the rays that follow photons.
    pub(super) share: f32,
}

impl PathGuide {
    /// The guide of a frame; `None` where smooth surfaces focus little of the light of its emissive triangles.
    pub(in crate::integrator) fn new(context: &IntegratorContext<'_>) -> Option<Self> {
        Self::from_photons(&indirect_photons(context)?)
    }

    fn from_photons(photons: &[LandedPhoton]) -> Option<Self> {
        let points: Vec<(Vec3, Vec3)> =
            photons.iter().map(|photon| (photon.position, photon.normal)).collect();
        let (cells, indices) = PointTree::new(&points, CELL_PHOTONS);
        let directions: Vec<DirectionTree> = indices
            .par_iter()
            .map(|indices| {
                let area = area(indices.iter().map(|&index| points[index as usize].0));
                let arrivals = indices.iter().map(|&index| Arrival::new(&photons[index as usize], area));
                DirectionTree::new(&arrivals.collect::<Vec<_>>())
            })
            .collect();
        (!directions.is_empty()).then_some(Self { cells, directions })
    }

    /// How a surface guides its rays that scatters light of its own side, `diffuse_share` of it diffusely.
    pub(super) fn guidance(
        &self,
        (position, normal): (Vec3, Vec3),
        diffuse_share: f32,
    ) -> Option<Guidance<'_>> {
        if diffuse_share <= 0.0 {
            return None;
        }
        let cell = self.cells.cell(position, normal)?;
        Some(Guidance { directions: &self.directions[cell as usize], share: GUIDED_SHARE * diffuse_share })
    }
}

impl Guidance<'_> {
    /// A unit direction that photons came from, and its density by solid angle.
    pub(super) fn sample(&self, u: Vec2) -> (Vec3, f32) {
        self.directions.sample(u)
    }

    /// The density of a unit direction by solid angle, where the lobes of the surface have `lobe_pdf`.
    pub(super) fn mixed_pdf(&self, direction: Vec3, lobe_pdf: f32) -> f32 {
        self.share * self.directions.pdf(direction) + (1.0 - self.share) * lobe_pdf
    }
}

/// The largest area that the box around points shows along an axis.
fn area(points: impl Iterator<Item = Vec3>) -> f32 {
    let bounds = points.fold(Aabb::EMPTY, Aabb::union_point);
    let Vec3 { x, y, z } = bounds.max - bounds.min;
    (x * y).max(y * z).max(z * x)
}

#[cfg(test)]
mod tests;
