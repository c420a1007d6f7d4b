//! Light that comes from all around, and how surfaces look it up: by a ray, by a normal, by a rough lobe.
//!
//! Directions are unit vectors in world space, pointing away from the surface. Reading picture files is not done here; see
//! [`EnvironmentMap::new`].

mod cube;
mod filtered;
mod irradiance;
mod map;
mod picture;
mod prefilter;
mod studio;

use std::f32::consts::PI;

use glam::{Quat, Vec3};

use super::{ImageLight, ImageLightPose};

pub use cube::columns_for_cube;
pub use map::EnvironmentMap;

/// What surrounds the scene.
#[derive(Clone, Debug, Default)]
pub enum Environment {
    /// Nothing.
    #[default]
    None,
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// A soft gradient with one key light, for scenes without any light.
    Studio,
    /// An equirectangular picture.
    Map(EnvironmentMap),
    /// Light of another strength, or something else behind the scene than what lights it.
    Composed(Box<ComposedEnvironment>),
}

/// Light and background apart.
#[derive(Clone, Debug)]
pub struct ComposedEnvironment {
    /// What lights the scene and is seen in mirrors and through glass.
    pub light: Environment,
    /// Multiplies `light`, its key light too.
    pub intensity: f32,
    /// What camera rays see that leave the scene; `None` is the light.
    pub background: Option<Environment>,
}

/// A directional light that belongs to an environment and casts shadows; lookups of the environment do not contain it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyLight {
    /// Unit vector towards the light.
    pub direction_to_light: Vec3,
    /// What falls on a surface that faces the light.
    pub irradiance: Vec3,
}

impl Environment {
    /// The surroundings that `light` describes; with `moves` at no turn and an intensity of one, for [`Environment::posed`].
    pub fn of_image_light(light: &ImageLight, moves: bool) -> Self {
        if !moves {
            return Self::Map(EnvironmentMap::of_image_light(light, light.pose()));
        }
        Self::Map(EnvironmentMap::of_image_light(light, ImageLightPose::PLAIN).moved(Quat::IDENTITY))
    }

    /// The environment while the image-based light in it is at `pose`; `None` where it has none that moves.
    pub fn posed(&self, pose: &ImageLightPose) -> Option<Self> {
        let (light, intensity, background) = match self {
            Self::Map(map) if map.is_moved() => (Self::Map(map.moved(pose.rotation)), pose.intensity, None),
            Self::Composed(composed) => {
                (composed.light.posed(pose)?, composed.intensity, composed.background.clone())
            }
            _ => return None,
        };
        Some(Self::Composed(Box::new(ComposedEnvironment { light, intensity, background })))
    }

    /// Radiance that a ray leaving the scene along `direction` sees.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Studio => studio::radiance(direction),
            Self::Map(map) => map.radiance(direction),
            Self::Composed(composed) => composed.light.radiance(direction) * composed.intensity,
        }
    }

    /// Mean of [`Environment::radiance`] around `direction`, over the parallelogram that `turns` span: what a ray sees that
    /// stands for its neighbourhood. What is smooth is looked up in the middle.
    pub fn radiance_over(&self, direction: Vec3, turns: [Vec3; 2]) -> Vec3 {
        match self {
            Self::Map(map) => map.radiance_over(direction, turns),
            Self::Composed(composed) => composed.light.radiance_over(direction, turns) * composed.intensity,
            Self::None | Self::Constant(_) | Self::Studio => self.radiance(direction),
        }
    }

    /// The same for camera rays, which see the background.
    pub fn background_over(&self, direction: Vec3, turns: [Vec3; 2]) -> Vec3 {
        match self {
            Self::Composed(composed) => match &composed.background {
                Some(background) => background.radiance_over(direction, turns),
                None => self.radiance_over(direction, turns),
            },
            _ => self.radiance_over(direction, turns),
        }
    }

    /// E(n) = ∫ L cos θ dω over the half-space of `normal`; a diffuse surface of albedo a sends out E a / π.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance * PI,
            Self::Studio => studio::irradiance(normal),
            Self::Map(map) => map.irradiance(normal),
            Self::Composed(composed) => composed.light.irradiance(normal) * composed.intensity,
        }
    }

    /// Mean radiance under the GGX lobe of `roughness` (α is its square) around the mirror direction, for a view along the
    /// normal (Karis 2013); multiply by the lobe's directional albedo. Roughness 0 is [`Environment::radiance`].
    pub fn prefiltered(&self, direction: Vec3, roughness: f32) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Studio => studio::prefiltered(direction, roughness),
            Self::Map(map) => map.prefiltered(direction, roughness),
            Self::Composed(composed) => composed.light.prefiltered(direction, roughness) * composed.intensity,
        }
    }

    /// The directional light that goes with it, only for the studio.
    pub fn key_light(&self) -> Option<KeyLight> {
        match self {
            Self::Studio => Some(studio::key_light()),
            Self::Composed(composed) => composed
                .light
                .key_light()
                .map(|key| KeyLight { irradiance: key.irradiance * composed.intensity, ..key }),
            Self::None | Self::Constant(_) | Self::Map(_) => None,
        }
    }

    /// Whether any light comes from it.
    pub fn is_lit(&self) -> bool {
        match self {
            Self::None => false,
            Self::Constant(radiance) => *radiance != Vec3::ZERO,
            Self::Studio => true,
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
    fn nothing_is_dark() {
        let environment = Environment::default();
        assert_eq!(environment.radiance(Vec3::Y), Vec3::ZERO);
        assert_eq!(environment.irradiance(Vec3::Y), Vec3::ZERO);
        assert_eq!(environment.prefiltered(Vec3::Y, 0.5), Vec3::ZERO);
        assert!(!environment.is_lit() && !Environment::Constant(Vec3::ZERO).is_lit());
    }

    #[test]
    fn only_the_studio_brings_a_key_light() {
        let key = Environment::Studio.key_light().unwrap();
        assert!((key.direction_to_light.length() - 1.0).abs() < 1e-6);
        assert!(key.direction_to_light.y > 0.5 && key.irradiance.min_element() > 0.0);
    }

    #[test]
    fn intensity_scales_all_light_and_the_background_stands_apart() {
        let composed = |background| {
            let light = Environment::Studio;
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 0.5, background }))
        };
        let (half, studio) = (composed(None), Environment::Studio);
        let direction = Vec3::new(0.6, 0.0, -0.8);
        assert_eq!(half.radiance(direction) * 2.0, studio.radiance(direction));
        assert_eq!(half.irradiance(direction) * 2.0, studio.irradiance(direction));
        assert_eq!(half.prefiltered(direction, 0.3) * 2.0, studio.prefiltered(direction, 0.3));
        let key = |environment: &Environment| environment.key_light().unwrap().irradiance;
        assert_eq!(key(&half) * 2.0, key(&studio));
        let turns = [Vec3::ZERO; 2];
        assert_eq!(half.background_over(direction, turns), half.radiance(direction));

        let green = composed(Some(Environment::Constant(Vec3::Y)));
        assert_eq!(green.background_over(direction, turns), Vec3::Y);
        assert_eq!(green.radiance_over(direction, turns), half.radiance(direction));
        let dark = ComposedEnvironment { light: studio, intensity: 0.0, background: None };
        assert!(!Environment::Composed(Box::new(dark)).is_lit() && half.is_lit());
    }

    #[test]
    fn a_moved_image_light_is_the_one_that_stands_there() {
        // Each face a colour of its own.
        let face = |face: u8| vec![[f32::from(face), 1.0, 0.5]];
        let level = CubeLevel { size: 1, faces: [0, 1, 2, 3, 4, 5].map(face) };
        let mut light = ImageLight {
            name: None,
            intensity: 1.0,
            rotation: Quat::IDENTITY,
            irradiance: std::array::from_fn(|i| Vec3::splat(if i == 0 { 3.0 } else { 0.02 * i as f32 })),
            levels: vec![level.clone(), level],
        };
        let moving = Environment::of_image_light(&light, true);
        assert!(Environment::of_image_light(&light, false).posed(&light.pose()).is_none());
        // A quarter turn about each axis, and half as strong.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            light.rotation = Quat::from_vec4((axis * 0.5_f32.sqrt()).extend(0.5_f32.sqrt()));
            light.intensity = 0.5;
            let still = Environment::of_image_light(&light, false);
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
    }
}
