//! Material extensions that add coats or change highlights: clear coat, sheen, iridescence, anisotropy.
//!
//! Source: the texts of `KHR_materials_clearcoat`, `KHR_materials_sheen`, `KHR_materials_iridescence` and
//! `KHR_materials_anisotropy`. An extension whose factor is zero has no effect and is dropped, unless it can be animated.

use glam::Vec3;

use super::part_textures::PartTextures;
use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::extension_names::{ANISOTROPY, CLEAR_COAT, IRIDESCENCE, SHEEN};
use crate::gltf::raw::{ANY, AT_LEAST_ONE, NOT_NEGATIVE, Raw};
use crate::scene::{Anisotropy, ClearCoat, Iridescence, Material, Sheen};

/// Applies the extensions of this module to `material`.
pub(super) fn apply(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut PartTextures<'_, '_>,
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
    textures: &mut PartTextures<'_, '_>,
) -> Result<Option<ClearCoat>> {
    let factor = extension.unit(context, "clearcoatFactor", 0.0)?;
    let is_kept = factor > 0.0 || context.animates_properties;
    let mut textures = textures.if_kept(is_kept);
    let coat = ClearCoat {
        factor,
        texture: textures.reference(context, extension, "clearcoatTexture")?,
        roughness: extension.unit(context, "clearcoatRoughnessFactor", 0.0)?,
        roughness_texture: textures.reference(context, extension, "clearcoatRoughnessTexture")?,
        normal_texture: textures.normal_texture(context, extension, "clearcoatNormalTexture")?,
    };
    Ok(is_kept.then_some(coat))
}

fn sheen(
    context: &mut Context,
    extension: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<Option<Sheen>> {
    let color = Vec3::from_array(extension.units(context, "sheenColorFactor", [0.0; 3])?);
    let is_kept = color != Vec3::ZERO || context.animates_properties;
    let mut textures = textures.if_kept(is_kept);
    let sheen = Sheen {
        color,
        color_texture: textures.reference(context, extension, "sheenColorTexture")?,
        roughness: extension.unit(context, "sheenRoughnessFactor", 0.0)?,
        roughness_texture: textures.reference(context, extension, "sheenRoughnessTexture")?,
    };
    Ok(is_kept.then_some(sheen))
}

fn iridescence(
    context: &mut Context,
    extension: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<Option<Iridescence>> {
    let factor = extension.unit(context, "iridescenceFactor", 0.0)?;
    let is_kept = factor > 0.0 || context.animates_properties;
    let mut textures = textures.if_kept(is_kept);
    let film = Iridescence {
        factor,
        texture: textures.reference(context, extension, "iridescenceTexture")?,
        ior: extension.number(context, "iridescenceIor", 1.3, AT_LEAST_ONE)?,
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
    Ok(is_kept.then_some(film))
}

fn anisotropy(
    context: &mut Context,
    extension: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<Option<Anisotropy>> {
    let strength = extension.unit(context, "anisotropyStrength", 0.0)?;
    let is_kept = strength > 0.0 || context.animates_properties;
    let anisotropy = Anisotropy {
        strength,
        rotation_radians: extension.number(context, "anisotropyRotation", 0.0, ANY)?,
        texture: textures.if_kept(is_kept).reference(context, extension, "anisotropyTexture")?,
    };
    Ok(is_kept.then_some(anisotropy))
}
