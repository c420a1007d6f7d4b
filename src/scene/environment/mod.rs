//! Environment light and its lookups: radiance along a ray, irradiance for a normal, prefiltered radiance for a rough lobe.
//!
//! Directions are unit vectors in world space and point away from the surface. This module reads no image files;
//! [`EnvironmentMap::new`] takes decoded pixels.

mod arc_tangent;
mod background;
mod blocks;
mod bordered_image;
mod built_in;
mod cell_grid;
mod cube_map;
mod distribution;
mod equirect;
mod filtered_image;
mod irradiance;
mod key_light;
mod light_grid;
mod lobe_level;
mod lookup_lanes;
mod luminance_image;
mod map;
mod map_rotation;
mod octahedral;
mod peaks;
mod prefilter;
mod probe_line;
mod sectors;

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use self::sectors::SectorTables;
use super::{ImageLight, ImageLightIndex, ImageLightPose};
use crate::color::luminance;
use crate::geometry::DirectionSample;

pub use built_in::BuiltInLight;
pub(crate) use cube_map::image_bytes_for_cube;
pub(crate) use distribution::prefix_sums;
pub use key_light::KeyLight;
pub(crate) use light_grid::LightGrid;
pub(crate) use lookup_lanes::LookupLanes;
pub(crate) use luminance_image::LuminanceImage;
pub use map::{EnvironmentImage, EnvironmentMap};
pub(crate) use sectors::{EnvironmentSectors, SECTOR_COLUMNS, SECTOR_ROWS, SECTORS, interval};

/// Light from outside the scene.
#[derive(Clone, Debug, Default)]
pub enum Environment {
    /// No light.
    #[default]
    None,
    /// The same radiance from every direction.
    Constant(Vec3),
    /// A procedural light with one key light.
    BuiltIn(BuiltInLight),
    /// An equirectangular image, or a cube map that was converted to one.
    Map(EnvironmentMap),
    /// An environment with an intensity factor and, optionally, a separate background.
    Composed(Box<ComposedEnvironment>),
}

/// A light, its intensity, and the background that camera rays see.
#[derive(Clone, Debug)]
pub struct ComposedEnvironment {
    /// Lights the scene. Reflected and transmitted rays see it.
    pub light: Environment,
    /// Factor on `light` and on its key light.
    pub intensity: f32,
    /// Seen by camera rays that leave the scene; `None` shows the light.
    pub background: Option<Environment>,
}

impl Environment {
    /// The environment of the scene's image-based light `index`.
    ///
    /// With `is_animated` the map is built without rotation and with an intensity of one, for [`Environment::posed`].
    pub fn of_image_light(light: &ImageLight, index: ImageLightIndex, is_animated: bool) -> Self {
        if !is_animated {
            return Self::Map(EnvironmentMap::of_image_light(light, index, light.pose()));
        }
        let map = EnvironmentMap::of_image_light(light, index, ImageLightPose::IDENTITY);
        Self::Map(map.rotated(Quat::IDENTITY))
    }

    /// Text that differs whenever the light differs. It is part of the render hash of a frame.
    ///
    /// Image files enter by their SHA-256 and rotation, floats by their bits. An image-based light enters by its index,
    /// because the content hash of the scene covers its pixels.
    pub fn content_key(&self) -> String {
        match self {
            Self::None => "none".to_owned(),
            Self::Constant(radiance) => {
                let [r, g, b] = radiance.to_array().map(f32::to_bits);
                format!("constant {r:08x} {g:08x} {b:08x}")
            }
            Self::BuiltIn(light) => light.name().to_owned(),
            Self::Map(map) => map.content_key().to_owned(),
            Self::Composed(composed) => {
                let ComposedEnvironment { light, intensity, background } = &**composed;
                let mut key = light.content_key();
                if *intensity != 1.0 {
                    key = format!("{key} times {:08x}", intensity.to_bits());
                }
                if let Some(background) = background {
                    key = format!("{key} before {}", background.content_key());
                }
                key
            }
        }
    }

    /// The environment with its animated image-based light at `pose`; `None` for an environment without one.
    pub fn posed(&self, pose: &ImageLightPose) -> Option<Self> {
        let (light, intensity, background) = match self {
            Self::Map(map) if map.is_animated() => {
                (Self::Map(map.rotated(pose.rotation)), pose.intensity, None)
            }
            Self::Composed(composed) => {
                (composed.light.posed(pose)?, composed.intensity, composed.background.clone())
            }
            _ => return None,
        };
        Some(Self::Composed(Box::new(ComposedEnvironment { light, intensity, background })))
    }

    /// Radiance along a ray that leaves the scene in `direction`.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::BuiltIn(light) => light.radiance(direction),
            Self::Map(map) => map.radiance(direction),
            Self::Composed(composed) => composed.light.radiance(direction) * composed.intensity,
        }
    }

    /// Samples a direction towards what is brighter than the mean by `u`, a point of the unit square; `None` where nothing is brighter.
    pub(crate) fn sample(&self, u: Vec2) -> Option<DirectionSample> {
        match self {
            Self::BuiltIn(light) => light.distribution().sample(u),
            Self::Map(map) => map.sample(u),
            Self::Composed(composed) if composed.intensity > 0.0 => composed.light.sample(u),
            Self::None | Self::Constant(_) | Self::Composed(_) => None,
        }
    }

    /// The density with which [`Environment::sample`] samples a direction.
    pub(crate) fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Self::BuiltIn(light) => light.distribution().pdf(direction),
            Self::Map(map) => map.pdf(direction),
            Self::Composed(composed) if composed.intensity > 0.0 => composed.light.pdf(direction),
            Self::None | Self::Constant(_) | Self::Composed(_) => 0.0,
        }
    }

    /// The environment by sectors of directions; `None` where it is dark.
    pub(crate) fn sectors(&self) -> Option<EnvironmentSectors<'_>> {
        let in_world = |tables| EnvironmentSectors::new(tables, None);
        match self {
            Self::Constant(radiance) if luminance(*radiance) > 0.0 => SectorTables::uniform().map(in_world),
            Self::BuiltIn(light) => light.sectors().map(in_world),
            Self::Map(map) => {
                map.sectors().map(|tables| EnvironmentSectors::new(tables, Some(map.rotation())))
            }
            Self::Composed(composed) if composed.intensity > 0.0 => composed.light.sectors(),
            Self::None | Self::Constant(_) | Self::Composed(_) => None,
        }
    }

    /// The grid of a lit environment. Images and built-in lights keep it, unless a clip rotates them or a factor scales them.
    pub(crate) fn light_grid(&self) -> Arc<LightGrid> {
        match self {
            Self::BuiltIn(light) => light.light_grid(),
            Self::Map(map) if !map.is_animated() => map.light_grid(),
            Self::Composed(composed) if composed.intensity == 1.0 => composed.light.light_grid(),
            Self::None | Self::Constant(_) | Self::Map(_) | Self::Composed(_) => {
                Arc::new(LightGrid::new(|lookups, roughness, out| {
                    self.prefiltered_lanes(lookups, roughness, out);
                }))
            }
        }
    }

    /// Mean of [`Environment::radiance`] over the parallelogram around `direction` that the two ray `differentials` span.
    pub fn radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        match self {
            Self::BuiltIn(light) => light.radiance_over(direction, differentials),
            Self::Map(map) => map.radiance_over(direction, differentials),
            Self::Composed(composed) => {
                composed.light.radiance_over(direction, differentials) * composed.intensity
            }
            Self::None | Self::Constant(_) => self.radiance(direction),
        }
    }

    /// [`Environment::radiance_over`] without [`Environment::peaks`].
    pub fn open_radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        match self {
            Self::Map(map) => map.open_radiance_over(direction, differentials),
            Self::Composed(composed) => {
                composed.light.open_radiance_over(direction, differentials) * composed.intensity
            }
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => self.radiance_over(direction, differentials),
        }
    }

    /// [`Environment::radiance_over`] for camera rays, which see the background, and of a built-in light its backdrop only.
    pub fn background_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        match self {
            Self::BuiltIn(light) => light.backdrop(direction),
            Self::Composed(composed) => match &composed.background {
                Some(background) => background.background_over(direction, differentials),
                None => composed.light.background_over(direction, differentials) * composed.intensity,
            },
            Self::None | Self::Constant(_) | Self::Map(_) => self.radiance_over(direction, differentials),
        }
    }

    /// Irradiance E(n) = ∫ L cos θ dω over the hemisphere around `normal`, without [`Environment::peaks`]. A diffuse surface of albedo a
    /// reflects E a / π.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance * PI,
            Self::BuiltIn(light) => light.irradiance(normal),
            Self::Map(map) => map.irradiance(normal),
            Self::Composed(composed) => composed.light.irradiance(normal) * composed.intensity,
        }
    }

    /// Prefiltered radiance: the mean under the GGX lobe of `roughness` (α is its square) around `direction`, for a
    /// view along the normal (Karis 2013), or at a cosine of 0.6 for roughness 1. Multiply it by the lobe's directional albedo. Roughness 0 is
    /// [`Environment::radiance`] but for the light of [`Environment::peaks`], which is in none.
    pub fn prefiltered(&self, direction: Vec3, roughness: f32) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::BuiltIn(light) => light.prefiltered(direction, roughness),
            Self::Map(map) => map.prefiltered(direction, roughness),
            Self::Composed(composed) => composed.light.prefiltered(direction, roughness) * composed.intensity,
        }
    }

    /// The directional light of the environment; only built-in lights have one.
    pub fn key_light(&self) -> Option<KeyLight> {
        match self {
            Self::BuiltIn(light) => Some(light.key_light()),
            Self::Composed(composed) => composed
                .light
                .key_light()
                .map(|key| KeyLight { irradiance: key.irradiance * composed.intensity, ..key }),
            Self::None | Self::Constant(_) | Self::Map(_) => None,
        }
    }

    /// The suns and small lamps of an image. [`Environment::irradiance`], [`Environment::prefiltered`] and
    /// [`Environment::open_radiance_over`] do not contain them; all else does.
    pub fn peaks(&self) -> Vec<KeyLight> {
        match self {
            Self::Map(map) => map.peaks(),
            Self::Composed(composed) => {
                let scaled =
                    |peak: KeyLight| KeyLight { irradiance: peak.irradiance * composed.intensity, ..peak };
                composed.light.peaks().into_iter().map(scaled).collect()
            }
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => Vec::new(),
        }
    }

    /// Exposure in stops that the environment was made for, at which surfaces keep the brightness of their base colours;
    /// `None` where it has to be measured. A factor on the light does not change it.
    pub fn exposure_ev(&self) -> Option<f32> {
        match self {
            Self::BuiltIn(light) => Some(light.exposure_ev()),
            Self::Composed(composed) => composed.light.exposure_ev(),
            Self::None | Self::Constant(_) | Self::Map(_) => None,
        }
    }

    /// Whether its kind has the same light from all directions, or none.
    pub(crate) fn is_uniform(&self) -> bool {
        match self {
            Self::None | Self::Constant(_) => true,
            Self::BuiltIn(_) | Self::Map(_) => false,
            Self::Composed(composed) => composed.light.is_uniform(),
        }
    }

    /// Whether its light comes from an image.
    pub(crate) fn is_image(&self) -> bool {
        match self {
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => false,
            Self::Map(_) => true,
            Self::Composed(composed) => composed.light.is_image(),
        }
    }

    /// Pixels of all images.
    pub(crate) fn pixel_count(&self) -> usize {
        match self {
            Self::None | Self::Constant(_) | Self::BuiltIn(_) => 0,
            Self::Map(map) => map.pixel_count(),
            Self::Composed(composed) => {
                composed.light.pixel_count() + composed.background.as_ref().map_or(0, Self::pixel_count)
            }
        }
    }

    /// Whether the environment emits any light.
    pub fn is_lit(&self) -> bool {
        match self {
            Self::None => false,
            Self::Constant(radiance) => *radiance != Vec3::ZERO,
            Self::BuiltIn(_) => true,
            Self::Map(map) => map.is_lit(),
            Self::Composed(composed) => composed.intensity > 0.0 && composed.light.is_lit(),
        }
    }
}

#[cfg(test)]
mod tests;
