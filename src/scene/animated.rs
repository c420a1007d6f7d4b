//! Animatable properties of lights, image-based lights and cameras, and their setters.

use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use glam::Vec3;

use super::ranges::{ANY, NOT_NEGATIVE, POSITIVE};
use super::{Light, LightKind, Projection};

/// Animatable property of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LightProperty {
    /// [`Light::color`], 3 components.
    Color,
    /// [`Light::intensity`].
    Intensity,
    /// [`Light::range`], metres.
    Range,
    /// The inner cone of [`LightKind::Spot`], radians.
    InnerCone,
    /// The outer cone of [`LightKind::Spot`], radians.
    OuterCone,
}

/// Animatable property of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CameraProperty {
    /// Vertical field of view of a perspective camera, radians.
    FieldOfView,
    /// Width over height of a perspective camera.
    AspectRatio,
    /// Half the width of an orthographic camera, metres.
    XMag,
    /// Half the height of an orthographic camera, metres.
    YMag,
    /// Nearest distance, metres.
    ZNear,
    /// Farthest distance, metres.
    ZFar,
}

/// Animatable property of an image-based light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ImageLightProperty {
    /// [`super::ImageLight::intensity`].
    Intensity,
    /// [`super::ImageLight::rotation`], 4 components, a quaternion x y z w.
    Rotation,
}

const RIGHT_ANGLE: RangeInclusive<f32> = 0.0..=FRAC_PI_2;
/// Fields of view, up to just below 180°.
const FIELD: RangeInclusive<f32> = f32::MIN_POSITIVE..=0.9999 * PI;

impl LightProperty {
    /// Number of components.
    pub fn width(self) -> usize {
        if self == Self::Color { 3 } else { 1 }
    }

    /// Valid range of every component.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::Color => NOT_NEGATIVE,
            Self::Intensity => ANY,
            Self::Range => POSITIVE,
            Self::InnerCone | Self::OuterCone => RIGHT_ANGLE,
        }
    }
}

impl ImageLightProperty {
    /// Number of components.
    pub fn width(self) -> usize {
        if self == Self::Rotation { 4 } else { 1 }
    }

    /// Valid range of every component.
    pub fn range(self) -> RangeInclusive<f32> {
        if self == Self::Rotation { ANY } else { NOT_NEGATIVE }
    }
}

impl CameraProperty {
    /// Valid range.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::FieldOfView => FIELD,
            Self::AspectRatio | Self::XMag | Self::YMag | Self::ZFar => POSITIVE,
            Self::ZNear => NOT_NEGATIVE,
        }
    }
}

/// Sets a property of a light from its components. Ignores properties that the light does not have.
pub(crate) fn set_light(light: &mut Light, property: LightProperty, values: &[f32]) {
    let first = values.first().copied().unwrap_or(0.0);
    match (property, &mut light.kind) {
        (LightProperty::Color, _) => {
            light.color = values.first_chunk().copied().map_or(Vec3::ZERO, Vec3::from_array);
        }
        // As in the file itself, light cannot be negative.
        (LightProperty::Intensity, _) => light.intensity = first.max(0.0),
        (LightProperty::Range, _) => light.range.iter_mut().for_each(|range| *range = first),
        (LightProperty::InnerCone, LightKind::Spot { inner_cone_radians, .. }) => *inner_cone_radians = first,
        (LightProperty::OuterCone, LightKind::Spot { outer_cone_radians, .. }) => *outer_cone_radians = first,
        (LightProperty::InnerCone | LightProperty::OuterCone, _) => {}
    }
}

/// Sets a property of a camera. Ignores properties that the camera does not have.
pub(crate) fn set_camera(projection: &mut Projection, property: CameraProperty, value: f32) {
    match projection {
        Projection::Perspective { fov_y_radians, aspect_ratio, z_near, z_far } => match property {
            CameraProperty::FieldOfView => *fov_y_radians = value,
            CameraProperty::AspectRatio => *aspect_ratio = Some(value),
            CameraProperty::ZNear => *z_near = value,
            CameraProperty::ZFar => *z_far = Some(value),
            CameraProperty::XMag | CameraProperty::YMag => {}
        },
        Projection::Orthographic { x_mag, y_mag, z_near, z_far } => match property {
            CameraProperty::XMag => *x_mag = value,
            CameraProperty::YMag => *y_mag = value,
            CameraProperty::ZNear => *z_near = value,
            CameraProperty::ZFar => *z_far = value,
            CameraProperty::FieldOfView | CameraProperty::AspectRatio => {}
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_are_never_negative_and_may_be_brighter_than_white() {
        let kind = LightKind::Point;
        let mut light = Light { name: None, color: Vec3::ONE, intensity: 1.0, range: None, kind };
        set_light(&mut light, LightProperty::Intensity, &[-1.0]);
        set_light(&mut light, LightProperty::Color, &[4.0, 1.0, 0.0]);
        assert_eq!((light.intensity, light.color), (0.0, Vec3::new(4.0, 1.0, 0.0)));
    }
}
