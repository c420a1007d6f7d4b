//! Decoded images of textures and image-based lights.

use rayon::prelude::*;

use super::accessor::Data;
use super::context::Context;
use super::encoded_image::{EncodedImage, fetch, in_quotes};
use super::image_budget;
use super::options::ImageLoading;
use super::resources::Resources;
use super::texture::TextureTable;
use crate::error::{Error, Result};
use crate::image_file::{DecodedTexels, ImageHeader, decode_texels, image_format};
use crate::scene::{Image, StoredImage, Texels};

/// Imports the images of `textures` in their order, loaded as far as `loading` says, and tells how they are stored. Decodes in
/// parallel.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    textures: &TextureTable,
    loading: ImageLoading,
) -> Result<(Vec<Image>, Vec<StoredImage>)> {
    let mut encoded = Vec::new();
    for &index in &textures.images {
        encoded.push(fetch(context, data, resources, index)?);
    }
    let stored = encoded.iter().map(stored_image).collect();
    if loading != ImageLoading::Headers {
        let kept = image_budget::count(context, &encoded, textures)?;
        if loading == ImageLoading::Budget {
            context.charge(kept, "")?;
        }
    }
    if loading != ImageLoading::Texels {
        return Ok((encoded.into_iter().map(without_texels).collect(), stored));
    }
    for image in &encoded {
        context.charge(image.header.decoded_bytes, &image.pointer)?;
    }
    let context = &*context;
    let path = context.path;
    let decoded: Vec<Result<Image>> = encoded
        .into_par_iter()
        .map(|image| {
            let texels = decode_texels(&image.bytes).map_err(|why| {
                let message = format!("the image{} {why}", in_quotes(image.name.as_deref()));
                Error::invalid(path, image.pointer, message)
            })?;
            let texels = match texels {
                DecodedTexels::Rgba8(texels) => Texels::Rgba8(texels),
                DecodedTexels::Rgba16(texels) => Texels::Rgba16(texels),
            };
            Ok(Image { name: image.name, width: image.header.width, height: image.header.height, texels })
        })
        .collect();
    // The first error in the order of the file, independent of thread timing.
    Ok((decoded.into_iter().collect::<Result<_>>()?, stored))
}

fn stored_image(image: &EncodedImage<'_>) -> StoredImage {
    StoredImage { format: image_format(&image.bytes).name(), bytes: image.bytes.len() as u64 }
}

fn without_texels(image: EncodedImage<'_>) -> Image {
    let ImageHeader { width, height, texel_bytes, .. } = image.header;
    let texels = if texel_bytes == 8 { Texels::Rgba16(Vec::new()) } else { Texels::Rgba8(Vec::new()) };
    Image { name: image.name, width, height, texels }
}

/// Loads and decodes the image `index`.
pub(super) fn load(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    index: usize,
) -> Result<(ImageHeader, DecodedTexels)> {
    let image = fetch(context, data, resources, index)?;
    context.charge(image.header.decoded_bytes, &image.pointer)?;
    let texels = decode_texels(&image.bytes).map_err(|why| {
        context.invalid(image.pointer, format!("the image{} {why}", in_quotes(image.name.as_deref())))
    })?;
    Ok((image.header, texels))
}
