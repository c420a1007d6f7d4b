//! Environment light and its lookups: radiance along a ray, irradiance for a normal, prefiltered radiance for a rough lobe.
//!
//! Directions are unit vectors in world space and point away from the surface. This module reads no image files;
//! [`EnvironmentMap::new`] takes decoded pixels.

mod arc_tangent;
mod background;
mod blocks;
mod built_in;
mod cube_map;
mod distribution;
mod equirect;
mod filtered_image;
mod irradiance;
mod key_light;
mod lobe_level;
mod lookup_lanes;
mod luminance_image;
mod map;
mod octahedral;
mod peaks;
mod prefilter;

use std::f32::consts::PI;

use glam::{Quat, Vec2, Vec3};

use super::{ImageLight, ImageLightIndex, ImageLightPose};

pub use built_in::BuiltInLight;
pub(crate) use cube_map::columns_for_cube;
pub use key_light::KeyLight;
pub(crate) use lookup_lanes::LookupLanes;
pub(crate) use luminance_image::LuminanceImage;
pub use map::{EnvironmentImage, EnvironmentMap};

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

    /// Samples a direction towards what is brighter than the mean by `u`, a point of the unit square: a unit vector and its density over solid
    /// angle. `None` where nothing is brighter.
    pub(crate) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
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

    /// Prefiltered radiance: the mean under the GGX lobe of `roughness` (α is its square) around the mirror direction, for a
    /// view along the normal (Karis 2013). Multiply it by the lobe's directional albedo. Roughness 0 is
    /// [`Environment::radiance`]. All are without [`Environment::peaks`].
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
mod tests {
    use super::*;
    use crate::scene::CubeLevel;

    #[test]
    fn constant_light_is_exact() {
        let environment = Environment::Constant(Vec3::new(1.0, 2.0, 3.0));
        let direction = Vec3::new(0.6, -0.8, 0.0);
        assert_eq!(environment.radiance(direction), Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(environment.prefiltered(direction, 0.7), Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(environment.irradiance(direction), Vec3::new(PI, 2.0 * PI, 3.0 * PI));
        assert!(environment.is_lit() && environment.key_light().is_none());
    }

    #[test]
    fn an_empty_environment_is_dark() {
        let environment = Environment::default();
        assert_eq!(environment.radiance(Vec3::Y), Vec3::ZERO);
        assert_eq!(environment.irradiance(Vec3::Y), Vec3::ZERO);
        assert_eq!(environment.prefiltered(Vec3::Y, 0.5), Vec3::ZERO);
        assert!(!environment.is_lit() && !Environment::Constant(Vec3::ZERO).is_lit());
    }

    #[test]
    fn built_in_lights_bring_a_key_light() {
        for light in BuiltInLight::ALL {
            let key = Environment::BuiltIn(light).key_light().unwrap();
            assert!((key.direction_to_light.length() - 1.0).abs() < 1e-6);
            assert!(key.direction_to_light.y > 0.5 && key.irradiance.min_element() > 0.0);
        }
    }

    #[test]
    fn camera_rays_see_the_backdrop_without_the_areas() {
        let composed = |light, background| {
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 2.0, background }))
        };
        for light in BuiltInLight::ALL.map(Environment::BuiltIn) {
            let zero = [Vec3::ZERO; 2];
            // The backdrop depends on the height alone; the areas do not.
            let around: [Vec3; 24] = std::array::from_fn(|step| {
                let (sin_azimuth, cos_azimuth) = libm::sincosf(step as f32 * PI / 12.0);
                Vec3::new(0.96 * sin_azimuth, 0.28, 0.96 * cos_azimuth)
            });
            let seen = light.background_over(around[0], zero);
            assert!(around.iter().all(|&direction| light.background_over(direction, zero) == seen));
            assert!(around.iter().any(|&direction| light.radiance_over(direction, zero) != seen));
            // As the light, times its intensity, and as a background of its own.
            assert_eq!(composed(light.clone(), None).background_over(around[1], zero), seen * 2.0);
            let constant = Environment::Constant(Vec3::X);
            assert_eq!(composed(constant, Some(light)).background_over(around[2], zero), seen);
        }
    }

    #[test]
    fn intensity_scales_all_light_but_not_the_background() {
        let composed = |background| {
            let light = Environment::BuiltIn(BuiltInLight::Studio);
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 0.5, background }))
        };
        let (half, studio) = (composed(None), Environment::BuiltIn(BuiltInLight::Studio));
        let direction = Vec3::new(0.6, 0.0, -0.8);
        assert_eq!(half.radiance(direction) * 2.0, studio.radiance(direction));
        assert_eq!(half.irradiance(direction) * 2.0, studio.irradiance(direction));
        assert_eq!(half.prefiltered(direction, 0.3) * 2.0, studio.prefiltered(direction, 0.3));
        let key = |environment: &Environment| environment.key_light().unwrap().irradiance;
        assert_eq!(key(&half) * 2.0, key(&studio));
        let differentials = [Vec3::ZERO; 2];
        let seen = half.background_over(direction, differentials) * 2.0;
        assert_eq!(seen, studio.background_over(direction, differentials));

        let green = composed(Some(Environment::Constant(Vec3::Y)));
        assert_eq!(green.background_over(direction, differentials), Vec3::Y);
        assert_eq!(
            green.radiance_over(direction, differentials),
            half.radiance_over(direction, differentials)
        );
        let dark = ComposedEnvironment { light: studio, intensity: 0.0, background: None };
        assert!(!Environment::Composed(Box::new(dark)).is_lit() && half.is_lit());
    }

    #[test]
    fn a_posed_image_light_equals_one_built_at_that_pose() {
        // Each face has its own colour.
        let face = |face: u8| vec![[f32::from(face), 1.0, 0.5]];
        let level = CubeLevel { size: 1, faces: [0, 1, 2, 3, 4, 5].map(face) };
        let mut light = ImageLight {
            name: None,
            intensity: 1.0,
            rotation: Quat::IDENTITY,
            irradiance: std::array::from_fn(|i| Vec3::splat(if i == 0 { 3.0 } else { 0.02 * i as f32 })),
            levels: vec![level.clone(), level],
        };
        let moving = Environment::of_image_light(&light, ImageLightIndex(3), true);
        assert!(
            Environment::of_image_light(&light, ImageLightIndex(3), false).posed(&light.pose()).is_none()
        );
        // Rotations by 90° about each axis, at half the intensity.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            light.rotation = Quat::from_vec4((axis * 0.5_f32.sqrt()).extend(0.5_f32.sqrt()));
            light.intensity = 0.5;
            let still = Environment::of_image_light(&light, ImageLightIndex(3), false);
            let composed = ComposedEnvironment { light: moving.clone(), intensity: 1.0, background: None };
            let composed = Environment::Composed(Box::new(composed));
            for moved in [moving.posed(&light.pose()).unwrap(), composed.posed(&light.pose()).unwrap()] {
                for direction in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.36, -0.48, 0.8)] {
                    let close = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 0.02;
                    assert!(
                        close(moved.radiance(direction), still.radiance(direction)),
                        "{axis} {direction}"
                    );
                    assert!(close(moved.irradiance(direction), still.irradiance(direction)));
                    assert!(close(moved.prefiltered(direction, 1.0), still.prefiltered(direction, 1.0)));
                }
            }
        }
        light.intensity = 0.0;
        assert!(!moving.posed(&light.pose()).unwrap().is_lit());
        assert_eq!(moving.content_key(), "image light 3");
    }

    #[test]
    fn keys_name_the_content() {
        let constant = Environment::Constant(Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(constant.content_key(), "constant 3f800000 3f000000 00000000");
        let composed = |intensity, background| {
            let light = Environment::BuiltIn(BuiltInLight::Studio);
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity, background }))
        };
        assert_eq!(composed(1.0, Some(Environment::None)).content_key(), "studio before none");
        assert_eq!(composed(0.5, None).content_key(), "studio times 3f000000");
        let both = composed(0.5, Some(constant));
        assert_eq!(both.content_key(), "studio times 3f000000 before constant 3f800000 3f000000 00000000");
        let pixels = vec![[1.0; 3]];
        let image = EnvironmentImage { width: 1, height: 1, pixels, content_hash: [0xab; 32] };
        let map = EnvironmentMap::new(std::path::Path::new("sky.hdr"), image, 1.0).unwrap();
        assert_eq!(Environment::Map(map).content_key(), format!("map {} turned 3f800000", "ab".repeat(32)));
    }
}
