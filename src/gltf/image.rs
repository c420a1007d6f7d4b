//! Images that textures use, decoded in parallel.

use std::borrow::Cow;

use rayon::prelude::*;

use super::ImageNeed;
use super::accessor::Data;
use super::context::Context;
use super::image_budget;
use super::resources::Resources;
use super::texture::TextureTable;
use crate::error::Result;
use crate::image_file::{
    DecodedTexels, ImageHeader, ImageKind, decode_texels, image_header, image_kind, oversized_png,
    unjustified,
};
use crate::scene::{Image, Texels};

/// An image file in memory, its size known.
pub(super) struct Encoded<'a> {
    pub(super) name: Option<String>,
    pub(super) pointer: String,
    bytes: Cow<'a, [u8]>,
    pub(super) header: ImageHeader,
}

/// Fetches and decodes the images of `textures`, in their order, as far as they are needed.
pub(super) fn import(
    context: &mut Context,
    data: &Data,
    resources: &mut Resources,
    textures: &TextureTable,
    need: ImageNeed,
) -> Result<Vec<Image>> {
    let mut encoded = Vec::new();
    for &index in &textures.images {
        encoded.push(fetch(context, data, resources, index)?);
    }
    if need != ImageNeed::Headers {
        image_budget::check(context, &encoded, textures)?;
    }
    if need != ImageNeed::Texels {
        return Ok(encoded.into_iter().map(without_texels).collect());
    }
    for image in &encoded {
        context.charge(image.header.decoded_bytes, &image.pointer)?;
    }
    let context = &*context;
    let path = context.path;
    let decoded: Vec<_> = encoded
        .into_par_iter()
        .map(|image| {
            let texels = decode_texels(&image.bytes).map_err(|why| {
                let message = format!("the image{} {why}", in_quotes(image.name.as_deref()));
                crate::error::Error::invalid(path, image.pointer, message)
            })?;
            let texels = match texels {
                DecodedTexels::Rgba8(texels) => Texels::Rgba8(texels),
                DecodedTexels::Rgba16(texels) => Texels::Rgba16(texels),
            };
            Ok(Image { name: image.name, width: image.header.width, height: image.header.height, texels })
        })
        .collect();
    // The first error in the file's order, whichever thread met one first.
    decoded.into_iter().collect()
}

fn without_texels(image: Encoded<'_>) -> Image {
    let ImageHeader { width, height, texel_bytes, .. } = image.header;
    let texels = if texel_bytes == 8 { Texels::Rgba16(Vec::new()) } else { Texels::Rgba8(Vec::new()) };
    Image { name: image.name, width, height, texels }
}

/// Fetches and decodes the image `index` by itself.
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

fn fetch<'a>(
    context: &mut Context,
    data: &Data<'a>,
    resources: &mut Resources,
    index: usize,
) -> Result<Encoded<'a>> {
    let pointer = format!("/images/{index}");
    let Some(image) = data.document.root.images.get(index) else {
        return Err(context.invalid(pointer, "there is no such image"));
    };
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), None) => Cow::Owned(resources.fetch(context, uri, &format!("{pointer}/uri"))?),
        (None, Some(view)) => {
            let pointer = format!("{pointer}/bufferView");
            Cow::Borrowed(data.view_bytes(context, view.value(), &pointer)?)
        }
        (None, None) => return Err(context.invalid(pointer, "has neither a uri nor a bufferView")),
        (Some(_), Some(_)) => return Err(context.invalid(pointer, "has both a uri and a bufferView")),
    };
    let file_name = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    let name = image.name.clone().or_else(|| file_name.cloned());
    let quoted = in_quotes(name.as_deref());
    match image_kind(&bytes) {
        ImageKind::Png | ImageKind::Jpeg | ImageKind::WebP | ImageKind::Ktx2 => {}
        ImageKind::Other(kind) => {
            let message =
                format!("the image{quoted} is {kind}, which is not supported; convert it to PNG or JPEG");
            return Err(context.unsupported(pointer, message));
        }
        ImageKind::Unknown => {
            let message = format!("the image{quoted} is neither PNG, JPEG, WebP nor KTX2");
            return Err(context.invalid(pointer, message));
        }
    }
    if let Some(why) = oversized_png(&bytes) {
        return Err(context.refused(pointer, format!("the image{quoted} {why}")));
    }
    let header =
        image_header(&bytes).map_err(|why| context.invalid(&pointer, format!("the image{quoted} {why}")))?;
    if let Some(why) = unjustified(&header, bytes.len()) {
        return Err(context.refused(pointer, format!("the image{quoted} {why}")));
    }
    Ok(Encoded { name, pointer, bytes, header })
}

pub(super) fn in_quotes(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" \"{}\"", name.escape_debug()))
}
