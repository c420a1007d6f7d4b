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
mod focusing_materials;
mod guide_build;
mod photon;
mod photon_sources;
mod photons;
mod point_tree;

use glam::{Vec2, Vec3};

use self::direction_tree::DirectionTree;
pub(in crate::integrator) use self::photon::{Photon, PhotonPath, PhotonRay, PhotonStore};
pub(crate) use self::photons::most_photon_bytes;
use self::point_tree::PointTree;
use crate::geometry::DirectionSample;

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
    /// Samples a direction that photons came from.
    pub(super) fn sample(&self, u: Vec2) -> DirectionSample {
        self.directions.sample(u)
    }

    /// The density of a unit direction by solid angle, where the lobes of the surface have `lobe_pdf`.
    pub(super) fn mixed_pdf(&self, direction: Vec3, lobe_pdf: f32) -> f32 {
        self.share * self.directions.pdf(direction) + (1.0 - self.share) * lobe_pdf
    }
}

#[cfg(test)]
mod tests;
