//! Accessor reader: decodes accessors into floats or unsigned integers, checked against the buffers.
//!
//! It handles every combination of component type, element type, stride, normalization and sparse substitution.
//! An accessor without a buffer view is zero. Lengths are checked before memory is allocated.
//!
//! Source: glTF 2.0 specification, section 3.6 (binary data storage).

use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::BTreeMap;

use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};

use super::bounds::{ElementRange, base_elements, check_element_range, sparse_indices, sparse_values};
use super::component::{self, ElementLayout};
use super::context::Context;
use super::document::Document;
use super::extremes::check_extremes;
use super::fill::fill_blocks;
use super::formats::{Format, format_name};
use super::raw::escape;
use super::scan::first_wrong;
use crate::error::{Error, Result};

/// Document together with the contents of its buffers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Data<'a> {
    pub(super) document: &'a Document,
    /// Contents of each buffer; `None` for a buffer without data.
    pub(super) buffers: &'a [Option<Cow<'a, [u8]>>],
    /// Decompressed contents of each buffer view; `None` for an uncompressed view.
    pub(super) views: &'a [Option<Vec<u8>>],
    /// Accessors whose elements were decoded from a compressed stream.
    pub(super) decoded: &'a DecodedAccessors,
    /// The elements that are read, by index in increasing order; `None` for all.
    pub(super) vertices: Option<&'a [u32]>,
}

/// Elements of one parallel task.
const ELEMENTS_PER_TASK: usize = 16_384;

/// Tightly packed elements by accessor index.
pub(super) type DecodedAccessors = BTreeMap<usize, Vec<u8>>;

/// Bytes of a buffer with one element every `stride` bytes.
#[derive(Clone, Copy, Debug)]
struct StridedElements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> StridedElements<'a> {
    /// The bytes that start at element `i`.
    fn element(&self, i: usize) -> &'a [u8] {
        i.checked_mul(self.stride).and_then(|start| self.bytes.get(start..)).unwrap_or_default()
    }
}

/// Indices of the elements that sparse values replace, in increasing order.
struct SparseTargets<'a> {
    indices: StridedElements<'a>,
    component: ComponentType,
    count: usize,
}

impl SparseTargets<'_> {
    /// The element that the value `i` replaces.
    fn target(&self, i: usize) -> u32 {
        component::unsigned(self.indices.element(i), self.component)
    }

    /// The value that replaces the element `target`.
    fn find(&self, target: u32) -> Option<usize> {
        let (mut first, mut end) = (0, self.count);
        while first < end {
            let middle = usize::midpoint(first, end);
            match self.target(middle).cmp(&target) {
                Ordering::Less => first = middle.saturating_add(1),
                Ordering::Equal => return Some(middle),
                Ordering::Greater => end = middle,
            }
        }
        None
    }
}

/// Whether a component is infinite or not a number.
fn is_wrong<const N: usize>(element: &[f32; N]) -> bool {
    element.iter().fold(false, |any, value| any | !value.is_finite())
}

/// The elements at `indices`.
fn at_indices<T: Copy>(elements: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().filter_map(|&index| elements.get(index as usize)).copied().collect()
}

impl<'a> Data<'a> {
    /// Data of which all elements are read.
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a [Option<Cow<'a, [u8]>>],
        views: &'a [Option<Vec<u8>>],
        decoded: &'a DecodedAccessors,
    ) -> Self {
        Self { document, buffers, views, decoded, vertices: None }
    }

    /// Returns accessor `index`; `pointer` is the JSON pointer of the reference to it.
    pub(super) fn accessor(&self, context: &Context, index: usize, pointer: &str) -> Result<&'a Accessor> {
        let accessors = &self.document.root.accessors;
        context.check_index(index, accessors.len(), pointer, "accessor")?;
        accessors.get(index).ok_or_else(|| context.invalid(pointer, "there is no such accessor"))
    }

    /// Returns the bytes of buffer view `index`; `pointer` is the JSON pointer of the reference to it.
    pub(super) fn view_bytes(&self, context: &Context, index: usize, pointer: &str) -> Result<&'a [u8]> {
        let views = &self.document.root.buffer_views;
        context.check_index(index, views.len(), pointer, "buffer view")?;
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
        .ok_or_else(|| context.invalid(pointer, "its buffer view extends past the end of the buffer"))
    }

    /// Error for a view into a buffer without data. Names the extension that holds the data, if there is one.
    fn no_data(&self, context: &Context, view: usize, buffer: usize, pointer: &str) -> Error {
        let raw = self.document.element("bufferViews", view);
        let extensions = raw.as_ref().and_then(|raw| raw.value.get("extensions")?.as_object());
        match extensions.and_then(|extensions| extensions.keys().next()) {
            Some(name) => context.unsupported(
                format!("/bufferViews/{view}/extensions/{}", escape(name)),
                format!(
                    "the data is stored only in the unsupported extension {name}; export the file without it"
                ),
            ),
            None => context.invalid(pointer, format!("needs buffer {buffer}, which has no data")),
        }
    }

    fn strided_elements(
        &self,
        context: &Context,
        range: &ElementRange,
        layout: &ElementLayout,
        pointer: &str,
    ) -> Result<StridedElements<'a>> {
        let stride = check_element_range(context, self.document, range, layout, pointer)?;
        let bytes = self.view_bytes(context, range.view, pointer)?;
        let start = usize::try_from(range.offset).unwrap_or(usize::MAX);
        Ok(StridedElements { bytes: bytes.get(start..).unwrap_or_default(), stride })
    }

    /// Reads accessor `index` as floats. Infinities and NaNs are errors, also in elements that [`Data::vertices`] leaves out.
    pub(super) fn floats<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Vec<[f32; N]>> {
        match self.stored_floats(context, index, pointer)? {
            (elements, None) => Ok(elements),
            (_, Some(i)) => Err(context.invalid(
                format!("/accessors/{index}"),
                format!("element {i} is infinite or not a number; export the file again"),
            )),
        }
    }

    /// Reads accessor `index` as floats. Elements with infinities or NaNs are zero, with a warning at `pointer`.
    pub(super) fn floats_or_zeros<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Vec<[f32; N]>> {
        let (mut elements, wrong) = self.stored_floats(context, index, pointer)?;
        if wrong.is_some() {
            context.warn(pointer, "some elements are infinite or not a number; they are taken as zero");
            for element in elements.iter_mut().filter(|element| is_wrong(element)) {
                *element = [0.0; N];
            }
        }
        Ok(elements)
    }

    /// Reads accessor `index` as floats, and finds the first of all its elements with an infinity or a NaN.
    fn stored_floats<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<(Vec<[f32; N]>, Option<usize>)> {
        let format = self.format(context, index, pointer)?;
        if format.component != ComponentType::F32 {
            let decode = |bytes: &[u8]| component::float(bytes, format.component, format.normalized);
            return Ok((self.elements(context, (index, pointer), self.vertices, decode)?, None));
        }
        // A loop without a case for every component. Primitives that share a list read what they use of it once it is checked.
        let decode = |bytes: &[u8]| component::float(bytes, ComponentType::F32, false);
        let is_shared = !self.decoded.contains_key(&index);
        let checked = context.first_wrong_elements.get(&index).copied().filter(|_| is_shared);
        if let (Some(wrong), Some(_)) = (checked, self.vertices) {
            return Ok((self.elements(context, (index, pointer), self.vertices, decode)?, wrong));
        }
        let elements: Vec<[f32; N]> = self.elements(context, (index, pointer), None, decode)?;
        let wrong = first_wrong(elements.as_flattened(), |value| !value.is_finite());
        let wrong = wrong.and_then(|component| component.checked_div(N));
        let accessor = self.accessor(context, index, pointer)?;
        if wrong.is_none() && self.is_plain(index, accessor) {
            check_extremes(context, accessor, index, &elements);
        }
        if is_shared {
            context.first_wrong_elements.insert(index, wrong);
        }
        let chosen = self.vertices.map(|vertices| at_indices(&elements, vertices));
        Ok((chosen.unwrap_or(elements), wrong))
    }

    /// Whether the file stores the elements as they are. Compression changes values a little, and its accessors state the originals.
    fn is_plain(&self, index: usize, accessor: &Accessor) -> bool {
        let is_packed = |view: usize| self.views.get(view).is_some_and(Option::is_some);
        let has_data = accessor.buffer_view.is_some() || accessor.sparse.is_some();
        has_data
            && !self.decoded.contains_key(&index)
            && !accessor.buffer_view.is_some_and(|view| is_packed(view.value()))
    }

    /// Reads accessor `index` as unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Vec<[u32; N]>> {
        let format = self.format(context, index, pointer)?;
        match format.component {
            ComponentType::U32 => {
                let decode = |bytes: &[u8]| component::unsigned(bytes, ComponentType::U32);
                self.elements(context, (index, pointer), self.vertices, decode)
            }
            component => {
                let decode = |bytes: &[u8]| component::unsigned(bytes, component);
                self.elements(context, (index, pointer), self.vertices, decode)
            }
        }
    }

    fn format(&self, context: &Context, index: usize, pointer: &str) -> Result<Format> {
        Format::of(self.accessor(context, index, pointer)?).ok_or_else(|| {
            context.invalid(format!("/accessors/{index}"), "has an unknown componentType or type")
        })
    }

    /// Decodes the elements at the increasing indices `chosen`, or all.
    fn elements<T: Copy + Default + Send, const N: usize>(
        &self,
        context: &mut Context,
        (index, pointer): (usize, &str),
        chosen: Option<&[u32]>,
        decode: impl Fn(&[u8]) -> T + Sync,
    ) -> Result<Vec<[T; N]>> {
        let accessor = self.accessor(context, index, pointer)?;
        let format = self.format(context, index, pointer)?;
        let pointer = format!("/accessors/{index}");
        let layout = ElementLayout::new(format.shape, format.component);
        if layout.offsets.len() != N {
            let message = format!("is {}, which this use does not allow", format_name(format));
            return Err(context.invalid(pointer, message));
        }
        let mut offsets = [0; N];
        offsets.copy_from_slice(&layout.offsets);
        let read = |bytes: &[u8]| offsets.map(|offset| decode(bytes.get(offset..).unwrap_or_default()));

        // Read the base elements: decoded ones, those of the buffer view, or zeros.
        let decoded = self.decoded.get(&index);
        let strided = match (decoded, base_elements(accessor)) {
            (Some(bytes), _) => Some(StridedElements { bytes, stride: layout.packed_bytes }),
            (None, Some(range)) => Some(self.strided_elements(context, &range, &layout, &pointer)?),
            (None, None) => None,
        };
        let count = chosen.map_or(accessor.count.0, |chosen| chosen.len() as u64);
        let mut elements: Vec<[T; N]> = context.allocate_all(count, [T::default(); N], &pointer)?;
        if let Some(strided) = strided {
            let index_of = |i: usize| match chosen {
                Some(chosen) => chosen.get(i).map_or(usize::MAX, |&index| index as usize),
                None => i,
            };
            // Blocks of components, so that elements of all widths share the code of the parallel loop.
            let block = N.saturating_mul(ELEMENTS_PER_TASK);
            fill_blocks(elements.as_flattened_mut(), block, &|index, components| {
                let first = index.saturating_mul(ELEMENTS_PER_TASK);
                for (i, element) in (first..).zip(components.as_chunks_mut::<N>().0) {
                    *element = read(strided.element(index_of(i)));
                }
            });
        }

        // Substitute the sparse elements.
        if let Some(values) = sparse_values(accessor).filter(|_| decoded.is_none()) {
            let values =
                self.strided_elements(context, &values, &layout, &format!("{pointer}/sparse/values"))?;
            let targets = self.sparse_targets(context, index, &pointer)?;
            match chosen {
                None => {
                    for i in 0..targets.count {
                        if let Some(element) = elements.get_mut(targets.target(i) as usize) {
                            *element = read(values.element(i));
                        }
                    }
                }
                Some(chosen) => {
                    for (element, &index) in elements.iter_mut().zip(chosen) {
                        if let Some(i) = targets.find(index) {
                            *element = read(values.element(i));
                        }
                    }
                }
            }
        }
        Ok(elements)
    }

    /// The elements that sparse values of the accessor `index` replace: strictly increasing and in range, which is checked once.
    fn sparse_targets(
        &self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<SparseTargets<'a>> {
        let accessor = self.accessor(context, index, pointer)?;
        let pointer = format!("{pointer}/sparse");
        let (range, component) = sparse_indices(context, accessor, &pointer)?;
        let layout = ElementLayout::new(Type::Scalar, component);
        let pointer = format!("{pointer}/indices");
        let indices = self.strided_elements(context, &range, &layout, &pointer)?;
        let count = usize::try_from(range.count).unwrap_or(usize::MAX);
        let targets = SparseTargets { indices, component, count };
        if !context.checked_sparse_accessors.insert(index) {
            return Ok(targets);
        }
        if !(0..count).map(|i| targets.target(i)).is_sorted_by(|a, b| a < b) {
            return Err(context.invalid(pointer, "are not strictly increasing"));
        }
        match count.checked_sub(1).map(|last| targets.target(last)) {
            Some(last) if u64::from(last) >= accessor.count.0 => {
                Err(context.invalid(pointer, format!("replace element {last} of {}", accessor.count.0)))
            }
            _ => Ok(targets),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sparse_values_are_found_by_the_elements_that_they_replace() {
        let targets = [0_u16, 3, 4, 9, 500, 65_535];
        let bytes: Vec<u8> = targets.iter().flat_map(|target| target.to_le_bytes()).collect();
        for count in 0..=targets.len() {
            let indices = StridedElements { bytes: &bytes, stride: 2 };
            let found = SparseTargets { indices, component: ComponentType::U16, count };
            for target in 0..=65_536 {
                let naive = targets[..count].iter().position(|&other| u32::from(other) == target);
                assert_eq!(found.find(target), naive, "{target} of {count}");
            }
        }
    }
}
