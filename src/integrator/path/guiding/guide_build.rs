//! Making a guide of photons.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::direction_tree::{DirectionTree, IncidentPhoton};
use super::photon::Photon;
use super::photons::PhotonTracing;
use super::point_tree::PointTree;
use super::{GuidedCell, PathGuide};
use crate::color::luminance;
use crate::geometry::Aabb;
use crate::integrator::IntegratorContext;

/// Most of the samples of a diffuse lobe that follow photons, where nothing else shines.
pub(super) const LARGEST_SHARE: f32 = 0.8;
/// Surfaces that would send fewer samples after photons send none: what they cost would be in vain.
const LEAST_SHARE: f32 = 0.1;

/// Points of a cell at which the light of lamps is measured.
const LIT_POINTS: usize = 4;

/// The most photons of a cell. With fewer, cells miss light that comes from few directions.
const CELL_PHOTONS: usize = 2048;

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
