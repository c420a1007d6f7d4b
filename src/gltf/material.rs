//! Materials: metallic-roughness with all textures, and the honoured material extensions.
//!
//! Source: glTF 2.0 specification, section 3.9 (materials); the texts of `KHR_materials_emissive_strength`,
//! `KHR_materials_ior`, `KHR_materials_transmission`, `KHR_materials_unlit` and `KHR_materials_volume`.

use glam::{Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::extensions::{EMISSIVE_STRENGTH, IOR, TRANSMISSION, UNLIT, VOLUME};
use super::raw::{ANY, NOT_NEGATIVE, Raw, UNIT};
use super::texture::TextureTable;
use crate::error::Result;
use crate::scene::{AlphaMode, Material, NormalTexture, OcclusionTexture, TextureRef, Transmission, Volume};

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
        normal_texture: normal_texture(context, raw, textures)?,
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
    apply_extensions(context, &mut material, raw, textures)?;
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

fn normal_texture(
    context: &mut Context,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<NormalTexture>> {
    let (Some(texture), Some(info)) =
        (textures.reference(context, raw, "normalTexture")?, raw.field("normalTexture"))
    else {
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

fn apply_extensions(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<()> {
    if let Some(extension) = raw.extension(UNLIT) {
        extension.expect_object(context)?;
        material.unlit = true;
    }
    if let Some(extension) = raw.extension(EMISSIVE_STRENGTH) {
        extension.expect_object(context)?;
        material.emissive_strength = extension.number(context, "emissiveStrength", 1.0, NOT_NEGATIVE)?;
    }
    if let Some(extension) = raw.extension(IOR) {
        extension.expect_object(context)?;
        material.ior = extension.number(context, "ior", 1.5, NOT_NEGATIVE)?;
        if material.ior > 0.0 && material.ior < 1.0 {
            let message = format!("is {}, but must be 0 or at least 1", material.ior);
            return Err(context.invalid(format!("{}/ior", extension.pointer), message));
        }
    }
    if let Some(extension) = raw.extension(TRANSMISSION) {
        extension.expect_object(context)?;
        let factor = extension.number(context, "transmissionFactor", 0.0, UNIT)?;
        let texture = textures.reference(context, &extension, "transmissionTexture")?;
        material.transmission =
            (factor > 0.0 || context.animates_properties).then_some(Transmission { factor, texture });
    }
    if let Some(extension) = raw.extension(VOLUME) {
        material.volume = volume(context, &extension)?;
    }
    Ok(())
}

/// The volume, unless its thickness is zero. A ray tracer measures the thickness itself, so neither the number nor
/// its texture matters beyond that.
fn volume(context: &Context, extension: &Raw) -> Result<Option<Volume>> {
    extension.expect_object(context)?;
    let thickness = extension.number(context, "thicknessFactor", 0.0, NOT_NEGATIVE)?;
    let color = extension.numbers(context, "attenuationColor", [1.0; 3], UNIT)?;
    let distance = match extension.field("attenuationDistance") {
        Some(_) => extension.number(context, "attenuationDistance", 1.0, NOT_NEGATIVE)?,
        None => f32::INFINITY,
    };
    if distance == 0.0 {
        let pointer = format!("{}/attenuationDistance", extension.pointer);
        return Err(context.invalid(pointer, "must be greater than 0"));
    }
    Ok((thickness > 0.0)
        .then_some(Volume { attenuation_distance: distance, attenuation_color: Vec3::from_array(color) }))
}

/// How many texture coordinate sets the textures of `material` need.
pub(super) fn uv_sets(material: &Material) -> usize {
    let references: [Option<&TextureRef>; 6] = [
        material.base_color_texture.as_ref(),
        material.metallic_roughness_texture.as_ref(),
        material.normal_texture.as_ref().map(|normal| &normal.texture),
        material.occlusion_texture.as_ref().map(|occlusion| &occlusion.texture),
        material.emissive_texture.as_ref(),
        material.transmission.as_ref().and_then(|t| t.texture.as_ref()),
    ];
    let sets = references.into_iter().flatten().map(|reference| reference.uv_set);
    sets.max().map_or(0, |last| (last as usize).saturating_add(1))
}
