//! Material extensions that add coats or change highlights: clear coat, sheen, iridescence, anisotropy.
//!
//! Source: the texts of `KHR_materials_clearcoat`, `KHR_materials_sheen`, `KHR_materials_iridescence` and
//! `KHR_materials_anisotropy`. An extension whose factor is zero has no effect and is dropped, unless it can be animated.

use glam::Vec3;

use super::texture_info::normal_texture;
use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::extension_names::{ANISOTROPY, CLEAR_COAT, IRIDESCENCE, SHEEN};
use crate::gltf::raw::{ANY, NOT_NEGATIVE, Raw};
use crate::gltf::texture::TextureTable;
use crate::scene::{Anisotropy, ClearCoat, Iridescence, Material, Sheen};

/// Applies the extensions of this module to `material`.
pub(super) fn apply(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<()> {
    if let Some(extension) = raw.extension_object(context, CLEAR_COAT)? {
        material.clear_coat = clear_coat(context, &extension, textures)?;
    }
    if let Some(extension) = raw.extension_object(context, SHEEN)? {
        material.sheen = sheen(context, &extension, textures)?;
    }
    if let Some(extension) = raw.extension_object(context, IRIDESCENCE)? {
        material.iridescence = iridescence(context, &extension, textures)?;
    }
    if let Some(extension) = raw.extension_object(context, ANISOTROPY)? {
        material.anisotropy = anisotropy(context, &extension, textures)?;
    }
    Ok(())
}

fn clear_coat(
    context: &mut Context,
    extension: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<ClearCoat>> {
    let coat = ClearCoat {
        factor: extension.unit(context, "clearcoatFactor", 0.0)?,
        texture: textures.reference(context, extension, "clearcoatTexture")?,
        roughness: extension.unit(context, "clearcoatRoughnessFactor", 0.0)?,
        roughness_texture: textures.reference(context, extension, "clearcoatRoughnessTexture")?,
        normal_texture: normal_texture(context, extension, "clearcoatNormalTexture", textures)?,
    };
    Ok((coat.factor > 0.0 || context.animates_properties).then_some(coat))
}

fn sheen(context: &mut Context, extension: &Raw, textures: &mut TextureTable) -> Result<Option<Sheen>> {
    let sheen = Sheen {
        color: Vec3::from_array(extension.units(context, "sheenColorFactor", [0.0; 3])?),
        color_texture: textures.reference(context, extension, "sheenColorTexture")?,
        roughness: extension.unit(context, "sheenRoughnessFactor", 0.0)?,
        roughness_texture: textures.reference(context, extension, "sheenRoughnessTexture")?,
    };
    Ok((sheen.color != Vec3::ZERO || context.animates_properties).then_some(sheen))
}

fn iridescence(
    context: &mut Context,
    extension: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<Iridescence>> {
    let film = Iridescence {
        factor: extension.unit(context, "iridescenceFactor", 0.0)?,
        texture: textures.reference(context, extension, "iridescenceTexture")?,
        ior: extension.number(context, "iridescenceIor", 1.3, 1.0..=f32::MAX)?,
        thickness_minimum_nm: extension.number(
            context,
            "iridescenceThicknessMinimum",
            100.0,
            NOT_NEGATIVE,
        )?,
        thickness_maximum_nm: extension.number(
            context,
            "iridescenceThicknessMaximum",
            400.0,
            NOT_NEGATIVE,
        )?,
        thickness_texture: textures.reference(context, extension, "iridescenceThicknessTexture")?,
    };
    Ok((film.factor > 0.0 || context.animates_properties).then_some(film))
}

fn anisotropy(
    context: &mut Context,
    extension: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<Anisotropy>> {
    let anisotropy = Anisotropy {
        strength: extension.unit(context, "anisotropyStrength", 0.0)?,
        rotation_radians: extension.number(context, "anisotropyRotation", 0.0, ANY)?,
        texture: textures.reference(context, extension, "anisotropyTexture")?,
    };
    Ok((anisotropy.strength > 0.0 || context.animates_properties).then_some(anisotropy))
}
