//! What the background that camera rays see depends on.

use glam::Vec3;

use super::Environment;

impl Environment {
    /// The background where it is the same in every direction.
    pub fn constant_background(&self) -> Option<Vec3> {
        let is_constant = matches!(self.seen_by_camera_rays(), Self::None | Self::Constant(_));
        is_constant.then(|| self.background_over(Vec3::Z, [Vec3::ZERO; 2]))
    }

    /// Whether [`Environment::background_over`] depends on the ray's differentials.
    pub fn background_is_filtered(&self) -> bool {
        matches!(self.seen_by_camera_rays(), Self::Map(_))
    }

    /// The environment that makes the background.
    fn seen_by_camera_rays(&self) -> &Self {
        match self {
            Self::Composed(composed) => {
                composed.background.as_ref().unwrap_or(&composed.light).seen_by_camera_rays()
            }
            Self::None | Self::Constant(_) | Self::BuiltIn(_) | Self::Map(_) => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{BuiltInLight, ComposedEnvironment};

    #[test]
    fn the_background_decides_not_the_light() {
        let composed = |light, background| {
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 2.0, background }))
        };
        let (studio, green) = (Environment::BuiltIn(BuiltInLight::Studio), Environment::Constant(Vec3::Y));
        assert_eq!(Environment::None.constant_background(), Some(Vec3::ZERO));
        assert_eq!(composed(green.clone(), None).constant_background(), Some(Vec3::Y * 2.0));
        assert_eq!(composed(studio.clone(), Some(green.clone())).constant_background(), Some(Vec3::Y));
        assert_eq!(composed(green, Some(studio.clone())).constant_background(), None);
        assert!(!studio.background_is_filtered() && studio.constant_background().is_none());
    }
}
