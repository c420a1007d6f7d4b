//! Lookups of blocks of directions: the values of those of single directions, whose positions in the images are computed in lanes.

use std::f32::consts::PI;

use glam::Vec3;

use super::Environment;
use super::lookup_lanes::LookupLanes;
use crate::geometry::{F32Lanes, LANES, Vec3Lanes};

impl Environment {
    /// [`Environment::irradiance`] of several normals.
    pub(crate) fn irradiances(&self, normals: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        match self {
            Self::None => fill(out, Vec3::ZERO),
            Self::Constant(radiance) => fill(out, *radiance * PI),
            Self::BuiltIn(light) => light.irradiances(normals, out),
            Self::Map(map) => map.irradiances(normals, out),
            Self::Composed(composed) => {
                composed.light.irradiances(normals, out);
                scale(out, composed.intensity);
            }
        }
    }

    /// [`Environment::prefiltered`] of several directions.
    pub(crate) fn prefiltered_lanes(
        &self,
        directions: &LookupLanes<'_>,
        roughness: &F32Lanes,
        out: &mut Vec3Lanes,
    ) {
        match self {
            Self::None => fill(out, Vec3::ZERO),
            Self::Constant(radiance) => fill(out, *radiance),
            Self::BuiltIn(light) => light.prefiltered_lanes(directions, roughness, out),
            Self::Map(map) => map.prefiltered_lanes(directions, roughness, out),
            Self::Composed(composed) => {
                composed.light.prefiltered_lanes(directions, roughness, out);
                scale(out, composed.intensity);
            }
        }
    }

    /// [`Environment::background_over`] of several camera rays. `differentials` are read only where
    /// [`Environment::background_is_filtered`].
    pub(crate) fn backgrounds(
        &self,
        directions: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        match self {
            Self::None => fill(out, Vec3::ZERO),
            Self::Constant(radiance) => fill(out, *radiance),
            Self::BuiltIn(light) => light.backdrops(directions, out),
            Self::Map(map) => map.radiances_over(directions, differentials, out),
            Self::Composed(composed) => {
                if let Some(background) = &composed.background {
                    return background.backgrounds(directions, differentials, out);
                }
                composed.light.backgrounds(directions, differentials, out);
                scale(out, composed.intensity);
            }
        }
    }

    /// [`Environment::radiance_over`] of several directions.
    pub(crate) fn radiances_over(
        &self,
        directions: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        match self {
            Self::Map(map) => map.radiances_over(directions, differentials, out),
            Self::Composed(composed) => {
                composed.light.radiances_over(directions, differentials, out);
                scale(out, composed.intensity);
            }
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => {
                for lane in directions.lanes {
                    let steps = [0, 1].map(|axis| differentials[axis].get(lane));
                    out.set(lane, self.radiance_over(directions.directions.get(lane), steps));
                }
            }
        }
    }

    /// [`Environment::open_radiance_over`] of several directions.
    pub(crate) fn open_radiances_over(
        &self,
        directions: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        match self {
            Self::Map(map) => map.open_radiances_over(directions, differentials, out),
            Self::Composed(composed) => {
                composed.light.open_radiances_over(directions, differentials, out);
                scale(out, composed.intensity);
            }
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => {
                self.radiances_over(directions, differentials, out);
            }
        }
    }
}

fn fill(lanes: &mut Vec3Lanes, value: Vec3) {
    for lane in 0..LANES {
        lanes.set(lane, value);
    }
}

fn scale(lanes: &mut Vec3Lanes, factor: f32) {
    for lane in 0..LANES {
        lanes.set(lane, lanes.get(lane) * factor);
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;
    use glam::Vec2;

    use super::super::equirect::EquirectImage;
    use super::*;
    use crate::geometry::ActiveLanes;
    use crate::scene::{BuiltInLight, ComposedEnvironment, EnvironmentImage, EnvironmentMap};

    fn environments() -> Vec<Environment> {
        // A sky with a sun, which is a peak
        let mut image = EquirectImage::of(64, |d| Vec3::new(1.0 + d.x, 1.0 + d.y, 0.2));
        image.pixels[9 * 64 + 20] = [9000.0; 3];
        let image = EnvironmentImage { width: 64, height: 32, pixels: image.pixels, content_hash: [0; 32] };
        let map = EnvironmentMap::new(std::path::Path::new("sky.hdr"), image, 70.0).unwrap();
        assert_eq!(map.peaks().len(), 1);
        let composed = |light, background| {
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 0.7, background }))
        };
        vec![
            Environment::None,
            Environment::Constant(Vec3::new(0.3, 0.2, 0.1)),
            Environment::BuiltIn(BuiltInLight::Studio),
            Environment::Map(map.clone()),
            composed(Environment::BuiltIn(BuiltInLight::Outdoor), None),
            composed(Environment::Map(map.clone()), Some(Environment::Map(map))),
        ]
    }

    #[test]
    fn lanes_have_the_bits_of_single_lookups() {
        let mut directions = Vec3Lanes::default();
        let mut differentials = [Vec3Lanes::default(); 2];
        let mut roughness = F32Lanes::default();
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for (lane, roughness) in roughness.iter_mut().enumerate() {
            let (sin, cos) = libm::sincosf(lane as f32 * 2.4);
            let height = 1.0 - lane as f32 / 7.5;
            let across = Vec2::new(cos, sin) * (1.0 - height * height).sqrt();
            let between = Vec3::new(across.x, height, across.y);
            directions.set(lane, axes.get(lane).copied().unwrap_or(between));
            *roughness = lane as f32 / 15.0;
            differentials[0].set(lane, Vec3::new(0.03, 0.0, 0.01) * lane as f32);
            differentials[1].set(lane, Vec3::new(0.0, 0.02, 0.001));
        }
        for environment in environments() {
            for level in [Level::fallback(), Level::new()] {
                let lanes = ActiveLanes::first(LANES);
                let lookups = LookupLanes { level, directions: &directions, lanes };
                let mut found = [Vec3Lanes::default(); 5];
                environment.irradiances(&lookups, &mut found[0]);
                environment.prefiltered_lanes(&lookups, &roughness, &mut found[1]);
                environment.backgrounds(&lookups, &differentials, &mut found[2]);
                environment.radiances_over(&lookups, &differentials, &mut found[3]);
                environment.open_radiances_over(&lookups, &differentials, &mut found[4]);
                for lane in lanes {
                    let direction = directions.get(lane);
                    let steps = [0, 1].map(|axis| differentials[axis].get(lane));
                    assert_eq!(found[0].get(lane), environment.irradiance(direction));
                    assert_eq!(found[1].get(lane), environment.prefiltered(direction, roughness[lane]));
                    assert_eq!(found[2].get(lane), environment.background_over(direction, steps));
                    assert_eq!(found[3].get(lane), environment.radiance_over(direction, steps));
                    assert_eq!(found[4].get(lane), environment.open_radiance_over(direction, steps));
                }
            }
        }
    }
}
