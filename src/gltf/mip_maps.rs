//! Mip maps of images, one set for each image and encoding.

use std::sync::Arc;

use super::context::Context;
use super::encoded_image::in_quotes;
use super::options::{ImageLoading, ImageSource};
use super::texture::TextureTable;
use crate::asset_cache::{ImageShape, SourceKey};
use crate::error::{Result, over_limit, readable_bytes};
use crate::scene::{Encoding, Image, ImageMips, MipLevel, Texels, mip_bytes, mip_levels, mip_working_bytes};

/// Computes the mip maps of `images` one image at a time, each in parallel; none of images without texels. Those that the cache keeps are
/// read.
pub(super) fn import(
    context: &mut Context,
    (images, keys): (&[Image], &[Option<SourceKey>]),
    textures: &TextureTable,
    source: ImageSource<'_>,
) -> Result<Vec<ImageMips>> {
    if source.loading != ImageLoading::Texels {
        return Ok(Vec::new());
    }
    let mut mips = vec![ImageMips::default(); images.len()];
    for &(index, encoding) in &textures.uses {
        let (Some(image), Some(image_mips)) = (images.get(index.index()), mips.get_mut(index.index())) else {
            continue;
        };
        // The encodings of an image are sorted, so Srgb comes before CoveredSrgb.
        if encoding == Encoding::CoveredSrgb && is_opaque(image) {
            image_mips.share(Encoding::Srgb, Encoding::CoveredSrgb);
            continue;
        }
        let used_before = context.used_bytes();
        let texel_bytes = match image.texels {
            Texels::Rgba8(_) => 4,
            Texels::Rgba16(_) => 8,
        };
        let kept = mip_bytes(image.width, image.height, texel_bytes);
        let working = mip_working_bytes(image.width, image.height);
        charge(context, image, textures.images.get(index.index()), kept.saturating_add(working))?;
        let key = keys.get(index.index()).copied().flatten();
        image_mips.set(encoding, Arc::from(levels(image, key, encoding, source)));
        context.release_temporaries(used_before, kept);
    }
    Ok(mips)
}

fn levels(
    image: &Image,
    key: Option<SourceKey>,
    encoding: Encoding,
    source: ImageSource<'_>,
) -> Vec<MipLevel> {
    let (Some(cache), Some(key)) = (source.cache, key) else { return mip_levels(image, encoding) };
    let shape = ImageShape::of(image);
    cache.mip_levels(key, shape, encoding).unwrap_or_else(|| {
        let levels = mip_levels(image, encoding);
        cache.store_mip_levels(key, shape, (encoding, &levels));
        levels
    })
}

fn charge(context: &mut Context, image: &Image, index: Option<&usize>, bytes: u64) -> Result<()> {
    let pointer = index.map_or_else(String::new, |index| format!("/images/{index}"));
    if bytes <= context.remaining_bytes() {
        return context.charge(bytes, &pointer);
    }
    let name = in_quotes(image.name.as_deref());
    let message = format!(
        "with {} for the mip maps of the image{name} of {}x{} texels the import needs {}",
        readable_bytes(bytes.into()),
        image.width,
        image.height,
        over_limit(context.used_bytes().saturating_add(bytes).into(), context.limit_bytes().into())
    );
    Err(context.over_memory(&pointer, message, Some("use smaller images")))
}

fn is_opaque(image: &Image) -> bool {
    match &image.texels {
        Texels::Rgba8(texels) => texels.iter().all(|texel| texel[3] == u8::MAX),
        Texels::Rgba16(texels) => texels.iter().all(|texel| texel[3] == u16::MAX),
    }
}
