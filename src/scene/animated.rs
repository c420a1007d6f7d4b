//! Properties of materials, lights and cameras that clips can move, and setting them.

use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use glam::{Vec2, Vec3, Vec4};

use super::{AlphaMode, Light, LightKind, Material, Projection, TextureRef};

/// A number or colour of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MaterialProperty {
    /// [`Material::base_color`], 4 components.
    BaseColor,
    /// [`Material::metallic`].
    Metallic,
    /// [`Material::roughness`].
    Roughness,
    /// [`Material::emissive_factor`], 3 components.
    EmissiveFactor,
    /// [`Material::emissive_strength`].
    EmissiveStrength,
    /// The cutoff of [`AlphaMode::Mask`].
    AlphaCutoff,
    /// The scale of [`Material::normal_texture`].
    NormalScale,
    /// The strength of [`Material::occlusion_texture`].
    OcclusionStrength,
    /// [`Material::ior`].
    Ior,
    /// The factor of [`Material::transmission`].
    Transmission,
    /// The distance of [`Material::volume`], metres.
    AttenuationDistance,
    /// The colour of [`Material::volume`], 3 components.
    AttenuationColor,
    /// Where a texture begins, 2 components.
    TextureOffset(TextureSlot),
    /// How a texture is turned, radians.
    TextureRotation(TextureSlot),
    /// How often a texture repeats, 2 components.
    TextureScale(TextureSlot),
}

/// One of a material's textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TextureSlot {
    /// [`Material::base_color_texture`].
    BaseColor,
    /// [`Material::metallic_roughness_texture`].
    MetallicRoughness,
    /// [`Material::normal_texture`].
    Normal,
    /// [`Material::occlusion_texture`].
    Occlusion,
    /// [`Material::emissive_texture`].
    Emissive,
    /// That of [`Material::transmission`].
    Transmission,
}

/// A number or colour of a light.
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

/// A number of a camera.
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

const ANY: RangeInclusive<f32> = f32::MIN..=f32::MAX;
const UNIT: RangeInclusive<f32> = 0.0..=1.0;
const NOT_NEGATIVE: RangeInclusive<f32> = 0.0..=f32::MAX;
const POSITIVE: RangeInclusive<f32> = f32::MIN_POSITIVE..=f32::MAX;
const RIGHT_ANGLE: RangeInclusive<f32> = 0.0..=FRAC_PI_2;
/// Fields of view, just short of the whole half-space.
const FIELD: RangeInclusive<f32> = f32::MIN_POSITIVE..=0.9999 * PI;

impl MaterialProperty {
    /// Components of a value.
    pub fn width(self) -> usize {
        match self {
            Self::BaseColor => 4,
            Self::EmissiveFactor | Self::AttenuationColor => 3,
            Self::TextureOffset(_) | Self::TextureScale(_) => 2,
            _ => 1,
        }
    }

    /// What every component must lie in.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::BaseColor
            | Self::Metallic
            | Self::Roughness
            | Self::EmissiveFactor
            | Self::OcclusionStrength
            | Self::Transmission
            | Self::AttenuationColor => UNIT,
            Self::EmissiveStrength | Self::AlphaCutoff | Self::Ior => NOT_NEGATIVE,
            Self::AttenuationDistance => POSITIVE,
            Self::NormalScale | Self::TextureOffset(_) | Self::TextureRotation(_) | Self::TextureScale(_) => {
                ANY
            }
        }
    }
}

impl LightProperty {
    /// Components of a value.
    pub fn width(self) -> usize {
        if self == Self::Color { 3 } else { 1 }
    }

    /// What every component must lie in.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::Color => UNIT,
            Self::Intensity => NOT_NEGATIVE,
            Self::Range => POSITIVE,
            Self::InnerCone | Self::OuterCone => RIGHT_ANGLE,
        }
    }
}

impl CameraProperty {
    /// What the number must lie in.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::FieldOfView => FIELD,
            Self::AspectRatio | Self::XMag | Self::YMag | Self::ZFar => POSITIVE,
            Self::ZNear => NOT_NEGATIVE,
        }
    }
}

/// Sets a property of a material from its components; one that the material does not have stays away.
pub fn set_material(material: &mut Material, property: MaterialProperty, values: &[f32]) {
    let first = values.first().copied().unwrap_or(0.0);
    match property {
        MaterialProperty::BaseColor => material.base_color = vec4(values),
        MaterialProperty::Metallic => material.metallic = first,
        MaterialProperty::Roughness => material.roughness = first,
        MaterialProperty::EmissiveFactor => {
            material.emissive_factor = vec3(values);
            material.emissive = material.emissive_factor * material.emissive_strength;
        }
        MaterialProperty::EmissiveStrength => {
            material.emissive_strength = first;
            material.emissive = material.emissive_factor * material.emissive_strength;
        }
        MaterialProperty::AlphaCutoff => {
            if let AlphaMode::Mask { cutoff } = &mut material.alpha_mode {
                *cutoff = first;
            }
        }
        MaterialProperty::NormalScale => {
            material.normal_texture.iter_mut().for_each(|normal| normal.scale = first);
        }
        MaterialProperty::OcclusionStrength => {
            material.occlusion_texture.iter_mut().for_each(|occlusion| occlusion.strength = first);
        }
        MaterialProperty::Ior => material.ior = first,
        MaterialProperty::Transmission => {
            material.transmission.iter_mut().for_each(|transmission| transmission.factor = first);
        }
        MaterialProperty::AttenuationDistance => {
            material.volume.iter_mut().for_each(|volume| volume.attenuation_distance = first);
        }
        MaterialProperty::AttenuationColor => {
            material.volume.iter_mut().for_each(|volume| volume.attenuation_color = vec3(values));
        }
        MaterialProperty::TextureOffset(slot) => {
            if let Some(texture) = texture(material, slot) {
                texture.transform.offset = vec2(values);
            }
        }
        MaterialProperty::TextureRotation(slot) => {
            if let Some(texture) = texture(material, slot) {
                texture.transform.rotation_radians = first;
            }
        }
        MaterialProperty::TextureScale(slot) => {
            if let Some(texture) = texture(material, slot) {
                texture.transform.scale = vec2(values);
            }
        }
    }
}

fn texture(material: &mut Material, slot: TextureSlot) -> Option<&mut TextureRef> {
    match slot {
        TextureSlot::BaseColor => material.base_color_texture.as_mut(),
        TextureSlot::MetallicRoughness => material.metallic_roughness_texture.as_mut(),
        TextureSlot::Normal => material.normal_texture.as_mut().map(|normal| &mut normal.texture),
        TextureSlot::Occlusion => material.occlusion_texture.as_mut().map(|occlusion| &mut occlusion.texture),
        TextureSlot::Emissive => material.emissive_texture.as_mut(),
        TextureSlot::Transmission => material.transmission.as_mut().and_then(|layer| layer.texture.as_mut()),
    }
}

/// Sets a property of a light from its components; one that the light does not have stays away.
pub fn set_light(light: &mut Light, property: LightProperty, values: &[f32]) {
    let first = values.first().copied().unwrap_or(0.0);
    match (property, &mut light.kind) {
        (LightProperty::Color, _) => light.color = vec3(values),
        (LightProperty::Intensity, _) => light.intensity = first,
        (LightProperty::Range, _) => light.range.iter_mut().for_each(|range| *range = first),
        (LightProperty::InnerCone, LightKind::Spot { inner_cone_radians, .. }) => *inner_cone_radians = first,
        (LightProperty::OuterCone, LightKind::Spot { outer_cone_radians, .. }) => *outer_cone_radians = first,
        (LightProperty::InnerCone | LightProperty::OuterCone, _) => {}
    }
}

/// Sets a number of a camera; one that the camera does not have stays away.
pub fn set_camera(projection: &mut Projection, property: CameraProperty, value: f32) {
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

fn vec2(values: &[f32]) -> Vec2 {
    values.first_chunk().copied().map_or(Vec2::ZERO, Vec2::from_array)
}

fn vec3(values: &[f32]) -> Vec3 {
    values.first_chunk().copied().map_or(Vec3::ZERO, Vec3::from_array)
}

fn vec4(values: &[f32]) -> Vec4 {
    values.first_chunk().copied().map_or(Vec4::ZERO, Vec4::from_array)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{NormalTexture, TextureIndex, Transmission, UvTransform};

    #[test]
    fn emission_is_the_product_of_both_whatever_comes_first() {
        let mut material = Material { emissive_factor: Vec3::ONE, ..Material::default() };
        set_material(&mut material, MaterialProperty::EmissiveStrength, &[5.0]);
        assert_eq!(material.emissive, Vec3::splat(5.0));
        set_material(&mut material, MaterialProperty::EmissiveFactor, &[0.5, 1.0, 0.0]);
        assert_eq!(material.emissive, Vec3::new(2.5, 5.0, 0.0));
    }

    #[test]
    fn what_is_not_there_stays_away() {
        let mut material = Material::default();
        let plain = material.clone();
        for property in [
            MaterialProperty::NormalScale,
            MaterialProperty::Transmission,
            MaterialProperty::AttenuationDistance,
            MaterialProperty::AlphaCutoff,
            MaterialProperty::TextureRotation(TextureSlot::Normal),
        ] {
            set_material(&mut material, property, &[0.25]);
        }
        assert_eq!(material, plain);
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        material.normal_texture = Some(NormalTexture { texture: reference, scale: 1.0 });
        material.transmission = Some(Transmission { factor: 0.0, texture: None });
        set_material(&mut material, MaterialProperty::NormalScale, &[0.25]);
        set_material(&mut material, MaterialProperty::Transmission, &[0.75]);
        set_material(&mut material, MaterialProperty::TextureOffset(TextureSlot::Normal), &[0.5, -1.0]);
        let normal = material.normal_texture.unwrap();
        assert_eq!((normal.scale, normal.texture.transform.offset), (0.25, Vec2::new(0.5, -1.0)));
        assert_eq!(material.transmission.unwrap().factor, 0.75);
    }
}
