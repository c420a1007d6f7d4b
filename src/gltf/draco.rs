//! Draco-compressed primitives.
//!
//! Source: the text of `KHR_draco_mesh_compression` (Khronos Group). The crate `draco-core` decodes the streams.
//!
//! The decoded triangles and attributes replace the data of the primitive's accessors, after they have been checked
//! against the counts and formats of the accessors. An uncompressed fallback in the file is not read.

use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};
use gltf::json;
use gltf::json::accessor::ComponentType;

use super::accessor::{Data, DecodedAccessors};
use super::attributes::Attributes;
use super::component::ElementLayout;
use super::context::Context;
use super::formats::{Format, format_name};
use super::raw::Raw;
use crate::error::Result;

/// Estimated memory that the decoder needs for each triangle in addition to the attributes. Bounds the decoder's input.
const WORKING_BYTES_PER_TRIANGLE: u64 = 128;

/// Decoded geometry of one stream.
#[derive(Debug)]
pub(super) struct DecodedPrimitive {
    /// Decoded elements of the attributes' accessors.
    pub(super) decoded: DecodedAccessors,
    /// Vertex indices of each triangle.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Decodes the stream of the primitive `json`; `raw` is its extension object.
pub(super) fn decode_primitive(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    json: &json::mesh::Primitive,
    raw: &Raw,
) -> Result<DecodedPrimitive> {
    raw.expect_object(context)?;
    let Some(view) = raw.index(context, "bufferView")? else {
        return Err(context.invalid(format!("{}/bufferView", raw.pointer), "is missing"));
    };
    let stream = data.view_bytes(context, view, &format!("{}/bufferView", raw.pointer))?;
    let used_before = context.used_bytes();
    let mesh = decode(context, stream, &raw.pointer)?;
    let mesh_bytes = mesh_size(&mesh);
    context.charge(mesh_bytes, &raw.pointer)?;
    let triangles = triangles(context, data, &mesh, json, raw)?;
    let Some(names) = raw.field("attributes") else {
        return Err(context.invalid(format!("{}/attributes", raw.pointer), "is missing"));
    };
    let mut decoded = DecodedAccessors::new();
    for (name, id, pointer) in names.indices(context)? {
        let Some(reference) = attributes.find(name) else {
            let message = format!("the primitive has no attribute {name} for these values");
            return Err(context.invalid(pointer, message));
        };
        let attribute = u32::try_from(id).ok().and_then(|id| mesh.attribute_by_unique_id(id));
        let Some(attribute) = attribute else {
            return Err(context.invalid(pointer, format!("the compressed data has no attribute {id}")));
        };
        let accessor = data.accessor(context, reference.accessor, &reference.pointer)?;
        if accessor.count.0 != mesh.num_points() as u64 {
            let message = format!(
                "the compressed data has {} vertices, but accessor {} has {}",
                mesh.num_points(),
                reference.accessor,
                accessor.count.0
            );
            return Err(context.invalid(pointer, message));
        }
        let Some(format) = Format::of(accessor) else {
            return Err(
                context.invalid(&reference.pointer, "its accessor has an unknown componentType or type")
            );
        };
        let values = values(context, &mesh, attribute, format, &pointer)?;
        decoded.insert(reference.accessor, values);
    }
    // The decoded mesh is dropped, the data copied from it is kept.
    let kept = context.used_bytes().saturating_sub(used_before).saturating_sub(mesh_bytes);
    context.release_temporaries(used_before, kept);
    Ok(DecodedPrimitive { decoded, triangles })
}

/// Size of a decoded mesh: vertex indices, attribute values and the map from vertices to values.
fn mesh_size(mesh: &Mesh) -> u64 {
    let corners = (mesh.num_faces() as u64).saturating_mul(12);
    let attributes = (0..mesh.num_attributes()).map(|index| {
        let values = mesh.attribute(index).buffer().data().len() as u64;
        values.saturating_add((mesh.num_points() as u64).saturating_mul(4))
    });
    attributes.fold(corners, u64::saturating_add)
}

/// Decodes `stream` within the remaining memory.
fn decode(context: &mut Context, stream: &[u8], pointer: &str) -> Result<Mesh> {
    let remaining = context.remaining_bytes();
    let max_elements = (remaining / WORKING_BYTES_PER_TRIANGLE).min(u64::from(u32::MAX));
    let limits = DecodeLimits::default()
        .with_max_faces(max_elements)
        .with_max_points(max_elements)
        .with_max_decoded_bytes(remaining / 2);
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let mut mesh = Mesh::new();
        let status =
            MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh);
        status.map(|()| mesh)
    }));
    match decoded {
        Ok(Ok(mesh)) => Ok(mesh),
        Ok(Err(error)) if error.kind() == draco_core::ErrorKind::LimitExceeded => {
            Err(context.over_memory(pointer, error.to_string(), None))
        }
        Ok(Err(error)) => {
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            Err(context.invalid(pointer, format!("the compressed data is damaged: {line}")))
        }
        Err(_) => Err(context.invalid(pointer, "the compressed data is damaged")),
    }
}

/// Triangles of the stream. Warns if the accessor counts other indices: some exporters write the count from before
/// compression.
fn triangles(
    context: &mut Context,
    data: &Data,
    mesh: &Mesh,
    json: &json::mesh::Primitive,
    raw: &Raw,
) -> Result<Vec<[u32; 3]>> {
    let mut triangles = context.allocate(mesh.num_faces() as u64, &raw.pointer)?;
    triangles.extend(mesh.faces().iter().map(|face| face.map(|point| point.0)));
    let vertices = mesh.num_points();
    if let Some(corner) = triangles.iter().flatten().find(|corner| **corner as usize >= vertices) {
        let message = format!("the compressed data refers to vertex {corner} of {vertices}");
        return Err(context.invalid(&raw.pointer, message));
    }
    let drawn_as_list = json.mode == json::validation::Checked::Valid(json::mesh::Mode::Triangles);
    if let Some(indices) = json.indices.filter(|_| drawn_as_list) {
        let accessor = data.accessor(context, indices.value(), &raw.pointer)?;
        if accessor.count.0 != (triangles.len() as u64).saturating_mul(3) {
            context.warn(
                &raw.pointer,
                "the index counts of some compressed primitives differ from those of their accessors; all triangles are used",
            );
        }
    }
    Ok(triangles)
}

/// Values of the attribute at every vertex, packed as an accessor of `format` stores them.
fn values(
    context: &mut Context,
    mesh: &Mesh,
    attribute: &PointAttribute,
    format: Format,
    pointer: &str,
) -> Result<Vec<u8>> {
    let layout = ElementLayout::new(format.shape, format.component);
    let components = usize::from(attribute.num_components());
    let stored = attribute.data_type();
    let same = stored == data_type(format.component);
    let convertible = stored.is_integral() && format.component != ComponentType::F32;
    if components != layout.offsets.len() || !(same || convertible) {
        let message = format!(
            "the compressed data has {components} components of {stored:?}, but the accessor is {}",
            format_name(format)
        );
        return Err(context.invalid(pointer, message));
    }
    let damaged = || context.invalid(pointer, "the compressed data lacks values of some vertices");
    let size = stored.byte_length();
    let stride = usize::try_from(attribute.byte_stride()).map_err(|_| damaged())?;
    let count = mesh.num_points();
    let too_large =
        context.invalid(pointer, "the compressed data has a number that the accessor cannot hold");
    let lacking = damaged();
    let mut values = context.allocate((count as u64).saturating_mul(layout.packed_bytes as u64), pointer)?;
    for point in 0..count {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride).filter(|_| value < attribute.size());
        let bytes = start.and_then(|start| attribute.buffer().data().get(start..));
        let Some(bytes) = bytes.and_then(|bytes| bytes.get(..components.checked_mul(size)?)) else {
            return Err(lacking);
        };
        if same {
            values.extend_from_slice(bytes);
            continue;
        }
        for component in bytes.chunks_exact(size) {
            let number = integer(component, stored);
            let width = format.component.size();
            let Some(bytes) = to_component_bytes(number, format.component) else {
                return Err(too_large);
            };
            values.extend_from_slice(bytes.get(..width).unwrap_or_default());
        }
    }
    Ok(values)
}

fn data_type(component: ComponentType) -> DataType {
    match component {
        ComponentType::I8 => DataType::Int8,
        ComponentType::U8 => DataType::Uint8,
        ComponentType::I16 => DataType::Int16,
        ComponentType::U16 => DataType::Uint16,
        ComponentType::U32 => DataType::Uint32,
        ComponentType::F32 => DataType::Float32,
    }
}

/// Reads a little-endian integer of the type `stored`.
fn integer(bytes: &[u8], stored: DataType) -> i64 {
    let signed = matches!(stored, DataType::Int8 | DataType::Int16 | DataType::Int32 | DataType::Int64);
    let negative = signed && bytes.last().is_some_and(|byte| byte & 0x80 != 0);
    let mut wide = if negative { [0xff; 8] } else { [0; 8] };
    wide.iter_mut().zip(bytes).for_each(|(slot, byte)| *slot = *byte);
    i64::from_le_bytes(wide)
}

/// The little-endian bytes of `number`, or `None` if the component type cannot hold it.
fn to_component_bytes(number: i64, component: ComponentType) -> Option<[u8; 8]> {
    let range = match component {
        ComponentType::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
        ComponentType::U8 => 0..=i64::from(u8::MAX),
        ComponentType::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
        ComponentType::U16 => 0..=i64::from(u16::MAX),
        ComponentType::U32 | ComponentType::F32 => 0..=i64::from(u32::MAX),
    };
    range.contains(&number).then(|| number.to_le_bytes())
}
