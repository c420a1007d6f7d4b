//! Strength and colour of reflections, and the older specular-glossiness model.
//!
//! Source: the texts of `KHR_materials_specular` and `KHR_materials_pbrSpecularGlossiness`. The latter is the former with
//! an index of refraction of 0, which takes the colour of the reflection along the normal as it is.

use glam::{Vec3, Vec4};

use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::extensions::{IOR, SPECULAR, SPECULAR_GLOSSINESS};
use crate::gltf::raw::{NOT_NEGATIVE, Raw, UNIT};
use crate::gltf::texture::TextureTable;
use crate::scene::{Glossiness, Material, Specular};

/// Applies the extensions of this file.
pub(super) fn apply(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<()> {
    if let Some(extension) = raw.extension_object(context, SPECULAR)? {
        material.specular = specular(context, &extension, textures)?;
    }
    if let Some(extension) = raw.extension_object(context, SPECULAR_GLOSSINESS)? {
        for other in [IOR, SPECULAR] {
            if let Some(other_value) = raw.extension(other) {
                let message = format!("{other} must not go with {SPECULAR_GLOSSINESS}; it is ignored here");
                context.warn(other_value.pointer, message);
            }
        }
        specular_glossiness(context, material, &extension, textures)?;
    }
    Ok(())
}

/// `None` where the extension leaves everything as it is.
fn specular(context: &mut Context, extension: &Raw, textures: &mut TextureTable) -> Result<Option<Specular>> {
    let specular = Specular {
        factor: extension.number(context, "specularFactor", 1.0, UNIT)?,
        texture: textures.reference(context, extension, "specularTexture")?,
        color: Vec3::from_array(extension.numbers(context, "specularColorFactor", [1.0; 3], NOT_NEGATIVE)?),
        color_texture: textures.reference(context, extension, "specularColorTexture")?,
    };
    let plain = Specular { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None };
    Ok((specular != plain || context.animates_properties).then_some(specular))
}

/// Takes the place of all that the metallic-roughness model says.
fn specular_glossiness(
    context: &mut Context,
    material: &mut Material,
    extension: &Raw,
    textures: &mut TextureTable,
) -> Result<()> {
    material.base_color = Vec4::from_array(extension.numbers(context, "diffuseFactor", [1.0; 4], UNIT)?);
    material.base_color_texture = textures.reference(context, extension, "diffuseTexture")?;
    let texture = textures.reference(context, extension, "specularGlossinessTexture")?;
    let color = extension.numbers(context, "specularFactor", [1.0; 3], UNIT)?;
    material.specular =
        Some(Specular { factor: 1.0, texture: None, color: Vec3::from_array(color), color_texture: texture });
    let factor = extension.number(context, "glossinessFactor", 1.0, UNIT)?;
    material.glossiness = Some(Glossiness { factor, texture });
    material.ior = 0.0;
    material.metallic = 0.0;
    material.roughness = 1.0 - factor;
    material.metallic_roughness_texture = None;
    Ok(())
}
