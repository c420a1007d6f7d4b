//! Materials: metallic-roughness with all textures, and the honoured material extensions.
//!
//! Source: glTF 2.0 specification, section 3.9 (materials); the texts of `KHR_materials_emissive_strength` and
//! `KHR_materials_unlit`. Other extensions have files of their own: `transmission` for light that passes through,
//! `specular` for the reflection's strength and colour, `layers` for what lies on the surface or shapes its highlight.

mod layers;
mod specular;
mod transmission;

use glam::{Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::extensions::{EMISSIVE_STRENGTH, UNLIT};
use super::raw::{ANY, NOT_NEGATIVE, Raw, UNIT};
use super::texture::TextureTable;
use crate::error::Result;
use crate::scene::{AlphaMode, Material, NormalTexture, OcclusionTexture};

/// Imports all materials and appends the default one.
pub(super) fn import(
    context: &mut Context,
    document: &Document,
    textures: &mut TextureTable,
) -> Result<Vec<Material>> {
    let mut materials = Vec::new();
    for (i, material) in document.root.materials.iter().enumerate() {
        if let Some(raw) = document.element("materials", i) {
            materials.push(import_material(context, material, &raw, textures)?);
        }
    }
    materials.push(Material::default());
    Ok(materials)
}

fn import_material(
    context: &mut Context,
    json: &json::Material,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<Material> {
    let mut material = Material {
        name: json.name.clone(),
        alpha_mode: alpha_mode(context, json, raw)?,
        double_sided: json.double_sided,
        normal_texture: normal_texture(context, raw, "normalTexture", textures)?,
        occlusion_texture: occlusion_texture(context, raw, textures)?,
        emissive: Vec3::from_array(raw.numbers(context, "emissiveFactor", [0.0; 3], UNIT)?),
        emissive_texture: textures.reference(context, raw, "emissiveTexture")?,
        ..Material::default()
    };
    if let Some(pbr) = raw.field("pbrMetallicRoughness") {
        material.base_color = Vec4::from_array(pbr.numbers(context, "baseColorFactor", [1.0; 4], UNIT)?);
        material.base_color_texture = textures.reference(context, &pbr, "baseColorTexture")?;
        material.metallic = pbr.number(context, "metallicFactor", 1.0, UNIT)?;
        material.roughness = pbr.number(context, "roughnessFactor", 1.0, UNIT)?;
        material.metallic_roughness_texture =
            textures.reference(context, &pbr, "metallicRoughnessTexture")?;
    }
    apply_own_extensions(context, &mut material, raw)?;
    transmission::apply(context, &mut material, raw, textures)?;
    specular::apply(context, &mut material, raw, textures)?;
    layers::apply(context, &mut material, raw, textures)?;
    material.emissive_factor = material.emissive;
    material.emissive *= material.emissive_strength;
    Ok(material)
}

fn alpha_mode(context: &Context, json: &json::Material, raw: &Raw) -> Result<AlphaMode> {
    let cutoff = raw.number(context, "alphaCutoff", 0.5, NOT_NEGATIVE)?;
    match json.alpha_mode {
        Checked::Valid(json::material::AlphaMode::Opaque) => Ok(AlphaMode::Opaque),
        Checked::Valid(json::material::AlphaMode::Mask) => Ok(AlphaMode::Mask { cutoff }),
        Checked::Valid(json::material::AlphaMode::Blend) => Ok(AlphaMode::Blend),
        Checked::Invalid => {
            Err(context.invalid(format!("{}/alphaMode", raw.pointer), "must be OPAQUE, MASK or BLEND"))
        }
    }
}

/// The normal map that is the member `key` of `raw`.
fn normal_texture(
    context: &mut Context,
    raw: &Raw,
    key: &str,
    textures: &mut TextureTable,
) -> Result<Option<NormalTexture>> {
    let (Some(texture), Some(info)) = (textures.reference(context, raw, key)?, raw.field(key)) else {
        return Ok(None);
    };
    let scale = info.number(context, "scale", 1.0, ANY)?;
    Ok(Some(NormalTexture { texture, scale }))
}

fn occlusion_texture(
    context: &mut Context,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<OcclusionTexture>> {
    let (Some(texture), Some(info)) =
        (textures.reference(context, raw, "occlusionTexture")?, raw.field("occlusionTexture"))
    else {
        return Ok(None);
    };
    let strength = info.number(context, "strength", 1.0, UNIT)?;
    Ok(Some(OcclusionTexture { texture, strength }))
}

fn apply_own_extensions(context: &Context, material: &mut Material, raw: &Raw) -> Result<()> {
    if raw.extension_object(context, UNLIT)?.is_some() {
        material.unlit = true;
    }
    if let Some(extension) = raw.extension_object(context, EMISSIVE_STRENGTH)? {
        material.emissive_strength = extension.number(context, "emissiveStrength", 1.0, NOT_NEGATIVE)?;
    }
    Ok(())
}

/// How many texture coordinate sets the textures of `material` need.
pub(super) fn uv_sets(material: &Material) -> usize {
    let sets = material.texture_refs().map(|reference| reference.uv_set);
    sets.max().map_or(0, |last| (last as usize).saturating_add(1))
}
