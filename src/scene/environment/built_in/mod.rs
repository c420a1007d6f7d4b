//! Built-in lights: procedural environments with a key light.
//!
//! The radiance is a gradient from the floor over the horizon to the ceiling, the backdrop, with soft-edged areas over it.
//! Camera rays see the backdrop alone. Lobes look up small octahedral images of the means of the radiance, computed from it when
//! they are first needed. One thread computes an image: a lookup may come from within a job of a thread pool, and a job that
//! blocks there may start another that asks for the same image.

mod area;
mod designs;
mod gradient;
mod lobes;

use std::sync::{Arc, OnceLock};

use std::f32::consts::PI;

use glam::Vec3;

use super::distribution::EnvironmentDistribution;
use super::key_light::KeyLight;
use super::light_grid::LightGrid;
use super::lookup_lanes::LookupLanes;
use super::octahedral::OctahedralImage;
use super::prefilter::{STEPS, roughest_weight};
use super::sectors::SectorTables;
use crate::color::luminance;
use crate::geometry::{F32Lanes, LANES, Vec3Lanes, vectorized};
use area::{Area, Parallelogram, direction};
use designs::Design;
use gradient::Gradient;
use lobes::{Lobe, mean_image};

/// Rows of the distribution of samples.
const DISTRIBUTION_ROWS: usize = 128;

/// A light that needs no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltInLight {
    /// Key, fill and rim areas around a neutral gradient. Lights scenes that have no light of their own.
    Studio,
    /// Large soft boxes above and at the sides, bright and even.
    Softbox,
    /// Blue sky, sun, and light from the ground.
    Outdoor,
    /// Two strong rim lights in the dark.
    Dark,
}

impl BuiltInLight {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Studio, Self::Softbox, Self::Outdoor, Self::Dark];

    /// The name, as settings have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Softbox => "softbox",
            Self::Outdoor => "outdoor",
            Self::Dark => "dark",
        }
    }

    /// Radiance along a direction.
    pub(super) fn radiance(self, direction: Vec3) -> Vec3 {
        self.prepared().radiance(direction)
    }

    /// Mean of the radiance over the parallelogram around `direction` that the `differentials` span.
    pub(super) fn radiance_over(self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        self.prepared().radiance_over(direction, differentials)
    }

    /// The distribution of [`super::Environment::sample`].
    pub(super) fn distribution(self) -> &'static EnvironmentDistribution {
        self.prepared().distribution()
    }

    /// See [`super::Environment::light_grid`].
    pub(super) fn light_grid(self) -> Arc<LightGrid> {
        let kept = &self.prepared().light_grid;
        // Made outside of the lock: on a thread that makes it, rayon may run a task that needs it, too.
        let made = || {
            Arc::new(LightGrid::new(|lookups, roughness, out| {
                self.prefiltered_lanes(lookups, roughness, out);
            }))
        };
        let grid = kept.get().cloned().unwrap_or_else(made);
        Arc::clone(kept.get_or_init(|| grid))
    }

    /// See [`super::Environment::sectors`].
    pub(super) fn sectors(self) -> Option<&'static SectorTables> {
        self.prepared().sectors()
    }

    /// Radiance that camera rays see: without the areas.
    pub(super) fn backdrop(self, direction: Vec3) -> Vec3 {
        self.design().backdrop.radiance(direction)
    }

    /// See [`super::Environment::irradiance`].
    pub(super) fn irradiance(self, normal: Vec3) -> Vec3 {
        self.prepared().irradiance_image().bilinear(normal)
    }

    /// See [`super::Environment::prefiltered`].
    pub(super) fn prefiltered(self, direction: Vec3, roughness: f32) -> Vec3 {
        self.prepared().prefiltered((direction, roughness), |image| image.bilinear(direction))
    }

    /// See [`super::Environment::irradiances`].
    pub(super) fn irradiances(self, lookups: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        let image = self.prepared().irradiance_image();
        let uvs = lookups.octahedral_positions();
        for lane in lookups.lanes {
            out.set(lane, image.at(uvs.get(lane)));
        }
    }

    /// See [`super::Environment::prefiltered_lanes`].
    pub(super) fn prefiltered_lanes(
        self,
        lookups: &LookupLanes<'_>,
        roughness: &F32Lanes,
        out: &mut Vec3Lanes,
    ) {
        let prepared = self.prepared();
        let uvs = lookups.octahedral_positions();
        for lane in lookups.lanes {
            let lookup = (lookups.directions.get(lane), roughness[lane]);
            out.set(lane, prepared.prefiltered(lookup, |image| image.at(uvs.get(lane))));
        }
    }

    /// See [`super::Environment::backgrounds`].
    pub(super) fn backdrops(self, lookups: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        let backdrop = &self.design().backdrop;
        vectorized!(lookups.level, {
            for lane in 0..LANES {
                out.set(lane, backdrop.radiance(lookups.directions.get(lane)));
            }
        });
    }

    /// The directional light, which is not part of the radiance.
    pub(super) fn key_light(self) -> KeyLight {
        self.prepared().key_light
    }

    /// Exposure that the light is made for, in stops.
    pub(super) fn exposure_ev(self) -> f32 {
        self.design().exposure_ev
    }

    fn design(self) -> &'static Design {
        match self {
            Self::Studio => &designs::STUDIO,
            Self::Softbox => &designs::SOFTBOX,
            Self::Outdoor => &designs::OUTDOOR,
            Self::Dark => &designs::DARK,
        }
    }

    fn prepared(self) -> &'static Prepared {
        static PREPARED: [OnceLock<Prepared>; 4] = [const { OnceLock::new() }; 4];
        PREPARED[self as usize].get_or_init(|| Prepared::new(self.design()))
    }
}

/// A light, prepared for lookups.
#[derive(Debug)]
struct Prepared {
    backdrop: &'static Gradient,
    areas: Vec<Area>,
    key_light: KeyLight,
    distribution: OnceLock<EnvironmentDistribution>,
    sectors: OnceLock<Option<SectorTables>>,
    light_grid: OnceLock<Arc<LightGrid>>,
    irradiance: OnceLock<OctahedralImage>,
    /// Means under lobes of roughness 1/8, 2/8, … 1.
    lobes: [OnceLock<OctahedralImage>; STEPS],
}

impl Prepared {
    fn new(design: &'static Design) -> Self {
        let key = &design.key;
        Self {
            backdrop: &design.backdrop,
            areas: design.areas.iter().map(Area::new).collect(),
            key_light: KeyLight {
                direction_to_light: direction(key.azimuth, key.elevation),
                irradiance: key.irradiance,
            },
            distribution: OnceLock::new(),
            sectors: OnceLock::new(),
            light_grid: OnceLock::new(),
            irradiance: OnceLock::new(),
            lobes: std::array::from_fn(|_| OnceLock::new()),
        }
    }

    fn distribution(&self) -> &EnvironmentDistribution {
        let rows = DISTRIBUTION_ROWS as u32;
        let luminance = |direction: Vec3| luminance(self.radiance(direction));
        self.distribution.get_or_init(|| EnvironmentDistribution::of(rows, 2 * rows, luminance))
    }

    fn sectors(&self) -> Option<&SectorTables> {
        let luminance = |direction: Vec3| luminance(self.radiance(direction));
        self.sectors.get_or_init(|| SectorTables::of(DISTRIBUTION_ROWS, luminance)).as_ref()
    }

    fn mean_image(&self, weight: fn(f64) -> f64, total: f32) -> OctahedralImage {
        mean_image(|towards, width| self.radiance_over_square(towards, width), weight, total)
    }

    fn irradiance_image(&self) -> &OctahedralImage {
        self.irradiance.get_or_init(|| self.mean_image(|cosine| cosine, PI))
    }

    /// See [`super::Environment::prefiltered`]; `lookup` looks up the direction in the image of a lobe.
    #[inline(always)]
    fn prefiltered(
        &self,
        (direction, roughness): (Vec3, f32),
        lookup: impl Fn(&OctahedralImage) -> Vec3,
    ) -> Vec3 {
        let step = roughness.clamp(0.0, 1.0) * STEPS as f32;
        let below = (step as usize).min(STEPS - 1);
        let share = step - below as f32;
        let sharper = match below {
            0 => self.radiance(direction),
            _ => lookup(self.lobe_image(below)),
        };
        if share <= 0.0 {
            return sharper;
        }
        sharper * (1.0 - share) + lookup(self.lobe_image(below + 1)) * share
    }

    fn radiance(&self, direction: Vec3) -> Vec3 {
        let backdrop = self.backdrop.radiance(direction);
        self.areas.iter().fold(backdrop, |behind, area| area.over(behind, direction))
    }

    fn radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let backdrop = self.backdrop.radiance(direction);
        let directions = Parallelogram::new(direction, differentials);
        self.areas.iter().fold(backdrop, |behind, area| area.mean_over(behind, &directions))
    }

    /// Mean of the radiance over a square of directions of the given width, as an angle.
    fn radiance_over_square(&self, direction: Vec3, width: f32) -> Vec3 {
        let backdrop = self.backdrop.radiance(direction);
        self.areas.iter().fold(backdrop, |behind, area| area.mean_over_square(behind, direction, width))
    }

    /// Means under the lobe of a roughness of `step` eighths, from 1 to 8.
    fn lobe_image(&self, step: usize) -> &OctahedralImage {
        self.lobes[step - 1].get_or_init(|| {
            if step == STEPS {
                return self.mean_image(roughest_weight, 1.0);
            }
            let lobe = Lobe::ggx(step);
            OctahedralImage::new(lobe.cells, |direction| {
                lobe.mean(direction, |towards, width| self.radiance_over_square(towards, width))
            })
        })
    }
}

#[cfg(test)]
mod tests;
