//! What an accessor declares, checked against its buffer view and that against its buffer, in 64-bit arithmetic that
//! cannot wrap and before any data is looked at.
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

/// Smallest and largest distance between elements that a buffer view may ask for, bytes.
const STRIDE_BYTES: std::ops::RangeInclusive<usize> = 4..=252;

/// A run of elements as an accessor declares it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) view: usize,
    pub(super) offset: u64,
    pub(super) count: u64,
    /// Whether the view's stride applies.
    strided: bool,
}

/// Checks every buffer, buffer view and accessor against what the file declares, used or not.
pub(super) fn check_all(context: &Context, document: &Document) -> Result<()> {
    let root = &document.root;
    for (i, buffer) in root.buffers.iter().enumerate() {
        if buffer.byte_length.0 == 0 {
            return Err(context.invalid(format!("/buffers/{i}/byteLength"), "must be at least 1"));
        }
    }
    for (i, view) in root.buffer_views.iter().enumerate() {
        let pointer = format!("/bufferViews/{i}");
        let buffer = context.subscript(
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
    // An unknown format is wrong only where it is used.
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
    if let Some(run) = base_run(accessor) {
        check_run(context, document, &run, &layout, pointer)?;
    }
    let Some(sparse) = &accessor.sparse else {
        return Ok(());
    };
    let pointer = format!("{pointer}/sparse");
    if sparse.count.0 == 0 || sparse.count.0 > accessor.count.0 {
        let message = format!("must lie between 1 and {}", accessor.count.0);
        return Err(context.invalid(format!("{pointer}/count"), message));
    }
    let (indices, index_type) = sparse_index_run(context, accessor, &pointer)?;
    let index_layout = ElementLayout::new(Type::Scalar, index_type);
    check_run(context, document, &indices, &index_layout, &format!("{pointer}/indices"))?;
    let Some(values) = sparse_value_run(accessor) else {
        return Ok(());
    };
    check_run(context, document, &values, &layout, &format!("{pointer}/values")).map(|_| ())
}

pub(super) fn base_run(accessor: &Accessor) -> Option<Run> {
    Some(Run {
        view: accessor.buffer_view?.value(),
        offset: accessor.byte_offset.map_or(0, |offset| offset.0),
        count: accessor.count.0,
        strided: true,
    })
}

pub(super) fn sparse_index_run(
    context: &Context,
    accessor: &Accessor,
    pointer: &str,
) -> Result<(Run, ComponentType)> {
    let wrong = || {
        let message = "must be 5121, 5123 or 5125";
        context.invalid(format!("{pointer}/indices/componentType"), message)
    };
    let sparse = accessor.sparse.as_ref().ok_or_else(wrong)?;
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err(wrong());
    };
    let run = Run {
        view: sparse.indices.buffer_view.value(),
        offset: sparse.indices.byte_offset.0,
        count: sparse.count.0,
        strided: false,
    };
    Ok((run, component.0))
}

pub(super) fn sparse_value_run(accessor: &Accessor) -> Option<Run> {
    let sparse = accessor.sparse.as_ref()?;
    Some(Run {
        view: sparse.values.buffer_view.value(),
        offset: sparse.values.byte_offset.0,
        count: sparse.count.0,
        strided: false,
    })
}

/// Checks that a run lies inside its view and returns the distance of its elements.
pub(super) fn check_run(
    context: &Context,
    document: &Document,
    run: &Run,
    layout: &ElementLayout,
    pointer: &str,
) -> Result<usize> {
    let views = &document.root.buffer_views;
    let index = context.subscript(run.view, views.len(), &format!("{pointer}/bufferView"), "buffer view")?;
    let view = views.get(index);
    let view_bytes = view.map_or(0, |view| view.byte_length.0);
    let stride = view
        .and_then(|view| view.byte_stride)
        .filter(|_| run.strided)
        .map_or(layout.packed_bytes, |stride| stride.0);
    if stride < layout.occupied_bytes {
        let message = format!(
            "has elements of {} bytes, but the buffer view's byteStride is {stride}",
            layout.occupied_bytes
        );
        return Err(context.invalid(pointer, message));
    }
    let end = run
        .count
        .checked_sub(1)
        .and_then(|steps| steps.checked_mul(stride as u64))
        .and_then(|bytes| bytes.checked_add(layout.occupied_bytes as u64))
        .and_then(|bytes| bytes.checked_add(run.offset));
    if end.is_none_or(|end| end > view_bytes) {
        let message = format!(
            "reaches past the end of buffer view {index}: {} elements from byte {} do not fit into {view_bytes} bytes",
            run.count, run.offset
        );
        return Err(context.invalid(pointer, message));
    }
    Ok(stride)
}
