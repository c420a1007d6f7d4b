//! Image-based lights: specular cube maps and spherical harmonics of the irradiance.
//!
//! Source: the text of `EXT_lights_image_based`. Images with alpha are RGBD: linear colours are divided by alpha. Images
//! without alpha are plain sRGB.

use glam::Vec3;

use super::accessor::Data;
use super::context::Context;
use super::extension_names::IMAGE_LIGHTS;
use super::image;
use super::raw::{ANY, NOT_NEGATIVE, Raw};
use super::resources::Resources;
use super::rotation::unit_rotation;
use crate::color::{srgb8_to_linear, srgb16_to_linear};
use crate::error::Result;
use crate::image_file::DecodedTexels;
use crate::scene::{CubeLevel, ImageLight, ImageLightIndex, image_bytes_for_cube};

/// Largest cube edge, texels.
const MAX_TEXELS: usize = 4096;

/// Imports all image-based lights. Their faces stay with the scene. The equirectangular image that a render samples in place of one light is
/// reserved, and counted with the environment of the frames.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
) -> Result<Vec<ImageLight>> {
    let Some(extension) = Raw::at(&data.document.value, format!("/extensions/{IMAGE_LIGHTS}")) else {
        return Ok(Vec::new());
    };
    extension.expect_object(context)?;
    let Some(lights) = extension.field("lights") else {
        return Err(context.invalid(format!("{}/lights", extension.pointer), "is missing"));
    };
    let raw_lights = lights.elements(context)?;
    let used_before = context.used_bytes();
    let imported: Result<Vec<ImageLight>> =
        raw_lights.iter().map(|light| import_light(context, data, resources, light)).collect();
    let imported = imported?;
    context.keep_since(used_before);
    let sizes = imported.iter().filter_map(|light| Some(light.levels.first()?.size));
    context.charge(sizes.map(image_bytes_for_cube).max().unwrap_or(0), &lights.pointer)?;
    Ok(imported)
}

/// The image-based light of the scene `raw`; the file has `count` lights.
pub(super) fn of_scene(context: &Context, raw: &Raw, count: usize) -> Result<Option<ImageLightIndex>> {
    Ok(raw.extension_light(context, IMAGE_LIGHTS, count, "image-based light")?.map(ImageLightIndex::of))
}

fn import_light(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    raw: &Raw,
) -> Result<ImageLight> {
    raw.expect_object(context)?;
    let rotation = raw.numbers(context, "rotation", [0.0, 0.0, 0.0, 1.0], ANY)?;
    let Some((rotation, _)) = unit_rotation(rotation) else {
        let message = "is a quaternion of length zero, which is not a rotation";
        return Err(context.invalid(format!("{}/rotation", raw.pointer), message));
    };
    Ok(ImageLight {
        name: raw.string(context, "name")?.map(str::to_owned),
        intensity: raw.number(context, "intensity", 1.0, NOT_NEGATIVE)?,
        rotation,
        irradiance: irradiance(context, raw)?,
        levels: levels(context, data, resources, raw)?,
    })
}

fn irradiance(context: &Context, raw: &Raw) -> Result<[Vec3; 9]> {
    let pointer = format!("{}/irradianceCoefficients", raw.pointer);
    let Some(list) = raw.field("irradianceCoefficients") else {
        return Err(context.invalid(pointer, "is missing"));
    };
    let rows = list.elements(context)?;
    if rows.len() != 9 {
        return Err(context.invalid(pointer, "must have nine coefficients"));
    }
    let mut coefficients = [Vec3::ZERO; 9];
    for (coefficient, row) in coefficients.iter_mut().zip(&rows) {
        *coefficient = Vec3::from_array(row.array(context, ANY)?);
    }
    Ok(coefficients)
}

fn levels(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    raw: &Raw,
) -> Result<Vec<CubeLevel>> {
    let size = raw.index(context, "specularImageSize")?.unwrap_or(0);
    if !size.is_power_of_two() || size > MAX_TEXELS {
        let message = format!("must be a power of two up to {MAX_TEXELS}");
        return Err(context.invalid(format!("{}/specularImageSize", raw.pointer), message));
    }
    let pointer = format!("{}/specularImages", raw.pointer);
    let Some(list) = raw.field("specularImages") else {
        return Err(context.invalid(pointer, "is missing"));
    };
    let rows = list.elements(context)?;
    if rows.is_empty() || rows.len() > (size.ilog2() as usize).saturating_add(1) {
        return Err(context
            .invalid(pointer, "must have at least one level, and at most one for each halving of the size"));
    }
    let mut levels = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let size = u32::try_from(size.checked_shr(u32::try_from(i).unwrap_or(32)).unwrap_or(0)).unwrap_or(0);
        let indices = row.elements(context)?;
        let [px, nx, py, ny, pz, nz] = indices.as_slice() else {
            return Err(context.invalid(&row.pointer, "must list six images"));
        };
        let mut face = |raw: &Raw| face(context, data, resources, raw, size);
        levels.push(CubeLevel {
            size,
            faces: [face(px)?, face(nx)?, face(py)?, face(ny)?, face(pz)?, face(nz)?],
        });
    }
    Ok(levels)
}

fn face(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    raw: &Raw,
    size: u32,
) -> Result<Vec<[f32; 3]>> {
    let index = raw.value.as_u64().and_then(|index| usize::try_from(index).ok());
    let Some(index) = index else {
        return Err(context.invalid(&raw.pointer, "must be a non-negative integer"));
    };
    context.check_index(index, data.document.root.images.len(), &raw.pointer, "image")?;
    let used_before = context.used_bytes();
    let (header, texels) = image::load(context, data, resources, index)?;
    if (header.width, header.height) != (size, size) {
        let message = format!("the image has {}x{} texels, not {size}x{size}", header.width, header.height);
        return Err(context.invalid(&raw.pointer, message));
    }
    let count = u64::from(size).saturating_mul(u64::from(size));
    let mut pixels = context.allocate(count, &raw.pointer)?;
    match texels {
        DecodedTexels::Rgba8(texels) => pixels.extend(texels.into_iter().map(|[r, g, b, d]| {
            let divisor = if d == 0 { 1.0 } else { f32::from(d) } / 255.0;
            [r, g, b].map(|channel| srgb8_to_linear(channel) / divisor)
        })),
        DecodedTexels::Rgba16(texels) => pixels.extend(texels.into_iter().map(|[r, g, b, d]| {
            let divisor = if d == 0 { 1.0 } else { f32::from(d) } / 65535.0;
            [r, g, b].map(|channel| srgb16_to_linear(channel) / divisor)
        })),
    }
    context.release_temporaries(used_before, count.saturating_mul(size_of::<[f32; 3]>() as u64));
    Ok(pixels)
}
