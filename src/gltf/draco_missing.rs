//! Refuses Draco streams: the feature `draco` is off.

use gltf::json;

use super::accessor::{Data, DecodedAccessors};
use super::attributes::Attributes;
use super::context::Context;
use super::raw::Raw;
use crate::error::Result;

/// The geometry of one stream.
#[derive(Debug)]
pub(super) struct DecodedPrimitive {
    /// Content of the accessors of the attributes.
    pub(super) decoded: DecodedAccessors,
    /// Corners of each triangle.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Always an error that names the feature.
pub(super) fn decode_primitive(
    context: &mut Context,
    _: &Data,
    _: &Attributes,
    _: &json::mesh::Primitive,
    raw: &Raw,
) -> Result<DecodedPrimitive> {
    let message = "this build of Rayframe decodes no Draco meshes; build it with the feature \"draco\"";
    Err(context.unsupported(&raw.pointer, message))
}
