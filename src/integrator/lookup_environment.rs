//! The environment as surfaces look it up: unoccluded, or as it is in a closed space.

use glam::Vec3;

use super::EnvironmentShares;
use super::closed_space::EnclosedLight;
use crate::color::luminance;
use crate::geometry::{F32Lanes, Vec3Lanes, spiral_direction};
use crate::scene::{Environment, LookupLanes};

/// Normals whose irradiances tell the mean radiance of the environment.
const MEAN_NORMALS: u32 = 64;

/// Light that lookups mix by fixed shares.
#[derive(Clone, Debug)]
pub(super) struct LookupEnvironment<'e> {
    /// Light without occlusion, of which shadow rays find what arrives.
    open: &'e Environment,
    /// The share of it that makes the share [`EnvironmentShares::occluded`] of the mixed light, on average.
    open_share: f32,
    /// The rest.
    enclosed: Option<EnclosedLight>,
}

impl<'e> LookupEnvironment<'e> {
    pub(super) fn new(open: &'e Environment, shares: &EnvironmentShares) -> Self {
        let enclosed = shares.enclosed.clone();
        let open_share = enclosed.as_ref().map_or(1.0, |enclosed| {
            let of_open = luminance(mean_radiance(open)) * (1.0 - shares.occluded);
            let of_enclosed = luminance(enclosed.mean_radiance()) * shares.occluded;
            if of_enclosed > 0.0 { of_enclosed / (of_open + of_enclosed) } else { shares.occluded }
        });
        Self { open, open_share, enclosed }
    }

    /// Whether no lookup depends on its direction or roughness.
    pub(super) fn is_uniform(&self) -> bool {
        self.enclosed.is_none() && self.open.is_uniform()
    }

    /// Irradiance on a surface with this normal.
    #[inline]
    pub(super) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        self.mixed(|| self.open.irradiance(normal), |enclosed| enclosed.irradiance(position, normal))
    }

    /// Mean radiance in a lobe around a direction.
    #[inline]
    pub(super) fn prefiltered(&self, position: Vec3, direction: Vec3, roughness: f32) -> Vec3 {
        self.mixed(
            || self.open.prefiltered(direction, roughness),
            |enclosed| enclosed.prefiltered(position, direction),
        )
    }

    /// [`LookupEnvironment::irradiance`] of several normals.
    pub(super) fn irradiances(&self, positions: &Vec3Lanes, normals: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        if self.open_share > 0.0 {
            self.open.irradiances(normals, out);
        }
        self.mix_lanes(normals, out, |enclosed, lane, normal| {
            enclosed.irradiance(positions.get(lane), normal)
        });
    }

    /// [`LookupEnvironment::prefiltered`] of several directions.
    pub(super) fn prefiltered_lanes(
        &self,
        positions: &Vec3Lanes,
        directions: &LookupLanes<'_>,
        roughness: &F32Lanes,
        out: &mut Vec3Lanes,
    ) {
        if self.open_share > 0.0 {
            self.open.prefiltered_lanes(directions, roughness, out);
        }
        self.mix_lanes(directions, out, |enclosed, lane, direction| {
            enclosed.prefiltered(positions.get(lane), direction)
        });
    }

    /// Mean radiance without the peaks of the environment.
    pub(super) fn mean_radiance(&self) -> Vec3 {
        self.mixed(|| mean_radiance(self.open), EnclosedLight::mean_radiance)
    }

    #[inline]
    fn mixed(&self, open: impl FnOnce() -> Vec3, enclosed: impl FnOnce(&EnclosedLight) -> Vec3) -> Vec3 {
        match &self.enclosed {
            None => open(),
            Some(light) if self.open_share > 0.0 => {
                open() * self.open_share + enclosed(light) * (1.0 - self.open_share)
            }
            Some(light) => enclosed(light),
        }
    }

    /// [`LookupEnvironment::mixed`] in lanes, of which `out` has the open part.
    fn mix_lanes(
        &self,
        lookups: &LookupLanes<'_>,
        out: &mut Vec3Lanes,
        enclosed: impl Fn(&EnclosedLight, usize, Vec3) -> Vec3,
    ) {
        let Some(light) = &self.enclosed else { return };
        for lane in lookups.lanes {
            let closed = enclosed(light, lane, lookups.directions.get(lane));
            out.set(lane, self.mixed(|| out.get(lane), |_| closed));
        }
    }
}

/// Mean radiance of an environment without its peaks.
fn mean_radiance(environment: &Environment) -> Vec3 {
    // The mean irradiance over all normals is π times the mean radiance.
    let normals = (0..MEAN_NORMALS).map(|index| spiral_direction(index, MEAN_NORMALS));
    let sum: Vec3 = normals.map(|normal| environment.irradiance(normal)).sum();
    sum * (std::f32::consts::FRAC_1_PI / MEAN_NORMALS as f32)
}
