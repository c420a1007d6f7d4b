//! The checked reader of accessors: every combination of component type, shape, stride, normalization, sparse
//! replacement and missing buffer view (zeros). Lengths are compared before anything is allocated.
//!
//! Source: glTF 2.0 specification, section 3.6 (binary data storage).

use std::collections::BTreeMap;

use gltf::json::Accessor;
use gltf::json::accessor::Type;

use super::bounds::{Run, base_run, check_run, sparse_index_run, sparse_value_run};
use super::component::{self, ElementLayout};
use super::context::Context;
use super::document::Document;
use super::formats::{Format, format_name};
use super::raw::escape;
use crate::error::{Error, Result};

/// The document with the content of its buffers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Data<'a> {
    pub(super) document: &'a Document,
    /// One a buffer.
    pub(super) buffers: &'a [Option<Vec<u8>>],
    /// One a buffer view: what compressed ones hold, `None` for those that lie in a buffer.
    pub(super) views: &'a [Option<Vec<u8>>],
    /// Accessors whose data comes from elsewhere than their buffer views.
    pub(super) replaced: &'a Replaced,
}

/// Tightly packed elements, by accessor.
pub(super) type Replaced = BTreeMap<usize, Vec<u8>>;

/// Elements at a fixed distance inside a buffer.
#[derive(Clone, Copy, Debug)]
struct Span<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Span<'a> {
    /// The bytes from element `i` on.
    fn element(&self, i: usize) -> &'a [u8] {
        i.checked_mul(self.stride).and_then(|start| self.bytes.get(start..)).unwrap_or_default()
    }
}

impl<'a> Data<'a> {
    /// The accessor `index`, which `pointer` asks for.
    pub(super) fn accessor(&self, context: &Context, index: usize, pointer: &str) -> Result<&'a Accessor> {
        let accessors = &self.document.root.accessors;
        context.subscript(index, accessors.len(), pointer, "accessor")?;
        accessors.get(index).ok_or_else(|| context.invalid(pointer, "there is no such accessor"))
    }

    /// The bytes of the buffer view `index`, which `pointer` asks for.
    pub(super) fn view_bytes(&self, context: &Context, index: usize, pointer: &str) -> Result<&'a [u8]> {
        let views = &self.document.root.buffer_views;
        context.subscript(index, views.len(), pointer, "buffer view")?;
        if let Some(Some(unpacked)) = self.views.get(index) {
            return Ok(unpacked);
        }
        let view = views.get(index);
        let buffer_index = view.map_or(0, |view| view.buffer.value());
        let Some(Some(buffer)) = self.buffers.get(buffer_index) else {
            return Err(self.no_data(context, index, buffer_index, pointer));
        };
        view.and_then(|view| {
            let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok()?;
            let length = usize::try_from(view.byte_length.0).ok()?;
            buffer.get(start..start.checked_add(length)?)
        })
        .ok_or_else(|| context.invalid(pointer, "its buffer view reaches past the end of the buffer"))
    }

    /// The error of a view into a buffer without data, which names the extension that may hold it instead.
    fn no_data(&self, context: &Context, view: usize, buffer: usize, pointer: &str) -> Error {
        let raw = self.document.element("bufferViews", view);
        let extensions = raw.as_ref().and_then(|raw| raw.value.get("extensions")?.as_object());
        match extensions.and_then(|extensions| extensions.keys().next()) {
            Some(name) => context.unsupported(
                format!("/bufferViews/{view}/extensions/{}", escape(name)),
                format!("the data is stored only by {name}, which is not supported; export it without"),
            ),
            None => context.invalid(pointer, format!("needs buffer {buffer}, which has no data")),
        }
    }

    fn span(&self, context: &Context, run: &Run, layout: &ElementLayout, pointer: &str) -> Result<Span<'a>> {
        let stride = check_run(context, self.document, run, layout, pointer)?;
        let bytes = self.view_bytes(context, run.view, pointer)?;
        let start = usize::try_from(run.offset).unwrap_or(usize::MAX);
        Ok(Span { bytes: bytes.get(start..).unwrap_or_default(), stride })
    }

    /// All elements of accessor `index` as floats; all are finite.
    pub(super) fn floats<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Vec<[f32; N]>> {
        let format = self.format(context, index, pointer)?;
        let decode = |bytes: &[u8]| component::float(bytes, format.component, format.normalized);
        let elements: Vec<[f32; N]> = self.elements(context, index, pointer, decode)?;
        let broken = elements.iter().position(|element| element.iter().any(|value| !value.is_finite()));
        match broken {
            None => Ok(elements),
            Some(i) => Err(context.invalid(
                format!("/accessors/{index}"),
                format!("element {i} is infinite or not a number; export the file anew"),
            )),
        }
    }

    /// All elements of accessor `index` as unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Vec<[u32; N]>> {
        let format = self.format(context, index, pointer)?;
        let decode = |bytes: &[u8]| component::unsigned(bytes, format.component);
        self.elements(context, index, pointer, decode)
    }

    fn format(&self, context: &Context, index: usize, pointer: &str) -> Result<Format> {
        Format::of(self.accessor(context, index, pointer)?).ok_or_else(|| {
            context.invalid(format!("/accessors/{index}"), "has an unknown componentType or type")
        })
    }

    fn elements<T: Copy + Default, const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>> {
        let accessor = self.accessor(context, index, pointer)?;
        let format = self.format(context, index, pointer)?;
        let pointer = format!("/accessors/{index}");
        let layout = ElementLayout::new(format.shape, format.component);
        if layout.offsets.len() != N {
            let message = format!("is {}, which does not fit its use", format_name(format));
            return Err(context.invalid(pointer, message));
        }
        let read = |bytes: &[u8]| -> [T; N] {
            let mut element = [T::default(); N];
            for (value, &offset) in element.iter_mut().zip(&layout.offsets) {
                *value = decode(bytes.get(offset..).unwrap_or_default());
            }
            element
        };

        // Read the base: from elsewhere, from the buffer, or zeros.
        let replaced = self.replaced.get(&index);
        let span = match (replaced, base_run(accessor)) {
            (Some(bytes), _) => Some(Span { bytes, stride: layout.packed_bytes }),
            (None, Some(run)) => Some(self.span(context, &run, &layout, &pointer)?),
            (None, None) => None,
        };
        let mut elements: Vec<[T; N]> = context.allocate(accessor.count.0, &pointer)?;
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        match span {
            Some(span) => elements.extend((0..count).map(|i| read(span.element(i)))),
            None => elements.resize(count, [T::default(); N]),
        }

        // Replace the sparse ones.
        if let Some(values) = sparse_value_run(accessor).filter(|_| replaced.is_none()) {
            let values = self.span(context, &values, &layout, &format!("{pointer}/sparse/values"))?;
            let targets = self.sparse_targets(context, accessor, &pointer)?;
            for (i, target) in targets.into_iter().enumerate() {
                if let Some(element) = elements.get_mut(target) {
                    *element = read(values.element(i));
                }
            }
        }
        Ok(elements)
    }

    /// The elements that sparse values replace, strictly increasing and in range.
    fn sparse_targets(&self, context: &Context, accessor: &Accessor, pointer: &str) -> Result<Vec<usize>> {
        let pointer = format!("{pointer}/sparse");
        let (run, component) = sparse_index_run(context, accessor, &pointer)?;
        let layout = ElementLayout::new(Type::Scalar, component);
        let pointer = format!("{pointer}/indices");
        let span = self.span(context, &run, &layout, &pointer)?;
        let count = usize::try_from(run.count).unwrap_or(usize::MAX);
        let targets: Vec<usize> =
            (0..count).map(|i| component::unsigned(span.element(i), component) as usize).collect();
        if !targets.is_sorted_by(|a, b| a < b) {
            return Err(context.invalid(pointer, "are not strictly increasing"));
        }
        match targets.last() {
            Some(&last) if last as u64 >= accessor.count.0 => {
                Err(context.invalid(pointer, format!("replace element {last} of {}", accessor.count.0)))
            }
            _ => Ok(targets),
        }
    }
}
