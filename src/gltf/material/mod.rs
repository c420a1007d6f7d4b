//! Materials: the metallic-roughness model with all textures, and the supported material extensions.
//!
//! Source: glTF 2.0 specification, section 3.9 (materials); the texts of `KHR_materials_emissive_strength` and
//! `KHR_materials_unlit`. Submodules import the other extensions: `transmission` transmitted light, `specular` strength
//! and colour of reflections, `surface_extensions` coats and highlights. `part_textures` reads texture
//! references, and leaves out those that the material does not keep.

mod part_textures;
mod specular;
mod surface_extensions;
mod transmission;

use glam::{Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::extension_names::{EMISSIVE_STRENGTH, SPECULAR_GLOSSINESS, UNLIT};
use super::raw::{NOT_NEGATIVE, Raw, TOLERANCE};
use super::texture::TextureTable;
use crate::error::Result;
use crate::scene::{AlphaMode, Material};

use part_textures::PartTextures;

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
        ..Material::default()
    };
    apply_core_extensions(context, &mut material, raw)?;
    let all = &mut PartTextures::new(textures);
    apply_core(context, &mut material, raw, all)?;
    // An unlit surface shows its base colour alone, which specular-glossiness replaces.
    let is_lit = !material.unlit;
    transmission::apply(context, &mut material, raw, &mut all.if_kept(is_lit))?;
    specular::apply(context, &mut material, raw, all)?;
    surface_extensions::apply(context, &mut material, raw, &mut all.if_kept(is_lit))?;
    Ok(material)
}

/// Reads what materials have without extensions.
fn apply_core(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<()> {
    // AOVs have the mapped normals of unlit surfaces, too.
    material.normal_texture = textures.normal_texture(context, raw, "normalTexture")?;
    let is_lit = !material.unlit;
    material.occlusion_texture = textures.if_kept(is_lit).occlusion_texture(context, raw)?;
    material.emissive_factor = Vec3::from_array(emissive_factor(context, raw)?);
    material.emissive = material.emissive_factor * material.emissive_strength;
    let emits = material.emissive != Vec3::ZERO || context.animates_properties;
    material.emissive_texture =
        textures.if_kept(is_lit && emits).reference(context, raw, "emissiveTexture")?;
    if let Some(pbr) = raw.field("pbrMetallicRoughness") {
        let mut base = textures.if_kept(raw.extension(SPECULAR_GLOSSINESS).is_none());
        material.base_color = Vec4::from_array(pbr.units(context, "baseColorFactor", [1.0; 4])?);
        material.base_color_texture = base.reference(context, &pbr, "baseColorTexture")?;
        material.metallic = pbr.unit(context, "metallicFactor", 1.0)?;
        material.roughness = pbr.unit(context, "roughnessFactor", 1.0)?;
        material.metallic_roughness_texture =
            base.if_kept(is_lit).reference(context, &pbr, "metallicRoughnessTexture")?;
    }
    Ok(())
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
