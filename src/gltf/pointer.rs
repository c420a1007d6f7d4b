//! JSON pointers of animation channels, and the properties that they name.
//!
//! Source: the text of `KHR_animation_pointer` and the *glTF 2.0 Asset Object Model* (Khronos Group).

use std::ops::RangeInclusive;

use super::document::Document;
use super::extensions::{IMAGE_LIGHTS, IOR, LIGHTS, SPECULAR, SPECULAR_GLOSSINESS};
use super::raw::{ANY, Raw};
use crate::scene::{
    AnimationTarget, CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex,
    LightProperty, MaterialIndex, MaterialProperty, MeshIndex, NodeIndex, TextureSlot,
};

/// A property that clips may move, and what its values may be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) target: AnimationTarget,
    /// Components of a value; 0 where the file says elsewhere how many there are.
    pub(super) width: usize,
    /// What every component of a key must lie in.
    pub(super) range: RangeInclusive<f32>,
    /// Whether it is either true or false.
    pub(super) is_switch: bool,
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

const TEXTURES: [(&str, TextureSlot); 20] = [
    ("pbrMetallicRoughness/baseColorTexture", TextureSlot::BaseColor),
    ("pbrMetallicRoughness/metallicRoughnessTexture", TextureSlot::MetallicRoughness),
    ("normalTexture", TextureSlot::Normal),
    ("occlusionTexture", TextureSlot::Occlusion),
    ("emissiveTexture", TextureSlot::Emissive),
    ("extensions/KHR_materials_transmission/transmissionTexture", TextureSlot::Transmission),
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

/// Properties without a default, which a file must have to move them.
const NO_DEFAULT: [&str; 3] = ["aspectRatio", "zfar", "range"];

/// The property that `pointer` names; `None` where the file has no such property or it is not honoured.
pub(super) fn property(document: &Document, pointer: &str) -> Option<Property> {
    if let Some(property) = of_single_weight(document, pointer) {
        return Some(property);
    }
    let (owner, key) = pointer.rsplit_once('/')?;
    let owner = Raw::at(&document.value, owner)?;
    if !owner.value.is_object() || (NO_DEFAULT.contains(&key) && owner.field(key).is_none()) {
        return None;
    }
    let (array, rest) = pointer.strip_prefix('/')?.split_once('/')?;
    if array == "extensions" {
        return of_light(rest);
    }
    let (index, path) = numbered(rest)?;
    match array {
        "nodes" => of_node(NodeIndex(index), path),
        "meshes" if path == "weights" => Some(number(AnimationTarget::MeshWeights(MeshIndex(index)), 0, ANY)),
        "materials" => {
            let own = document.element("materials", index as usize)?;
            let replaced = own.extension(SPECULAR_GLOSSINESS).is_some()
                && (path.starts_with("pbrMetallicRoughness/")
                    || [IOR, SPECULAR].iter().any(|name| path.contains(name)));
            if replaced { None } else { of_material(MaterialIndex(index), path) }
        }
        "cameras" => {
            let property = found(&CAMERA, path)?;
            Some(number(AnimationTarget::Camera(CameraIndex(index), property), 1, property.range()))
        }
        _ => None,
    }
}

/// The index before the first slash and what follows it.
fn numbered(text: &str) -> Option<(u32, &str)> {
    let (index, path) = text.split_once('/')?;
    Some((index.parse().ok()?, path))
}

fn found<T: Copy>(rows: &[(&str, T)], path: &str) -> Option<T> {
    rows.iter().find(|row| row.0 == path).map(|row| row.1)
}

fn number(target: AnimationTarget, width: usize, range: RangeInclusive<f32>) -> Property {
    Property { target, width, range, is_switch: false }
}

/// Of a punctual or an image-based light; `rest` follows the root's extensions.
fn of_light(rest: &str) -> Option<Property> {
    let (extension, rest) = rest.split_once("/lights/")?;
    let (index, path) = numbered(rest)?;
    match extension {
        LIGHTS => {
            let property = found(&LIGHT, path)?;
            let target = AnimationTarget::Light(LightIndex(index), property);
            Some(number(target, property.width(), property.range()))
        }
        IMAGE_LIGHTS => {
            let property = found(&IMAGE_LIGHT, path)?;
            let target = AnimationTarget::ImageLight(ImageLightIndex(index), property);
            Some(number(target, property.width(), property.range()))
        }
        _ => None,
    }
}

/// One of the weights of a node or a mesh, which need not list them.
fn of_single_weight(document: &Document, pointer: &str) -> Option<Property> {
    let (owner, place) = pointer.rsplit_once('/')?;
    let owner = owner.strip_suffix("/weights")?;
    let place: u32 = place.parse().ok().filter(|parsed: &u32| parsed.to_string() == place)?;
    Raw::at(&document.value, owner)?;
    let (array, index) = owner.strip_prefix('/')?.split_once('/')?;
    let index = index.parse().ok()?;
    let target = match array {
        "nodes" => AnimationTarget::Weight(NodeIndex(index), place),
        "meshes" => AnimationTarget::MeshWeight(MeshIndex(index), place),
        _ => return None,
    };
    Some(number(target, 1, ANY))
}

fn of_node(node: NodeIndex, path: &str) -> Option<Property> {
    match path {
        "translation" => Some(number(AnimationTarget::Translation(node), 3, ANY)),
        "rotation" => Some(number(AnimationTarget::Rotation(node), 4, ANY)),
        "scale" => Some(number(AnimationTarget::Scale(node), 3, ANY)),
        "weights" => Some(number(AnimationTarget::Weights(node), 0, ANY)),
        "extensions/KHR_node_visibility/visible" => {
            Some(Property { is_switch: true, ..number(AnimationTarget::Visibility(node), 1, ANY) })
        }
        _ => None,
    }
}

fn of_material(material: MaterialIndex, path: &str) -> Option<Property> {
    let property = found(&MATERIAL, path).or_else(|| {
        let (texture, key) = path.split_once("/extensions/KHR_texture_transform/")?;
        let slot = found(&TEXTURES, texture)?;
        match key {
            "offset" => Some(MaterialProperty::TextureOffset(slot)),
            "rotation" => Some(MaterialProperty::TextureRotation(slot)),
            "scale" => Some(MaterialProperty::TextureScale(slot)),
            _ => None,
        }
    })?;
    Some(number(AnimationTarget::Material(material, property), property.width(), property.range()))
}
