//! Decoded images of textures and image-based lights.

use std::cmp::Reverse;
use std::path::Path;

use rayon::prelude::*;

use super::accessor::Data;
use super::context::Context;
use super::encoded_image::{EncodedImage, fetch, in_quotes};
use super::image_budget;
use super::options::{ImageLoading, ImageSource};
use super::resources::Resources;
use super::texture::TextureTable;
use crate::asset_cache::{AssetCache, ImageShape, SourceKey};
use crate::error::{Error, Result};
use crate::image_file::{DecodedTexels, ImageHeader, decode_texels, image_format};
use crate::scene::{Image, StoredImage, Texels};

/// The images of textures, in their order.
pub(super) struct ImportedImages {
    pub(super) images: Vec<Image>,
    /// How they are stored.
    pub(super) stored: Vec<StoredImage>,
    /// What a cache knows them by; empty without texels.
    pub(super) keys: Vec<Option<SourceKey>>,
}

/// Imports the images of `textures` in their order, loaded as far as `source` says, and tells how they are stored. Decodes in
/// parallel.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    textures: &TextureTable,
    source: ImageSource<'_>,
) -> Result<ImportedImages> {
    let ImageSource { loading, cache } = source;
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
        let images = encoded.into_iter().map(without_texels).collect();
        return Ok(ImportedImages { images, stored, keys: Vec::new() });
    }
    for image in &encoded {
        context.charge(image.header.decoded_bytes, &image.pointer)?;
    }
    let path = context.path;
    // An image that takes long leaves the other threads without work if it is decoded last.
    let mut by_size: Vec<_> = encoded.into_iter().enumerate().collect();
    by_size.sort_by_key(|(_, image)| Reverse((image.header.decoded_bytes, image.bytes.len())));
    let each_in_turn = by_size.into_iter().par_bridge();
    let mut decoded: Vec<(usize, Result<_>)> =
        each_in_turn.map(|(index, image)| (index, decoded_image(path, image, cache))).collect();
    // The first error in the order of the file, independent of thread timing.
    decoded.sort_by_key(|(index, _)| *index);
    let decoded = decoded.into_iter().map(|(_, image)| image);
    let (images, keys) = decoded.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    Ok(ImportedImages { images, stored, keys })
}

/// Decodes an image, or takes its texels from the cache.
fn decoded_image(
    path: &Path,
    image: EncodedImage<'_>,
    cache: Option<&AssetCache>,
) -> Result<(Image, Option<SourceKey>)> {
    let ImageHeader { width, height, texel_bytes, .. } = image.header;
    let shape = ImageShape { width, height, is_deep: texel_bytes == 8 };
    let kept = cache.and_then(|cache| Some((cache, shape.key_of(&image.bytes)?)));
    let known = kept.and_then(|(cache, key)| cache.texels(key, shape));
    let is_known = known.is_some();
    let texels = match known {
        Some(texels) => Ok(texels),
        None => decode_texels(&image.bytes).map(|decoded| match decoded {
            DecodedTexels::Rgba8(texels) => Texels::Rgba8(texels),
            DecodedTexels::Rgba16(texels) => Texels::Rgba16(texels),
        }),
    };
    let texels = texels.map_err(|why| {
        let message = format!("the image{} {why}", in_quotes(image.name.as_deref()));
        Error::invalid(path, image.pointer, message)
    })?;
    if !is_known && let Some((cache, key)) = kept {
        cache.store_texels(key, shape, &texels);
    }
    Ok((Image { name: image.name, width, height, texels }, kept.map(|(_, key)| key)))
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
