//! Specular extensions: strength and colour of reflections, and the specular-glossiness model.
//!
//! Source: the texts of `KHR_materials_specular` and `KHR_materials_pbrSpecularGlossiness`. The second is expressed by the
//! first with an index of refraction of 0, for which the specular colour is the reflectance at normal incidence.

use glam::{Vec3, Vec4};

use super::part_textures::PartTextures;
use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::extension_names::{IOR, SPECULAR, SPECULAR_GLOSSINESS};
use crate::gltf::raw::{NOT_NEGATIVE, Raw};
use crate::scene::{Glossiness, Material, Specular};

/// Applies the extensions of this module to `material`.
pub(super) fn apply(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<()> {
    if let Some(extension) = raw.extension_object(context, SPECULAR)? {
        let is_replaced = raw.extension(SPECULAR_GLOSSINESS).is_some();
        let mut textures = textures.if_kept(!is_replaced && !material.unlit);
        material.specular = Some(specular(context, &extension, &mut textures)?);
    }
    if let Some(extension) = raw.extension_object(context, SPECULAR_GLOSSINESS)? {
        for other in [IOR, SPECULAR] {
            if let Some(other_value) = raw.extension(other) {
                let message =
                    format!("{other} must not be combined with {SPECULAR_GLOSSINESS}; it is ignored");
                context.warn(other_value.pointer, message);
            }
        }
        specular_glossiness(context, material, &extension, textures)?;
    }
    Ok(())
}

/// Reads the extension. Without values it has an effect, too: it decides the Fresnel curve of high indices of refraction.
fn specular(context: &mut Context, extension: &Raw, textures: &mut PartTextures<'_, '_>) -> Result<Specular> {
    Ok(Specular {
        factor: extension.unit(context, "specularFactor", 1.0)?,
        texture: textures.reference(context, extension, "specularTexture")?,
        color: Vec3::from_array(extension.numbers(context, "specularColorFactor", [1.0; 3], NOT_NEGATIVE)?),
        color_texture: textures.reference(context, extension, "specularColorTexture")?,
    })
}

/// Replaces the parameters of the metallic-roughness model.
fn specular_glossiness(
    context: &mut Context,
    material: &mut Material,
    extension: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<()> {
    material.base_color = Vec4::from_array(extension.units(context, "diffuseFactor", [1.0; 4])?);
    material.base_color_texture = textures.reference(context, extension, "diffuseTexture")?;
    let texture =
        textures.if_kept(!material.unlit).reference(context, extension, "specularGlossinessTexture")?;
    let color = extension.units(context, "specularFactor", [1.0; 3])?;
    material.specular =
        Some(Specular { factor: 1.0, texture: None, color: Vec3::from_array(color), color_texture: texture });
    let factor = extension.unit(context, "glossinessFactor", 1.0)?;
    material.glossiness = Some(Glossiness { factor, texture });
    material.ior = 0.0;
    material.metallic = 0.0;
    material.roughness = 1.0 - factor;
    material.metallic_roughness_texture = None;
    Ok(())
}
