//! Guiding of paths: diffuse surfaces send rays to where photons came from.
//!
//! Light that smooth surfaces focus is found by sampled rays alone, since no shadow ray passes a mirror or bent glass. Rays of
//! diffuse surfaces find it by chance, and its noise outlasts all other. So a frame whose emissive triangles shine on mirrors or glass first
//! follows photons to the diffuse surfaces where they land (Jensen, "Importance Driven Path Tracing Using the Photon Map", Rendering
//! Techniques 1995). Cells with equal numbers of photons each hold a density of the directions from which these came, as a
//! quadtree (Müller, Gross and Novák, "Practical Path Guiding for Efficient Light-Transport Simulation", EGSR 2017), and part of the rays
//! follow it. What is found decides the noise, but not the mean.
//!
//! Photons of the environment are not followed: where it lights a scene, rays by the lobes alone find most of the light.

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
use crate::color::luminance;
use crate::geometry::Aabb;
use crate::integrator::IntegratorContext;
use crate::scene::Environment;

/// Most of the samples of a diffuse lobe that follow photons, where nothing else shines.
const LARGEST_SHARE: f32 = 0.8;
/// Surfaces that would send fewer samples after photons send none: what they cost would be in vain.
const LEAST_SHARE: f32 = 0.1;

/// Photons of a cell. Few miss light that comes from small parts of a cell's surroundings.
const CELL_PHOTONS: usize = 2048;

/// Where the indirect light of a frame's diffuse surfaces comes from.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct PathGuide {
    cells: PointTree,
    guided: Vec<GuidedCell>,
}

/// How the surfaces of a cell guide their rays.
#[derive(Clone, Debug)]
struct GuidedCell {
    directions: DirectionTree,
    /// Share of the samples of a diffuse lobe.
    share: f32,
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
        let photons = indirect_photons(context)?;
        let points: Vec<(Vec3, Vec3)> =
            photons.iter().map(|photon| (photon.position, photon.normal)).collect();
        let (cells, indices) = PointTree::new(&points, CELL_PHOTONS);
        let unguided = mean_irradiance(context.view.environment);
        let guided_cell = |indices: &Vec<u32>| {
            let photons = || indices.iter().map(|&index| &photons[index as usize]);
            let area = area(photons().map(|photon| photon.position));
            let arrivals: Vec<Arrival> = photons().map(|photon| Arrival::new(photon, area)).collect();
            let power: f32 = photons().map(|photon| photon.power).sum();
            let share = LARGEST_SHARE * power / (power + unguided * area);
            GuidedCell { directions: DirectionTree::new(&arrivals), share }
        };
        let guided: Vec<GuidedCell> = indices.par_iter().map(guided_cell).collect();
        guided.iter().any(|cell| cell.share >= LEAST_SHARE).then_some(Self { cells, guided })
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
        let GuidedCell { directions, share } = &self.guided[self.cells.cell(position, normal)? as usize];
        (*share >= LEAST_SHARE).then_some(Guidance { directions, share: share * diffuse_share })
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

/// Luminance of the irradiance of an environment, averaged over all normals: what rays find that no photons guide.
fn mean_irradiance(environment: &Environment) -> f32 {
    let normals = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    normals.map(|normal| luminance(environment.irradiance(normal))).sum::<f32>() / 6.0
}

/// The largest area that the box around points shows along an axis.
fn area(points: impl Iterator<Item = Vec3>) -> f32 {
    let bounds = points.fold(Aabb::EMPTY, Aabb::union_point);
    let Vec3 { x, y, z } = bounds.max - bounds.min;
    (x * y).max(y * z).max(z * x)
}

#[cfg(test)]
mod tests;
