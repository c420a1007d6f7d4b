//! Materials: the metallic-roughness model with all textures, and the supported material extensions.
//!
//! Source: glTF 2.0 specification, section 3.9 (materials); the texts of `KHR_materials_emissive_strength` and
//! `KHR_materials_unlit`. Submodules import the other extensions: `transmission` transmitted light, `specular` strength
//! and colour of reflections, `surface_extensions` coats and highlights. `texture_info` reads texture
//! references with parameters.

mod specular;
mod surface_extensions;
mod texture_info;
mod transmission;

use glam::{Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::extension_names::{EMISSIVE_STRENGTH, UNLIT};
use super::raw::{NOT_NEGATIVE, Raw, TOLERANCE};
use super::texture::TextureTable;
use crate::error::Result;
use crate::scene::{AlphaMode, Material};

use texture_info::{normal_texture, occlusion_texture};

pub(super) use transmission::{distance_or_infinite, ior_or_one};

/// Imports all materials and appends the default material.
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
        emissive: Vec3::from_array(emissive_factor(context, raw)?),
        emissive_texture: textures.reference(context, raw, "emissiveTexture")?,
        ..Material::default()
    };
    if let Some(pbr) = raw.field("pbrMetallicRoughness") {
        material.base_color = Vec4::from_array(pbr.units(context, "baseColorFactor", [1.0; 4])?);
        material.base_color_texture = textures.reference(context, &pbr, "baseColorTexture")?;
        material.metallic = pbr.unit(context, "metallicFactor", 1.0)?;
        material.roughness = pbr.unit(context, "roughnessFactor", 1.0)?;
        material.metallic_roughness_texture =
            textures.reference(context, &pbr, "metallicRoughnessTexture")?;
    }
    apply_core_extensions(context, &mut material, raw)?;
    transmission::apply(context, &mut material, raw, textures)?;
    specular::apply(context, &mut material, raw, textures)?;
    surface_extensions::apply(context, &mut material, raw, textures)?;
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

fn apply_core_extensions(context: &Context, material: &mut Material, raw: &Raw) -> Result<()> {
    if raw.extension_object(context, UNLIT)?.is_some() {
        material.unlit = true;
    }
    if let Some(extension) = raw.extension_object(context, EMISSIVE_STRENGTH)? {
        material.emissive_strength = extension.number(context, "emissiveStrength", 1.0, NOT_NEGATIVE)?;
    }
    Ok(())
}

/// Light may be brighter than 1, which the specification leaves to an extension.
fn emissive_factor(context: &mut Context, raw: &Raw) -> Result<[f32; 3]> {
    let factor: [f32; 3] = raw.numbers(context, "emissiveFactor", [0.0; 3], NOT_NEGATIVE)?;
    if let Some(beyond) = factor.into_iter().find(|&value| value > 1.0 + TOLERANCE) {
        let message = format!("is {beyond}, but must be at most 1; it is used as it is");
        context.warn(format!("{}/emissiveFactor", raw.pointer), message);
    }
    Ok(factor)
}

/// Number of texture coordinate sets that the textures of `material` need.
pub(super) fn uv_sets(material: &Material) -> usize {
    let sets = material.texture_refs().map(|reference| reference.uv_set);
    sets.max().map_or(0, |last| (last as usize).saturating_add(1))
}
