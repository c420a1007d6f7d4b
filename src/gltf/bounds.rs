//! Bounds checks: accessors against their buffer views, buffer views against their buffers.
//!
//! All arithmetic is 64-bit and cannot wrap. The checks run before any data is read.
//!
//! Source: glTF 2.0 specification, sections 3.6.1.2 and 3.6.2 (buffer views, accessors, alignment, sparse accessors).

use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::component::ElementLayout;
use super::context::Context;
use super::document::Document;
use super::formats::Format;
use crate::error::Result;

/// Allowed range of `byteStride`, bytes.
const STRIDE_BYTES: std::ops::RangeInclusive<usize> = 4..=252;

/// Range of elements in a buffer view, as an accessor declares it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementRange {
    pub(super) view: usize,
    pub(super) offset: u64,
    pub(super) count: u64,
    /// Whether the stride of the view applies.
    strided: bool,
}

/// Checks every buffer, buffer view and accessor of the file, including those that nothing refers to.
pub(super) fn check_all(context: &Context, document: &Document) -> Result<()> {
    let root = &document.root;
    for (i, buffer) in root.buffers.iter().enumerate() {
        if buffer.byte_length.0 == 0 {
            return Err(context.invalid(format!("/buffers/{i}/byteLength"), "must be at least 1"));
        }
    }
    for (i, view) in root.buffer_views.iter().enumerate() {
        let pointer = format!("/bufferViews/{i}");
        let buffer = context.check_index(
            view.buffer.value(),
            root.buffers.len(),
            &format!("{pointer}/buffer"),
            "buffer",
        )?;
        let available = root.buffers.get(buffer).map_or(0, |buffer| buffer.byte_length.0);
        let end = view.byte_offset.map_or(0, |offset| offset.0).checked_add(view.byte_length.0);
        if view.byte_length.0 == 0 || end.is_none_or(|end| end > available) {
            let message = format!("does not fit into its buffer of {available} bytes");
            return Err(context.invalid(pointer, message));
        }
        if let Some(stride) = view.byte_stride.filter(|stride| !STRIDE_BYTES.contains(&stride.0)) {
            let message = format!("is {}, but must lie between 4 and 252", stride.0);
            return Err(context.invalid(format!("{pointer}/byteStride"), message));
        }
    }
    for (i, accessor) in root.accessors.iter().enumerate() {
        check_accessor(context, document, accessor, &format!("/accessors/{i}"))?;
    }
    Ok(())
}

fn check_accessor(context: &Context, document: &Document, accessor: &Accessor, pointer: &str) -> Result<()> {
    // An unknown format is an error only when the accessor is read.
    let Some(format) = Format::of(accessor) else {
        return Ok(());
    };
    if accessor.count.0 == 0 {
        return Err(context.invalid(format!("{pointer}/count"), "must be at least 1"));
    }
    if format.normalized && matches!(format.component, ComponentType::F32 | ComponentType::U32) {
        let message = "floats and 32-bit integers cannot be normalized";
        return Err(context.invalid(format!("{pointer}/normalized"), message));
    }
    let layout = ElementLayout::new(format.shape, format.component);
    if let Some(range) = base_elements(accessor) {
        check_element_range(context, document, &range, &layout, pointer)?;
    }
    let Some(sparse) = &accessor.sparse else {
        return Ok(());
    };
    let pointer = format!("{pointer}/sparse");
    if sparse.count.0 == 0 || sparse.count.0 > accessor.count.0 {
        let message = format!("must lie between 1 and {}", accessor.count.0);
        return Err(context.invalid(format!("{pointer}/count"), message));
    }
    let (indices, index_type) = sparse_indices(context, accessor, &pointer)?;
    let index_layout = ElementLayout::new(Type::Scalar, index_type);
    check_element_range(context, document, &indices, &index_layout, &format!("{pointer}/indices"))?;
    let Some(values) = sparse_values(accessor) else {
        return Ok(());
    };
    check_element_range(context, document, &values, &layout, &format!("{pointer}/values")).map(|_| ())
}

pub(super) fn base_elements(accessor: &Accessor) -> Option<ElementRange> {
    Some(ElementRange {
        view: accessor.buffer_view?.value(),
        offset: accessor.byte_offset.map_or(0, |offset| offset.0),
        count: accessor.count.0,
        strided: true,
    })
}

pub(super) fn sparse_indices(
    context: &Context,
    accessor: &Accessor,
    pointer: &str,
) -> Result<(ElementRange, ComponentType)> {
    let wrong = || {
        let message = "must be 5121, 5123 or 5125";
        context.invalid(format!("{pointer}/indices/componentType"), message)
    };
    let sparse = accessor.sparse.as_ref().ok_or_else(wrong)?;
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err(wrong());
    };
    let range = ElementRange {
        view: sparse.indices.buffer_view.value(),
        offset: sparse.indices.byte_offset.0,
        count: sparse.count.0,
        strided: false,
    };
    Ok((range, component.0))
}

pub(super) fn sparse_values(accessor: &Accessor) -> Option<ElementRange> {
    let sparse = accessor.sparse.as_ref()?;
    Some(ElementRange {
        view: sparse.values.buffer_view.value(),
        offset: sparse.values.byte_offset.0,
        count: sparse.count.0,
        strided: false,
    })
}

/// Checks that the elements lie inside their view. Returns their stride in bytes.
pub(super) fn check_element_range(
    context: &Context,
    document: &Document,
    range: &ElementRange,
    layout: &ElementLayout,
    pointer: &str,
) -> Result<usize> {
    let views = &document.root.buffer_views;
    let index =
        context.check_index(range.view, views.len(), &format!("{pointer}/bufferView"), "buffer view")?;
    let view = views.get(index);
    let view_bytes = view.map_or(0, |view| view.byte_length.0);
    let stride = view
        .and_then(|view| view.byte_stride)
        .filter(|_| range.strided)
        .map_or(layout.packed_bytes, |stride| stride.0);
    if stride < layout.occupied_bytes {
        let message = format!(
            "has elements of {} bytes, but the buffer view's byteStride is {stride}",
            layout.occupied_bytes
        );
        return Err(context.invalid(pointer, message));
    }
    let end = range
        .count
        .checked_sub(1)
        .and_then(|steps| steps.checked_mul(stride as u64))
        .and_then(|bytes| bytes.checked_add(layout.occupied_bytes as u64))
        .and_then(|bytes| bytes.checked_add(range.offset));
    if end.is_none_or(|end| end > view_bytes) {
        let message = format!(
            "reaches past the end of buffer view {index}: {} elements from byte {} do not fit into {view_bytes} bytes",
            range.count, range.offset
        );
        return Err(context.invalid(pointer, message));
    }
    Ok(stride)
}
