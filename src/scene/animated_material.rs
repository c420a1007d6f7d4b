//! Animatable properties of materials, and their setter.

use std::ops::RangeInclusive;

use glam::{Vec2, Vec3, Vec4};

use super::ranges::{ANY, AT_LEAST_ONE, NOT_NEGATIVE, UNIT};
use super::{AlphaMode, Material, TextureRef, UvRotation, UvTransform};

/// Animatable property of a material.
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
    /// The thickness of [`Material::volume`], which only switches the volume on and off.
    Thickness,
    /// The distance of [`Material::volume`], metres.
    AttenuationDistance,
    /// The colour of [`Material::volume`], 3 components.
    AttenuationColor,
    /// [`Material::dispersion`].
    Dispersion,
    /// The factor of [`Material::specular`].
    Specular,
    /// The colour of [`Material::specular`], 3 components.
    SpecularColor,
    /// The factor of [`Material::glossiness`].
    Glossiness,
    /// The factor of [`Material::clear_coat`].
    ClearCoat,
    /// The roughness of [`Material::clear_coat`].
    ClearCoatRoughness,
    /// The scale of the normal texture of [`Material::clear_coat`].
    ClearCoatNormalScale,
    /// The colour of [`Material::sheen`], 3 components.
    SheenColor,
    /// The roughness of [`Material::sheen`].
    SheenRoughness,
    /// The factor of [`Material::iridescence`].
    Iridescence,
    /// The index of refraction of [`Material::iridescence`].
    IridescenceIor,
    /// The least thickness of [`Material::iridescence`], nanometres.
    IridescenceThicknessMinimum,
    /// The greatest thickness of [`Material::iridescence`], nanometres.
    IridescenceThicknessMaximum,
    /// The strength of [`Material::anisotropy`].
    Anisotropy,
    /// The rotation of [`Material::anisotropy`], radians.
    AnisotropyRotation,
    /// The factor of [`Material::diffuse_transmission`].
    DiffuseTransmission,
    /// The colour of [`Material::diffuse_transmission`], 3 components.
    DiffuseTransmissionColor,
    /// Offset of a texture, 2 components.
    TextureOffset(TextureSlot),
    /// Rotation of a texture, radians.
    TextureRotation(TextureSlot),
    /// Scale of a texture, 2 components.
    TextureScale(TextureSlot),
}

/// Texture slot of a material.
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
    /// The texture of [`Material::transmission`].
    Transmission,
    /// The thickness texture of [`Material::volume`]. It is not kept, because rays measure the thickness themselves.
    Thickness,
    /// The factor texture of [`Material::specular`].
    Specular,
    /// The colour texture of [`Material::specular`].
    SpecularColor,
    /// The texture shared by [`Material::glossiness`] and the colour of [`Material::specular`].
    SpecularGlossiness,
    /// The factor texture of [`Material::clear_coat`].
    ClearCoat,
    /// The roughness texture of [`Material::clear_coat`].
    ClearCoatRoughness,
    /// The normal map of [`Material::clear_coat`].
    ClearCoatNormal,
    /// The colour texture of [`Material::sheen`].
    SheenColor,
    /// The roughness texture of [`Material::sheen`].
    SheenRoughness,
    /// The factor texture of [`Material::iridescence`].
    Iridescence,
    /// The thickness texture of [`Material::iridescence`].
    IridescenceThickness,
    /// The texture of [`Material::anisotropy`].
    Anisotropy,
    /// The factor texture of [`Material::diffuse_transmission`].
    DiffuseTransmission,
    /// The colour texture of [`Material::diffuse_transmission`].
    DiffuseTransmissionColor,
}

impl MaterialProperty {
    /// Number of components.
    pub fn width(self) -> usize {
        match self {
            Self::BaseColor => 4,
            Self::EmissiveFactor
            | Self::AttenuationColor
            | Self::SpecularColor
            | Self::SheenColor
            | Self::DiffuseTransmissionColor => 3,
            Self::TextureOffset(_) | Self::TextureScale(_) => 2,
            _ => 1,
        }
    }

    /// Valid range of every component.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::BaseColor
            | Self::Metallic
            | Self::Roughness
            | Self::OcclusionStrength
            | Self::Transmission
            | Self::AttenuationColor
            | Self::Specular
            | Self::Glossiness
            | Self::ClearCoat
            | Self::ClearCoatRoughness
            | Self::SheenColor
            | Self::SheenRoughness
            | Self::Iridescence
            | Self::Anisotropy
            | Self::DiffuseTransmission
            | Self::DiffuseTransmissionColor => UNIT,
            Self::EmissiveFactor
            | Self::EmissiveStrength
            | Self::AlphaCutoff
            | Self::Ior
            | Self::Thickness
            | Self::AttenuationDistance
            | Self::Dispersion
            | Self::SpecularColor
            | Self::IridescenceThicknessMinimum
            | Self::IridescenceThicknessMaximum => NOT_NEGATIVE,
            Self::IridescenceIor => AT_LEAST_ONE,
            Self::NormalScale
            | Self::ClearCoatNormalScale
            | Self::AnisotropyRotation
            | Self::TextureOffset(_)
            | Self::TextureRotation(_)
            | Self::TextureScale(_) => ANY,
        }
    }
}

/// Sets a property of a material from its components. Ignores properties that the material does not have.
pub(crate) fn set_material(material: &mut Material, property: MaterialProperty, values: &[f32]) {
    let first = values.first().copied().unwrap_or(0.0);
    match property {
        MaterialProperty::BaseColor => material.base_color = vec4(values),
        MaterialProperty::EmissiveFactor => {
            material.emissive_factor = vec3(values);
            material.emissive = material.emissive_factor * material.emissive_strength;
        }
        MaterialProperty::EmissiveStrength => {
            material.emissive_strength = first;
            material.emissive = material.emissive_factor * material.emissive_strength;
        }
        // As in the file itself, an index below 1 is taken for 1, but for 0, which means no Fresnel effect.
        MaterialProperty::Ior => material.ior = if first > 0.0 { first.max(1.0) } else { 0.0 },
        // The import writes the largest number for 0, which means infinite.
        MaterialProperty::AttenuationDistance => {
            if let Some(volume) = &mut material.volume {
                volume.attenuation_distance = if first < f32::MAX { first } else { f32::INFINITY };
            }
        }
        MaterialProperty::Glossiness => {
            if let Some(glossiness) = &mut material.glossiness {
                glossiness.factor = first;
                material.roughness = 1.0 - first;
            }
        }
        MaterialProperty::TextureOffset(slot) => {
            transform(material, slot, |transform| transform.offset = vec2(values));
        }
        MaterialProperty::TextureRotation(slot) => {
            transform(material, slot, |transform| transform.rotation = UvRotation::from_radians(first));
        }
        MaterialProperty::TextureScale(slot) => {
            transform(material, slot, |transform| transform.scale = vec2(values));
        }
        _ => {
            if let Some(number) = number(material, property) {
                *number = first;
            } else if let Some(color) = color(material, property) {
                *color = vec3(values);
            }
        }
    }
}

/// The field of a property of one component.
fn number(material: &mut Material, property: MaterialProperty) -> Option<&mut f32> {
    let coat = material.clear_coat.as_mut();
    let film = material.iridescence.as_mut();
    Some(match property {
        MaterialProperty::Metallic => &mut material.metallic,
        MaterialProperty::Roughness => &mut material.roughness,
        MaterialProperty::AlphaCutoff => match &mut material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque | AlphaMode::Blend => return None,
        },
        MaterialProperty::NormalScale => &mut material.normal_texture.as_mut()?.scale,
        MaterialProperty::OcclusionStrength => &mut material.occlusion_texture.as_mut()?.strength,
        MaterialProperty::Transmission => &mut material.transmission.as_mut()?.factor,
        MaterialProperty::Thickness => &mut material.volume.as_mut()?.thickness,
        MaterialProperty::Dispersion => &mut material.dispersion,
        MaterialProperty::Specular => &mut material.specular.as_mut()?.factor,
        MaterialProperty::ClearCoat => &mut coat?.factor,
        MaterialProperty::ClearCoatRoughness => &mut coat?.roughness,
        MaterialProperty::ClearCoatNormalScale => &mut coat?.normal_texture.as_mut()?.scale,
        MaterialProperty::SheenRoughness => &mut material.sheen.as_mut()?.roughness,
        MaterialProperty::Iridescence => &mut film?.factor,
        MaterialProperty::IridescenceIor => &mut film?.ior,
        MaterialProperty::IridescenceThicknessMinimum => &mut film?.thickness_minimum_nm,
        MaterialProperty::IridescenceThicknessMaximum => &mut film?.thickness_maximum_nm,
        MaterialProperty::Anisotropy => &mut material.anisotropy.as_mut()?.strength,
        MaterialProperty::AnisotropyRotation => &mut material.anisotropy.as_mut()?.rotation_radians,
        MaterialProperty::DiffuseTransmission => &mut material.diffuse_transmission.as_mut()?.factor,
        _ => return None,
    })
}

/// The field of a colour property.
fn color(material: &mut Material, property: MaterialProperty) -> Option<&mut Vec3> {
    match property {
        MaterialProperty::AttenuationColor => Some(&mut material.volume.as_mut()?.attenuation_color),
        MaterialProperty::SpecularColor => Some(&mut material.specular.as_mut()?.color),
        MaterialProperty::SheenColor => Some(&mut material.sheen.as_mut()?.color),
        MaterialProperty::DiffuseTransmissionColor => {
            Some(&mut material.diffuse_transmission.as_mut()?.color)
        }
        _ => None,
    }
}

/// Changes the coordinate transform of a texture slot.
fn transform(material: &mut Material, slot: TextureSlot, change: impl Fn(&mut UvTransform)) {
    if let Some(texture) = texture(material, slot) {
        change(&mut texture.transform);
    }
    if slot == TextureSlot::SpecularGlossiness
        && let Some(texture) = material.glossiness.as_mut().and_then(|glossiness| glossiness.texture.as_mut())
    {
        change(&mut texture.transform);
    }
}

fn texture(material: &mut Material, slot: TextureSlot) -> Option<&mut TextureRef> {
    let coat = material.clear_coat.as_mut();
    let transmission = material.diffuse_transmission.as_mut();
    match slot {
        TextureSlot::BaseColor => material.base_color_texture.as_mut(),
        TextureSlot::MetallicRoughness => material.metallic_roughness_texture.as_mut(),
        TextureSlot::Normal => material.normal_texture.as_mut().map(|normal| &mut normal.texture),
        TextureSlot::Occlusion => material.occlusion_texture.as_mut().map(|occlusion| &mut occlusion.texture),
        TextureSlot::Emissive => material.emissive_texture.as_mut(),
        TextureSlot::Transmission => material.transmission.as_mut()?.texture.as_mut(),
        TextureSlot::Thickness => None,
        TextureSlot::Specular => material.specular.as_mut()?.texture.as_mut(),
        TextureSlot::SpecularColor | TextureSlot::SpecularGlossiness => {
            material.specular.as_mut()?.color_texture.as_mut()
        }
        TextureSlot::ClearCoat => coat?.texture.as_mut(),
        TextureSlot::ClearCoatRoughness => coat?.roughness_texture.as_mut(),
        TextureSlot::ClearCoatNormal => coat?.normal_texture.as_mut().map(|normal| &mut normal.texture),
        TextureSlot::SheenColor => material.sheen.as_mut()?.color_texture.as_mut(),
        TextureSlot::SheenRoughness => material.sheen.as_mut()?.roughness_texture.as_mut(),
        TextureSlot::Iridescence => material.iridescence.as_mut()?.texture.as_mut(),
        TextureSlot::IridescenceThickness => material.iridescence.as_mut()?.thickness_texture.as_mut(),
        TextureSlot::Anisotropy => material.anisotropy.as_mut()?.texture.as_mut(),
        TextureSlot::DiffuseTransmission => transmission?.texture.as_mut(),
        TextureSlot::DiffuseTransmissionColor => transmission?.color_texture.as_mut(),
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
    use crate::scene::{Glossiness, NormalTexture, Specular, TextureIndex, Transmission};

    #[test]
    fn an_index_below_one_is_taken_for_one_but_for_zero() {
        let mut material = Material::default();
        let posed = [0.0, 0.5, 1.5].map(|ior| {
            set_material(&mut material, MaterialProperty::Ior, &[ior]);
            material.ior
        });
        assert_eq!(posed, [0.0, 1.0, 1.5]);
    }

    #[test]
    fn emission_is_the_product_of_colour_and_strength_in_either_order() {
        let mut material = Material { emissive_factor: Vec3::ONE, ..Material::default() };
        set_material(&mut material, MaterialProperty::EmissiveStrength, &[5.0]);
        assert_eq!(material.emissive, Vec3::splat(5.0));
        set_material(&mut material, MaterialProperty::EmissiveFactor, &[0.5, 1.0, 0.0]);
        assert_eq!(material.emissive, Vec3::new(2.5, 5.0, 0.0));
    }

    #[test]
    fn properties_of_absent_extensions_are_ignored() {
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

    #[test]
    fn colour_and_glossiness_share_one_transform() {
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        let texture = Some(reference);
        let specular = Specular { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: texture };
        let glossiness = Some(Glossiness { factor: 1.0, texture });
        let mut material = Material { specular: Some(specular), glossiness, ..Material::default() };
        let slot = TextureSlot::SpecularGlossiness;
        set_material(&mut material, MaterialProperty::TextureScale(slot), &[2.0, 3.0]);
        let color = material.specular.unwrap().color_texture.unwrap();
        assert_eq!(color.transform.scale, Vec2::new(2.0, 3.0));
        assert_eq!(material.glossiness.unwrap().texture, Some(color));
    }
}
