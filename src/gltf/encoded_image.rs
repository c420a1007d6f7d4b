//! Encoded images: bytes from a file or a buffer view, recognised and measured by their headers.

use std::borrow::Cow;

use super::accessor::Data;
use super::context::Context;
use super::resources::Resources;
use super::uri;
use crate::error::Result;
use crate::image_file::{
    ImageFormat, ImageHeader, image_format, image_header, png_size_refusal, size_refusal,
};

/// Encoded image file in memory, with its parsed header.
pub(super) struct EncodedImage<'a> {
    pub(super) name: Option<String>,
    pub(super) pointer: String,
    pub(super) bytes: Cow<'a, [u8]>,
    pub(super) header: ImageHeader,
}

/// Reads the image `index` and its header.
pub(super) fn fetch<'a>(
    context: &mut Context,
    data: &Data<'a>,
    resources: &mut Resources,
    index: usize,
) -> Result<EncodedImage<'a>> {
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
    let file_name = image.uri.as_ref().filter(|uri| !uri::is_data(uri));
    let name = image.name.clone().or_else(|| file_name.cloned());
    let quoted = in_quotes(name.as_deref());
    match image_format(&bytes) {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Ktx2 => {}
        ImageFormat::Other(kind) => {
            let message =
                format!("the image{quoted} is {kind}, which is not supported; convert it to PNG or JPEG");
            return Err(context.unsupported(pointer, message));
        }
        ImageFormat::Unknown => {
            let message = format!("the image{quoted} is neither PNG, JPEG, WebP nor KTX2");
            return Err(context.invalid(pointer, message));
        }
    }
    if let Some(why) = png_size_refusal(&bytes) {
        return Err(context.refused(pointer, format!("the image{quoted} {why}")));
    }
    let header =
        image_header(&bytes).map_err(|why| context.invalid(&pointer, format!("the image{quoted} {why}")))?;
    if let Some(why) = size_refusal(&header, bytes.len()) {
        return Err(context.refused(pointer, format!("the image{quoted} {why}")));
    }
    Ok(EncodedImage { name, pointer, bytes, header })
}

/// ` "name"` for messages; empty for an unnamed image.
pub(super) fn in_quotes(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" \"{}\"", name.escape_debug()))
}
