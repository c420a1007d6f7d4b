//! Directions of shadow rays towards the environment, for surfaces that look its light up.
//!
//! Whitted's tree, and both integrators on what only receives shadows, multiply a looked-up light by an estimate of the share that
//! arrives: a ratio of shadowed to unshadowed samples (Heitz, Hill and McGuire, "Combining Analytic Direct Illumination and Stochastic
//! Shadows", I3D 2018). Directions follow the light that the lookup averages, so that the ratio is the mean visibility of the samples.

mod hemisphere_light;

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use self::hemisphere_light::{HemisphereLight, LightWindow};
use super::local_frame::local_frame;
use super::occluders::DirectionRange;
use crate::geometry::{F32Lanes, Vec2Lanes, Vec3Lanes, sin_cos_of_turn, vectorized};
use crate::scene::{Environment, LightGrid, LookupLanes, LuminanceImage};

/// The golden ratio less one: the share of a turn from one candidate to the next.
pub(super) const GOLDEN_SHARE: f32 = 0.618_034;

/// Directions of a rough lobe among which one is chosen.
const CANDIDATES: usize = 4;

/// Directions by the luminance of an environment.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentDirections {
    /// Directions of diffuse surfaces.
    pub(super) grid: Arc<LightGrid>,
    /// The light above most receivers.
    above_receivers: Option<HemisphereLight>,
}

/// The light of a range of directions above a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum RangeLight<'a> {
    /// Directions are sampled by their light, above most receivers.
    ByLight(&'a HemisphereLight, LightWindow),
    /// Directions are sampled by their cosine, above others.
    ByCosine {
        range: DirectionRange,
        grid: &'a LightGrid,
        /// Projected solid angle over the irradiance by the grid: the share of all light for one of luminance.
        share: f32,
    },
}

impl EnvironmentDirections {
    /// Directions of an environment that is lit.
    pub(super) fn new(environment: &Environment) -> Self {
        Self { grid: environment.light_grid(), above_receivers: None }
    }

    /// The same for receivers, most of which have this unit normal.
    pub(super) fn with_receivers(mut self, normal: Vec3) -> Self {
        self.above_receivers = Some(HemisphereLight::new(normal, |wi| self.grid.luminance(wi)));
        self
    }

    /// The light of a range. `irradiance` is that of its surface by the grid.
    pub(super) fn in_range(&self, range: DirectionRange, irradiance: f32) -> RangeLight<'_> {
        match &self.above_receivers {
            Some(light) if light.normal() == range.normal() => {
                RangeLight::ByLight(light, light.window(&range))
            }
            _ => {
                let share = range.projected_solid_angle() / irradiance;
                RangeLight::ByCosine { range, grid: &self.grid, share }
            }
        }
    }

    /// Luminance from a direction, blurred by the cells of the grid.
    pub(super) fn luminance(&self, direction: Vec3) -> f32 {
        self.grid.luminance(direction)
    }

    /// A direction from which light reaches a diffuse surface ([`LightGrid::diffuse`]); where none does, one of those from which other
    /// surfaces do, by their cosine.
    pub(super) fn diffuse(&self, normal: Vec3, (u, random): (Vec2, f32)) -> Vec3 {
        self.grid.diffuse(normal, u, random).unwrap_or_else(|| cosine_direction(normal, u))
    }

    /// [`EnvironmentDirections::diffuse`] for the lanes of `normals`; other lanes get any direction.
    pub(super) fn diffuse_lanes(
        &self,
        normals: &LookupLanes<'_>,
        (u, randoms): (&Vec2Lanes, &F32Lanes),
        directions: &mut Vec3Lanes,
    ) {
        let lit = self.grid.diffuse_lanes(normals, u, randoms, directions);
        for lane in normals.lanes.filtered(|lane| !lit.contains(lane)) {
            directions.set(lane, cosine_direction(normals.directions.get(lane), u.get(lane)));
        }
    }

    /// A direction of the lobe that prefiltered lookups average: GGX of `roughness` around `axis`, for a view along it, as far as it is within
    /// 90°. Of several ones, one is chosen by its luminance (Talbot, Cline and Egbert, "Importance Resampling for Global Illumination", 2005), any
    /// where all are dark.
    pub(super) fn glossy(&self, axis: Vec3, roughness: f32, (u, random): (Vec2, f32)) -> Vec3 {
        let frame = local_frame(axis);
        let candidates: [Vec3; CANDIDATES] =
            std::array::from_fn(|stratum| lobe_direction(&frame, roughness, u, stratum));
        let uvs = candidates.map(LuminanceImage::uv_from_direction);
        candidates[self.chosen_candidate(&uvs, random)]
    }

    /// [`EnvironmentDirections::glossy`] for the lanes of `axes`; other lanes keep their directions.
    pub(super) fn glossy_lanes(
        &self,
        axes: &LookupLanes<'_>,
        roughness: &F32Lanes,
        (u, randoms): (&Vec2Lanes, &F32Lanes),
        directions: &mut Vec3Lanes,
    ) {
        let LookupLanes { level, directions: axes, lanes } = *axes;
        let mut candidates = [Vec3Lanes::default(); CANDIDATES];
        let mut uvs = [Vec2Lanes::default(); CANDIDATES];
        vectorized!(level, {
            for (stratum, (candidates, uvs)) in candidates.iter_mut().zip(&mut uvs).enumerate() {
                for (lane, &roughness) in roughness.iter().enumerate() {
                    let frame = local_frame(axes.get(lane));
                    let candidate = lobe_direction(&frame, roughness, u.get(lane), stratum);
                    candidates.set(lane, candidate);
                    uvs.set(lane, LuminanceImage::uv_from_direction(candidate));
                }
            }
        });
        for lane in lanes {
            let chosen = self.chosen_candidate(&uvs.each_ref().map(|uvs| uvs.get(lane)), randoms[lane]);
            directions.set(lane, candidates[chosen].get(lane));
        }
    }

    /// The index of a candidate by the luminance at its position in the unit square.
    #[inline(always)]
    fn chosen_candidate(&self, uvs: &[Vec2; CANDIDATES], random: f32) -> usize {
        let mut sum = 0.0;
        let sums = uvs.map(|uv| {
            sum += self.grid.luminance_at_uv(uv);
            sum
        });
        let chosen = sums.iter().position(|sum_to| random * sum < *sum_to);
        chosen.unwrap_or(((random * CANDIDATES as f32) as usize).min(CANDIDATES - 1))
    }
}

impl RangeLight<'_> {
    /// The largest share of the surface's light that [`RangeLight::sample`] may find in the range.
    pub(super) fn max_share(&self) -> f32 {
        match self {
            Self::ByLight(light, window) => window.irradiance() / light.irradiance(),
            Self::ByCosine { grid, share, .. } => grid.brightest() * share,
        }
    }

    /// A direction, and an estimate of the share of the surface's light that comes from the range.
    pub(super) fn sample(&self, u: Vec2) -> (Vec3, f32) {
        match self {
            Self::ByLight(light, window) => (light.direction(window, u.into()), self.max_share()),
            Self::ByCosine { range, grid, share } => {
                let wi = range.direction(u);
                (wi, grid.luminance(wi) * share)
            }
        }
    }
}

/// One of the stratified directions of a lobe of [`EnvironmentDirections::glossy`] around the last axis of `frame`.
#[inline(always)]
fn lobe_direction(frame: &Mat3, roughness: f32, u: Vec2, stratum: usize) -> Vec3 {
    let alpha_squared = (roughness * roughness) * (roughness * roughness);
    // Half vectors up to 45° from the axis
    let scale = 1.0 + alpha_squared;
    let u_x = (stratum as f32 + u.x) / CANDIDATES as f32 / scale;
    let cosine = 1.0 / (1.0 + alpha_squared * u_x / (1.0 - u_x)).sqrt();
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let turns = u.y + stratum as f32 * GOLDEN_SHARE;
    let (sin_azimuth, cos_azimuth) = sin_cos_of_turn((turns - turns as i32 as f32) * TAU);
    // The axis mirrored at the half vector
    let half =
        frame.x_axis * (sine * cos_azimuth) + frame.y_axis * (sine * sin_azimuth) + frame.z_axis * cosine;
    half * (2.0 * cosine) - frame.z_axis
}

/// A direction of the cosine lobe around a normal.
fn cosine_direction(normal: Vec3, u: Vec2) -> Vec3 {
    let (sine, cosine) = sin_cos_of_turn((u.y - u.y as i32 as f32) * TAU);
    let radius = u.x.sqrt();
    local_frame(normal) * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).max(0.0).sqrt())
}

#[cfg(test)]
mod tests;
