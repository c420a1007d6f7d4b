//! Transmission extensions: index of refraction, transmission, volume, dispersion and diffuse transmission.
//!
//! Source: the texts of `KHR_materials_ior`, `KHR_materials_transmission`, `KHR_materials_volume`,
//! `KHR_materials_dispersion` and `KHR_materials_diffuse_transmission`.

use glam::Vec3;

use super::part_textures::PartTextures;
use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::extension_names::{DIFFUSE_TRANSMISSION, DISPERSION, IOR, TRANSMISSION, VOLUME};
use crate::gltf::raw::{NOT_NEGATIVE, Raw};
use crate::scene::{DiffuseTransmission, Material, Transmission, Volume};

/// Applies the extensions of this module to `material`.
pub(super) fn apply(
    context: &mut Context,
    material: &mut Material,
    raw: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<()> {
    if let Some(extension) = raw.extension_object(context, IOR)? {
        let ior = extension.number(context, "ior", 1.5, NOT_NEGATIVE)?;
        material.ior = ior_or_one(context, ior, &format!("{}/ior", extension.pointer));
    }
    if let Some(extension) = raw.extension_object(context, TRANSMISSION)? {
        let factor = extension.unit(context, "transmissionFactor", 0.0)?;
        let is_kept = factor > 0.0 || context.animates_properties;
        let texture = textures.if_kept(is_kept).reference(context, &extension, "transmissionTexture")?;
        material.transmission = is_kept.then_some(Transmission { factor, texture });
    }
    if let Some(extension) = raw.extension_object(context, VOLUME)? {
        material.volume = volume(context, &extension)?;
    }
    if let Some(extension) = raw.extension_object(context, DISPERSION)? {
        material.dispersion = extension.number(context, "dispersion", 0.0, NOT_NEGATIVE)?;
    }
    if let Some(extension) = raw.extension_object(context, DIFFUSE_TRANSMISSION)? {
        material.diffuse_transmission = diffuse_transmission(context, &extension, textures)?;
    }
    Ok(())
}

/// An index of refraction, which is taken for 1 where it lies between 0 and 1, with a warning. 0 means no Fresnel effect.
pub(in crate::gltf) fn ior_or_one(context: &mut Context, ior: f32, pointer: &str) -> f32 {
    if ior > 0.0 && ior < 1.0 {
        let message = format!("is {ior}, but must be 0 or at least 1; it is taken for 1");
        context.warn(pointer, message);
        return 1.0;
    }
    ior
}

/// An attenuation distance. 0 is taken for infinite, with a warning: three.js wrote it for a volume that absorbs nothing.
pub(in crate::gltf) fn distance_or_infinite(context: &mut Context, distance: f32, pointer: &str) -> f32 {
    if distance > 0.0 {
        return distance;
    }
    context.warn(pointer, "is 0, but must be greater; it is taken for infinite");
    f32::INFINITY
}

/// Reads the volume. `None` if its thickness is zero and cannot be animated. The ray tracer measures the thickness itself,
/// so the value and its texture are not used otherwise.
fn volume(context: &mut Context, extension: &Raw) -> Result<Option<Volume>> {
    let thickness = extension.number(context, "thicknessFactor", 0.0, NOT_NEGATIVE)?;
    let color = extension.units(context, "attenuationColor", [1.0; 3])?;
    let distance = match extension.distance(context, "attenuationDistance", NOT_NEGATIVE)? {
        Some(distance) => {
            let pointer = format!("{}/attenuationDistance", extension.pointer);
            distance_or_infinite(context, distance, &pointer)
        }
        None => f32::INFINITY,
    };
    Ok((thickness > 0.0 || context.animates_properties).then_some(Volume {
        thickness,
        attenuation_distance: distance,
        attenuation_color: Vec3::from_array(color),
    }))
}

fn diffuse_transmission(
    context: &mut Context,
    extension: &Raw,
    textures: &mut PartTextures<'_, '_>,
) -> Result<Option<DiffuseTransmission>> {
    let factor = extension.unit(context, "diffuseTransmissionFactor", 0.0)?;
    let color = extension.units(context, "diffuseTransmissionColorFactor", [1.0; 3])?;
    let is_kept = factor > 0.0 || context.animates_properties;
    let mut textures = textures.if_kept(is_kept);
    let texture = textures.reference(context, extension, "diffuseTransmissionTexture")?;
    let color_texture = textures.reference(context, extension, "diffuseTransmissionColorTexture")?;
    Ok(is_kept.then_some(DiffuseTransmission {
        factor,
        texture,
        color: Vec3::from_array(color),
        color_texture,
    }))
}
