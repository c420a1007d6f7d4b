//! Animation pointers: resolution of JSON pointers to animatable properties.
//!
//! Source: the text of `KHR_animation_pointer` and the *glTF 2.0 Asset Object Model* (Khronos Group).

use std::ops::RangeInclusive;

use super::document::Document;
use super::extension_names::{IMAGE_LIGHTS, IOR, LIGHTS, SPECULAR, SPECULAR_GLOSSINESS};
use super::raw::{ANY, POSITIVE, Raw};
use crate::scene::{
    AnimationTarget, CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex,
    LightProperty, MaterialIndex, MaterialProperty, MeshIndex, NodeIndex, TextureSlot,
};

/// Animatable property and its allowed values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) target: AnimationTarget,
    /// Components of a value; 0 if the number of morph targets determines it.
    pub(super) components: usize,
    /// Allowed range of every component of a keyframe value.
    pub(super) range: RangeInclusive<f32>,
    /// Whether the property is a boolean.
    pub(super) is_boolean: bool,
}

const MATERIAL: [(&str, MaterialProperty); 32] = [
    ("pbrMetallicRoughness/baseColorFactor", MaterialProperty::BaseColor),
    ("pbrMetallicRoughness/metallicFactor", MaterialProperty::Metallic),
    ("pbrMetallicRoughness/roughnessFactor", MaterialProperty::Roughness),
    ("emissiveFactor", MaterialProperty::EmissiveFactor),
    ("extensions/KHR_materials_emissive_strength/emissiveStrength", MaterialProperty::EmissiveStrength),
    ("alphaCutoff", MaterialProperty::AlphaCutoff),
    ("normalTexture/scale", MaterialProperty::NormalScale),
    ("occlusionTexture/strength", MaterialProperty::OcclusionStrength),
    ("extensions/KHR_materials_ior/ior", MaterialProperty::Ior),
    ("extensions/KHR_materials_transmission/transmissionFactor", MaterialProperty::Transmission),
    ("extensions/KHR_materials_volume/thicknessFactor", MaterialProperty::Thickness),
    ("extensions/KHR_materials_volume/attenuationDistance", MaterialProperty::AttenuationDistance),
    ("extensions/KHR_materials_volume/attenuationColor", MaterialProperty::AttenuationColor),
    ("extensions/KHR_materials_dispersion/dispersion", MaterialProperty::Dispersion),
    ("extensions/KHR_materials_specular/specularFactor", MaterialProperty::Specular),
    ("extensions/KHR_materials_specular/specularColorFactor", MaterialProperty::SpecularColor),
    ("extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", MaterialProperty::BaseColor),
    ("extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", MaterialProperty::SpecularColor),
    ("extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", MaterialProperty::Glossiness),
    ("extensions/KHR_materials_clearcoat/clearcoatFactor", MaterialProperty::ClearCoat),
    ("extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", MaterialProperty::ClearCoatRoughness),
    (
        "extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale",
        MaterialProperty::ClearCoatNormalScale,
    ),
    ("extensions/KHR_materials_sheen/sheenColorFactor", MaterialProperty::SheenColor),
    ("extensions/KHR_materials_sheen/sheenRoughnessFactor", MaterialProperty::SheenRoughness),
    ("extensions/KHR_materials_iridescence/iridescenceFactor", MaterialProperty::Iridescence),
    ("extensions/KHR_materials_iridescence/iridescenceIor", MaterialProperty::IridescenceIor),
    (
        "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum",
        MaterialProperty::IridescenceThicknessMinimum,
    ),
    (
        "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
        MaterialProperty::IridescenceThicknessMaximum,
    ),
    ("extensions/KHR_materials_anisotropy/anisotropyStrength", MaterialProperty::Anisotropy),
    ("extensions/KHR_materials_anisotropy/anisotropyRotation", MaterialProperty::AnisotropyRotation),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
        MaterialProperty::DiffuseTransmission,
    ),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        MaterialProperty::DiffuseTransmissionColor,
    ),
];

const TEXTURES: [(&str, TextureSlot); 21] = [
    ("pbrMetallicRoughness/baseColorTexture", TextureSlot::BaseColor),
    ("pbrMetallicRoughness/metallicRoughnessTexture", TextureSlot::MetallicRoughness),
    ("normalTexture", TextureSlot::Normal),
    ("occlusionTexture", TextureSlot::Occlusion),
    ("emissiveTexture", TextureSlot::Emissive),
    ("extensions/KHR_materials_transmission/transmissionTexture", TextureSlot::Transmission),
    ("extensions/KHR_materials_volume/thicknessTexture", TextureSlot::Thickness),
    ("extensions/KHR_materials_specular/specularTexture", TextureSlot::Specular),
    ("extensions/KHR_materials_specular/specularColorTexture", TextureSlot::SpecularColor),
    ("extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture", TextureSlot::BaseColor),
    (
        "extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
        TextureSlot::SpecularGlossiness,
    ),
    ("extensions/KHR_materials_clearcoat/clearcoatTexture", TextureSlot::ClearCoat),
    ("extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture", TextureSlot::ClearCoatRoughness),
    ("extensions/KHR_materials_clearcoat/clearcoatNormalTexture", TextureSlot::ClearCoatNormal),
    ("extensions/KHR_materials_sheen/sheenColorTexture", TextureSlot::SheenColor),
    ("extensions/KHR_materials_sheen/sheenRoughnessTexture", TextureSlot::SheenRoughness),
    ("extensions/KHR_materials_iridescence/iridescenceTexture", TextureSlot::Iridescence),
    ("extensions/KHR_materials_iridescence/iridescenceThicknessTexture", TextureSlot::IridescenceThickness),
    ("extensions/KHR_materials_anisotropy/anisotropyTexture", TextureSlot::Anisotropy),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
        TextureSlot::DiffuseTransmission,
    ),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture",
        TextureSlot::DiffuseTransmissionColor,
    ),
];

const LIGHT: [(&str, LightProperty); 5] = [
    ("color", LightProperty::Color),
    ("intensity", LightProperty::Intensity),
    ("range", LightProperty::Range),
    ("spot/innerConeAngle", LightProperty::InnerCone),
    ("spot/outerConeAngle", LightProperty::OuterCone),
];

const IMAGE_LIGHT: [(&str, ImageLightProperty); 2] =
    [("intensity", ImageLightProperty::Intensity), ("rotation", ImageLightProperty::Rotation)];

const CAMERA: [(&str, CameraProperty); 8] = [
    ("perspective/yfov", CameraProperty::FieldOfView),
    ("perspective/aspectRatio", CameraProperty::AspectRatio),
    ("perspective/znear", CameraProperty::ZNear),
    ("perspective/zfar", CameraProperty::ZFar),
    ("orthographic/xmag", CameraProperty::XMag),
    ("orthographic/ymag", CameraProperty::YMag),
    ("orthographic/znear", CameraProperty::ZNear),
    ("orthographic/zfar", CameraProperty::ZFar),
];

/// Properties without a default value. They can be animated only if the file gives them a value.
const NO_DEFAULT: [&str; 3] = ["aspectRatio", "zfar", "range"];

/// Objects whose properties have their default values where they are absent, which the object model counts as defined.
const MAY_BE_ABSENT: [&str; 6] = [
    "/pbrMetallicRoughness",
    "/extensions/KHR_materials_ior",
    "/extensions/KHR_materials_emissive_strength",
    "/extensions/KHR_materials_dispersion",
    "/extensions/KHR_texture_transform",
    "/extensions/KHR_node_visibility",
];

/// Resolves `pointer`. `None` if the file has no such property or the property is not supported.
pub(super) fn resolve(document: &Document, pointer: &str) -> Option<Property> {
    let pointer = &corrected(pointer);
    if let Some(property) = single_weight(document, pointer) {
        return Some(property);
    }
    let (owner, key) = pointer.rsplit_once('/')?;
    let owner = owner_at(document, owner)?;
    if !owner.value.is_object() || (NO_DEFAULT.contains(&key) && owner.field(key).is_none()) {
        return None;
    }
    let (array, rest) = pointer.strip_prefix('/')?.split_once('/')?;
    if array == "extensions" {
        return light_property(rest);
    }
    let (index, path) = split_index(rest)?;
    match array {
        "nodes" => node_property(NodeIndex(index), path),
        "meshes" if path == "weights" => Some(number(AnimationTarget::MeshWeights(MeshIndex(index)), 0, ANY)),
        "materials" => {
            let material = document.element("materials", index as usize)?;
            let replaced = material.extension(SPECULAR_GLOSSINESS).is_some()
                && (path.starts_with("pbrMetallicRoughness/")
                    || [IOR, SPECULAR].iter().any(|name| path.contains(name)));
            if replaced { None } else { material_property(MaterialIndex(index), path) }
        }
        "cameras" => {
            let property = find(&CAMERA, path)?;
            let range = if path == "perspective/znear" { POSITIVE } else { property.range() };
            Some(number(AnimationTarget::Camera(CameraIndex(index), property), 1, range))
        }
        _ => None,
    }
}

/// Corrects what the glTF exporter of Blender misspells: `spot.outerConeAngle` and `clearcoatRoughnessFactor `.
fn corrected(pointer: &str) -> String {
    pointer.trim_end_matches(' ').replace("/spot.", "/spot/")
}

/// The object at `pointer`, or the one that it would be in where it may be absent.
fn owner_at<'a>(document: &'a Document, pointer: &str) -> Option<Raw<'a>> {
    Raw::at(&document.value, pointer).or_else(|| {
        let outer = MAY_BE_ABSENT.iter().find_map(|absent| pointer.strip_suffix(absent))?;
        Raw::at(&document.value, outer)
    })
}

/// Splits off the index before the first slash.
fn split_index(text: &str) -> Option<(u32, &str)> {
    let (index, path) = text.split_once('/')?;
    Some((index.parse().ok()?, path))
}

fn find<T: Copy>(rows: &[(&str, T)], path: &str) -> Option<T> {
    rows.iter().find(|row| row.0 == path).map(|row| row.1)
}

fn number(target: AnimationTarget, components: usize, range: RangeInclusive<f32>) -> Property {
    Property { target, components, range, is_boolean: false }
}

/// Property of a punctual or an image-based light; `rest` is the pointer after `/extensions/`.
fn light_property(rest: &str) -> Option<Property> {
    let (extension, rest) = rest.split_once("/lights/")?;
    let (index, path) = split_index(rest)?;
    match extension {
        LIGHTS => {
            let property = find(&LIGHT, path)?;
            let target = AnimationTarget::Light(LightIndex(index), property);
            Some(number(target, property.width(), property.range()))
        }
        IMAGE_LIGHTS => {
            let property = find(&IMAGE_LIGHT, path)?;
            let target = AnimationTarget::ImageLight(ImageLightIndex(index), property);
            Some(number(target, property.width(), property.range()))
        }
        _ => None,
    }
}

/// A single morph weight of a node or a mesh. The file need not list the weights.
fn single_weight(document: &Document, pointer: &str) -> Option<Property> {
    let (owner, weight) = pointer.rsplit_once('/')?;
    let owner = owner.strip_suffix("/weights")?;
    let weight: u32 = weight.parse().ok().filter(|parsed: &u32| parsed.to_string() == weight)?;
    Raw::at(&document.value, owner)?;
    let (array, index) = owner.strip_prefix('/')?.split_once('/')?;
    let index = index.parse().ok()?;
    let target = match array {
        "nodes" => AnimationTarget::Weight(NodeIndex(index), weight),
        "meshes" => AnimationTarget::MeshWeight(MeshIndex(index), weight),
        _ => return None,
    };
    Some(number(target, 1, ANY))
}

fn node_property(node: NodeIndex, path: &str) -> Option<Property> {
    match path {
        "translation" => Some(number(AnimationTarget::Translation(node), 3, ANY)),
        "rotation" => Some(number(AnimationTarget::Rotation(node), 4, ANY)),
        "scale" => Some(number(AnimationTarget::Scale(node), 3, ANY)),
        "weights" => Some(number(AnimationTarget::Weights(node), 0, ANY)),
        "extensions/KHR_node_visibility/visible" => {
            Some(Property { is_boolean: true, ..number(AnimationTarget::Visibility(node), 1, ANY) })
        }
        _ => None,
    }
}

fn material_property(material: MaterialIndex, path: &str) -> Option<Property> {
    let property = find(&MATERIAL, path).or_else(|| {
        let (texture, key) = path.split_once("/extensions/KHR_texture_transform/")?;
        let slot = find(&TEXTURES, texture)?;
        match key {
            "offset" => Some(MaterialProperty::TextureOffset(slot)),
            "rotation" => Some(MaterialProperty::TextureRotation(slot)),
            "scale" => Some(MaterialProperty::TextureScale(slot)),
            _ => None,
        }
    })?;
    Some(number(AnimationTarget::Material(material, property), property.width(), property.range()))
}
