//! Meshopt-compressed buffer views.
//!
//! Source: the texts of `KHR_meshopt_compression` and `EXT_meshopt_compression` (Khronos Group). The second is the first
//! without the colour filter and without version 1 of the attribute codec; both are read by the same code.
//!
//! Every compressed view is decompressed once, before anything reads it. Accessors then see the uncompressed contents.
//! An uncompressed fallback in the file is not read.

mod attributes;
mod filters;
mod indices;
mod reader;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use rayon::prelude::*;

use super::context::Context;
use super::document::Document;
use super::extension_names::{EXT_MESHOPT, KHR_MESHOPT};
use super::raw::Raw;
use crate::error::{Error, Result};

use filters::Filter;
use reader::Malformed;

/// Codec of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// Number and size of the elements of a stream.
#[derive(Clone, Copy, Debug)]
struct Layout {
    count: usize,
    /// Bytes of an element.
    stride: usize,
}

/// Compressed view, checked and charged to the memory budget.
struct CompressedView<'a> {
    /// Index of the buffer view that receives the decompressed bytes.
    view: usize,
    pointer: String,
    stream: &'a [u8],
    layout: Layout,
    mode: Mode,
    filter: Filter,
    output: Vec<u8>,
}

/// Decompresses all compressed buffer views, by view index. `None` for an uncompressed view.
pub(super) fn decompress_views(
    context: &mut Context,
    document: &Document,
    buffers: &[Option<Cow<'_, [u8]>>],
) -> Result<Vec<Option<Vec<u8>>>> {
    let mut compressed = Vec::new();
    let view_count = document.root.buffer_views.len();
    for view in 0..view_count {
        if let Some(raw) = extension_of(context, document, view)? {
            compressed.push(parse_view(context, document, buffers, view, &raw)?);
        }
    }
    let path = context.path;
    let decompressed: Vec<(usize, Result<Vec<u8>>)> =
        compressed.into_par_iter().map(|view| (view.view, decompress(view, path))).collect();
    let mut views: Vec<Option<Vec<u8>>> = vec![None; view_count];
    for (view, bytes) in decompressed {
        if let Some(slot) = views.get_mut(view) {
            *slot = Some(bytes?);
        }
    }
    Ok(views)
}

/// Whether buffer `index` is only a fallback for programs without support for the extension.
pub(super) fn is_fallback(document: &Document, index: usize) -> bool {
    let raw = document.element("buffers", index);
    [KHR_MESHOPT, EXT_MESHOPT].iter().any(|name| {
        let extension = raw.as_ref().and_then(|raw| raw.extension(name));
        extension.is_some_and(|extension| extension.value.get("fallback") == Some(&true.into()))
    })
}

/// The extension object of a buffer view.
fn extension_of<'a>(context: &Context, document: &'a Document, view: usize) -> Result<Option<Raw<'a>>> {
    let Some(raw) = document.element("bufferViews", view) else {
        return Ok(None);
    };
    match (raw.extension(KHR_MESHOPT), raw.extension(EXT_MESHOPT)) {
        (Some(_), Some(other)) => {
            Err(context.invalid(other.pointer, format!("cannot be used together with {KHR_MESHOPT}")))
        }
        (Some(raw), None) | (None, Some(raw)) => Ok(Some(raw)),
        (None, None) => Ok(None),
    }
}

fn parse_view<'a>(
    context: &mut Context,
    document: &Document,
    buffers: &'a [Option<Cow<'_, [u8]>>],
    view: usize,
    raw: &Raw,
) -> Result<CompressedView<'a>> {
    raw.expect_object(context)?;
    let required = |context: &Context, key: &str| -> Result<usize> {
        let missing = || context.invalid(format!("{}/{key}", raw.pointer), "is missing");
        raw.index(context, key)?.ok_or_else(missing)
    };
    let mode = mode(context, raw)?;
    let filter = filter(context, raw)?;
    let count = required(context, "count")?;
    let stride = required(context, "byteStride")?;
    let layout = Layout { count, stride };
    check_layout(context, raw, mode, filter, layout)?;

    // The view must have exactly the decompressed length.
    let view_bytes = document.root.buffer_views.get(view).map_or(0, |view| view.byte_length.0);
    let decompressed_bytes = (count as u64).saturating_mul(stride as u64);
    if decompressed_bytes != view_bytes {
        let message = format!(
            "{count} elements of {stride} bytes do not fill the {view_bytes} bytes of the buffer view"
        );
        return Err(context.invalid(&raw.pointer, message));
    }

    // Locate the stream.
    let buffer = required(context, "buffer")?;
    let pointer = format!("{}/buffer", raw.pointer);
    context.check_index(buffer, buffers.len(), &pointer, "buffer")?;
    let Some(Some(bytes)) = buffers.get(buffer) else {
        return Err(context.invalid(pointer, format!("buffer {buffer} has no data")));
    };
    let offset = raw.index(context, "byteOffset")?.unwrap_or(0);
    let length = required(context, "byteLength")?;
    let end = offset.checked_add(length);
    let Some(stream) = end.and_then(|end| bytes.get(offset..end)) else {
        let message = format!("extends past the {} bytes of buffer {buffer}", bytes.len());
        return Err(context.invalid(&raw.pointer, message));
    };
    let output = context.allocate(decompressed_bytes, &raw.pointer)?;
    Ok(CompressedView { view, pointer: raw.pointer.clone(), stream, layout, mode, filter, output })
}

fn mode(context: &Context, raw: &Raw) -> Result<Mode> {
    match raw.string(context, "mode")? {
        Some("ATTRIBUTES") => Ok(Mode::Attributes),
        Some("TRIANGLES") => Ok(Mode::Triangles),
        Some("INDICES") => Ok(Mode::Indices),
        _ => {
            let pointer = format!("{}/mode", raw.pointer);
            Err(context.invalid(pointer, "must be ATTRIBUTES, TRIANGLES or INDICES"))
        }
    }
}

fn filter(context: &Context, raw: &Raw) -> Result<Filter> {
    match raw.string(context, "filter")? {
        None | Some("NONE") => Ok(Filter::None),
        Some("OCTAHEDRAL") => Ok(Filter::Octahedral),
        Some("QUATERNION") => Ok(Filter::Quaternion),
        Some("EXPONENTIAL") => Ok(Filter::Exponential),
        Some("COLOR") => Ok(Filter::Color),
        Some(_) => {
            let message = "must be NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR";
            Err(context.invalid(format!("{}/filter", raw.pointer), message))
        }
    }
}

/// Checks count and stride as the specification requires.
fn check_layout(context: &Context, raw: &Raw, mode: Mode, filter: Filter, layout: Layout) -> Result<()> {
    let Layout { count, stride } = layout;
    let wrong = |key: &str, message: &str| Err(context.invalid(format!("{}/{key}", raw.pointer), message));
    match mode {
        Mode::Attributes if stride.checked_rem(4) != Some(0) || !(4..=256).contains(&stride) => {
            wrong("byteStride", "must be a multiple of 4 up to 256")
        }
        Mode::Triangles | Mode::Indices if stride != 2 && stride != 4 => {
            wrong("byteStride", "must be 2 or 4")
        }
        Mode::Triangles if count.checked_rem(3) != Some(0) => wrong("count", "must be a multiple of 3"),
        Mode::Triangles | Mode::Indices if filter != Filter::None => {
            wrong("filter", "must be NONE for indices")
        }
        _ if !filter.fits(stride) => wrong("filter", "does not support this byteStride"),
        _ => Ok(()),
    }
}

fn decompress(view: CompressedView, path: &std::path::Path) -> Result<Vec<u8>> {
    let CompressedView { pointer, stream, layout, mode, filter, mut output, .. } = view;
    decode(stream, mode, layout, &mut output)
        .map_err(|Malformed(why)| Error::invalid(path, pointer, format!("the compressed data {why}")))?;
    filter.apply(&mut output, layout.stride);
    Ok(output)
}

/// Decodes `count` elements of `stride` bytes and appends them to `output`, unfiltered.
fn decode(
    stream: &[u8],
    mode: Mode,
    layout: Layout,
    output: &mut Vec<u8>,
) -> std::result::Result<(), Malformed> {
    let Layout { count, stride } = layout;
    let mut emit = |index: u32| {
        let bytes = index.to_le_bytes();
        output.extend(bytes.get(..stride).unwrap_or_default());
    };
    match mode {
        Mode::Attributes => attributes::decode(stream, count, stride, output),
        Mode::Triangles => indices::decode_triangles(stream, count, &mut emit),
        Mode::Indices => indices::decode_sequence(stream, count, &mut emit),
    }
}
