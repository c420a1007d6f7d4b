//! Guiding of paths: diffuse surfaces send rays to where photons came from.
//!
//! Light that smooth surfaces focus is found by sampled rays alone, since no shadow ray passes a mirror or bent glass. Rays of
//! diffuse surfaces find it by chance, and its noise outlasts all other. So a frame whose emissive triangles shine on mirrors or glass first
//! follows photons to the diffuse surfaces where they land (Jensen, "Importance Driven Path Tracing Using the Photon Map", Rendering
//! Techniques 1995). Cells with equal numbers of photons each hold a density of the directions from which these came, as a
//! quadtree (Müller, Gross and Novák, "Practical Path Guiding for Efficient Light-Transport Simulation", EGSR 2017), and part of the rays
//! follow it: fewer where lamps that rays cannot hit and environments shine, too, which emit no photons here. What is found decides the noise,
//! but not the mean.

mod direction_tree;
mod photon_sources;
mod photons;
mod point_tree;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use self::direction_tree::{DirectionTree, IncidentPhoton};
use self::photons::PhotonTracing;
pub(crate) use self::photons::most_photon_bytes;
pub(in crate::integrator) use self::photons::{Photon, PhotonPath, PhotonStore};
use self::point_tree::PointTree;
use crate::color::luminance;
use crate::geometry::Aabb;
use crate::integrator::IntegratorContext;

/// Most of the samples of a diffuse lobe that follow photons, where nothing else shines.
const LARGEST_SHARE: f32 = 0.8;
/// Surfaces that would send fewer samples after photons send none: what they cost would be in vain.
const LEAST_SHARE: f32 = 0.1;

/// Points of a cell at which the light of lamps is measured.
const LIT_POINTS: usize = 4;

/// The most photons of a cell. With fewer, cells miss light that comes from few directions.
const CELL_PHOTONS: usize = 2048;

/// Where the indirect light of a frame's diffuse surfaces comes from.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct PathGuide {
    cells: PointTree,
    /// By cell; `None` where the lobes alone do.
    guided: Vec<Option<GuidedCell>>,
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
        let tracing = PhotonTracing::new(context)?;
        let mut photons = tracing.first()?;
        // The first ones tell whether the rest would be in vain.
        Self::from_photons(context, &photons, tracing.first_share())?;
        photons.extend(tracing.rest());
        Self::from_photons(context, &photons, 1.0)
    }

    /// The guide by a share of all photons.
    fn from_photons(context: &IntegratorContext<'_>, photons: &[Photon], traced_share: f32) -> Option<Self> {
        let points: Vec<(Vec3, Vec3)> =
            photons.iter().map(|photon| (photon.position, photon.normal)).collect();
        let (cells, indices) = PointTree::new(&points, CELL_PHOTONS);
        let sky = sky_irradiance(context);
        let guided_cell = |indices: &Vec<u32>| {
            let photons: Vec<&Photon> = indices.iter().map(|&index| &photons[index as usize]).collect();
            // Rays by the lobes alone find what these light.
            let unguided = sky + lamp_irradiance(context, &photons);
            GuidedCell::new(&photons, unguided * traced_share)
        };
        let guided: Vec<Option<GuidedCell>> = indices.par_iter().map(guided_cell).collect();
        guided.iter().any(Option::is_some).then_some(Self { cells, guided })
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
        let GuidedCell { directions, share } = self.guided[cell as usize].as_ref()?;
        Some(Guidance { directions, share: share * diffuse_share })
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

impl GuidedCell {
    /// The cell of some photons; `unguided` is the luminance of the irradiance by lights that emit none. `None` where the lobes alone do.
    fn new(photons: &[&Photon], unguided: f32) -> Option<Self> {
        let area = area(photons.iter().map(|photon| photon.position));
        let power: f32 = photons.iter().map(|photon| photon.power).sum();
        let share = LARGEST_SHARE * power / (power + unguided * area);
        if !(share >= LEAST_SHARE && area > 0.0) {
            return None;
        }
        let incident: Vec<IncidentPhoton> =
            photons.iter().map(|photon| IncidentPhoton::new(photon, area)).collect();
        Some(Self { directions: DirectionTree::new(&incident)?, share })
    }
}

/// Luminance of the irradiance by an environment, averaged over all normals, without occlusion.
fn sky_irradiance(context: &IntegratorContext<'_>) -> f32 {
    let environment = context.view.environment;
    let normals = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let of_sky = normals.map(|normal| luminance(environment.irradiance(normal))).sum::<f32>() / 6.0;
    // A quarter of all normals' cosines to one direction
    let of_peaks: f32 = context.peaks.iter().map(|peak| 0.25 * luminance(peak.irradiance)).sum();
    of_sky + of_peaks
}

/// Luminance of the irradiance in a cell by lamps that rays cannot hit, without occlusion.
fn lamp_irradiance(context: &IntegratorContext<'_>, photons: &[&Photon]) -> f32 {
    let step = photons.len().div_ceil(LIT_POINTS);
    let points = photons.iter().step_by(step.max(1));
    let of_lamps = points.clone().flat_map(|photon| {
        let samples =
            context.lights.iter().filter_map(|light| light.sample(photon.position, Vec2::splat(0.5)));
        samples.map(|sample| luminance(sample.irradiance) * sample.wi.dot(photon.normal).max(0.0))
    });
    of_lamps.sum::<f32>() / points.count().max(1) as f32
}

/// The largest area that the box around points shows along an axis.
fn area(points: impl Iterator<Item = Vec3>) -> f32 {
    let bounds = points.fold(Aabb::EMPTY, Aabb::union_point);
    let Vec3 { x, y, z } = bounds.max - bounds.min;
    (x * y).max(y * z).max(z * x)
}

#[cfg(test)]
mod tests;
