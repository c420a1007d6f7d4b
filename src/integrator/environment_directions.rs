//! Directions of shadow rays towards the environment, for surfaces that look its light up.
//!
//! Whitted's tree, and both integrators on what only receives shadows, multiply a looked-up light by an estimate of the share that
//! arrives: a ratio of shadowed to unshadowed samples (Heitz, Hill and McGuire, "Combining Analytic Direct Illumination and Stochastic
//! Shadows", I3D 2018). Directions follow the light that the lookup averages, so that the ratio is the mean visibility of the samples.

mod hemisphere_light;

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use self::hemisphere_light::{HemisphereLight, LightWindow};
use super::local_frame::local_frame;
use super::occluders::DirectionRange;
use crate::geometry::{F32Lanes, Vec2Lanes, Vec3Lanes, sin_cos_of_turn};
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
        let candidates = LobeDirections::new(axis, roughness, u);
        let mut sums = [0.0; CANDIDATES];
        let mut sum = 0.0;
        for (uv, sum_to) in candidates.uvs().into_iter().zip(&mut sums) {
            sum += self.grid.luminance_at_uv(uv);
            *sum_to = sum;
        }
        let chosen = sums.iter().position(|sum_to| random * sum < *sum_to);
        let any = ((random * CANDIDATES as f32) as usize).min(CANDIDATES - 1);
        candidates.get(chosen.unwrap_or(any))
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

/// Stratified directions of a lobe of [`EnvironmentDirections::glossy`], component by component, so that they are computed in lanes.
struct LobeDirections {
    x: [f32; CANDIDATES],
    y: [f32; CANDIDATES],
    z: [f32; CANDIDATES],
}

impl LobeDirections {
    #[inline(always)]
    fn new(axis: Vec3, roughness: f32, u: Vec2) -> Self {
        let alpha_squared = (roughness * roughness) * (roughness * roughness);
        // Half vectors up to 45° from the axis
        let scale = 1.0 + alpha_squared;
        let cosines = in_lanes(|stratum| {
            let u_x = (stratum as f32 + u.x) / CANDIDATES as f32 / scale;
            1.0 / (1.0 + alpha_squared * u_x / (1.0 - u_x)).sqrt()
        });
        let sines = in_lanes(|i| (1.0 - cosines[i] * cosines[i]).max(0.0).sqrt());
        let (mut along_tangent, mut along_bitangent) = ([0.0; CANDIDATES], [0.0; CANDIDATES]);
        for stratum in 0..CANDIDATES {
            let turns = u.y + stratum as f32 * GOLDEN_SHARE;
            let (sine, cosine) = sin_cos_of_turn((turns - turns as i32 as f32) * TAU);
            along_tangent[stratum] = sines[stratum] * cosine;
            along_bitangent[stratum] = sines[stratum] * sine;
        }

        // Mirror the axis at the half vectors.
        let frame = local_frame(axis);
        let component = |tangent: f32, bitangent: f32, axis: f32| {
            in_lanes(|i| {
                let half = tangent * along_tangent[i] + bitangent * along_bitangent[i] + axis * cosines[i];
                half * (2.0 * cosines[i]) - axis
            })
        };
        Self {
            x: component(frame.x_axis.x, frame.y_axis.x, frame.z_axis.x),
            y: component(frame.x_axis.y, frame.y_axis.y, frame.z_axis.y),
            z: component(frame.x_axis.z, frame.y_axis.z, frame.z_axis.z),
        }
    }

    #[inline(always)]
    fn get(&self, candidate: usize) -> Vec3 {
        Vec3::new(self.x[candidate], self.y[candidate], self.z[candidate])
    }

    /// Positions in the unit square.
    #[inline(always)]
    fn uvs(&self) -> [Vec2; CANDIDATES] {
        std::array::from_fn(|candidate| LuminanceImage::uv_from_direction(self.get(candidate)))
    }
}

/// A direction of the cosine lobe around a normal.
fn cosine_direction(normal: Vec3, u: Vec2) -> Vec3 {
    let (sine, cosine) = sin_cos_of_turn((u.y - u.y as i32 as f32) * TAU);
    let radius = u.x.sqrt();
    local_frame(normal) * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).max(0.0).sqrt())
}

/// The value of each lane.
#[inline(always)]
fn in_lanes(value: impl Fn(usize) -> f32) -> [f32; CANDIDATES] {
    std::array::from_fn(value)
}

#[cfg(test)]
mod tests;
