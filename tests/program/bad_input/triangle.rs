//! The smallest valid scene, one triangle, as a JSON document that tests then spoil.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use scene_builder::document::Gltf;
use scene_builder::node::Node;
use serde_json::{Value, json};

/// The buffer: three positions, then three indices of 16 bits.
pub(crate) const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
pub(crate) const INDICES: [u16; 3] = [0, 1, 2];
pub(crate) const BUFFER_BYTES: usize = 42;

/// The bytes of the buffer.
pub(crate) fn buffer(positions: &[[f32; 3]], indices: &[u16]) -> Vec<u8> {
    let positions = positions.iter().flatten().flat_map(|value| value.to_le_bytes());
    positions.chain(indices.iter().flat_map(|index| index.to_le_bytes())).collect()
}

/// A valid scene of one triangle; its buffer is at `buffer_uri`, or else the binary chunk of a GLB.
#[expect(clippy::unwrap_used, reason = "the builder writes valid JSON")]
pub(crate) fn document(buffer_uri: Option<&str>) -> Value {
    let mut gltf = Gltf::new("A triangle.");
    let positions = gltf.positions(&POSITIONS.map(Vec3::from_array));
    let indices = gltf.indices(&INDICES.map(u32::from));
    let attributes = json!({ "POSITION": positions });
    let mesh = json!({ "primitives": [{ "attributes": attributes, "indices": indices }] });
    let mesh = gltf.add("meshes", mesh.into());
    gltf.node(Node::mesh(mesh));
    let mut document: Value = serde_json::from_str(&gltf.to_file_text()).unwrap();
    let buffer = document["buffers"][0].as_object_mut().unwrap();
    buffer.remove("uri");
    if let Some(uri) = buffer_uri {
        buffer.insert("uri".to_owned(), uri.into());
    }
    document
}

/// The scene with its buffer as a data URI.
pub(crate) fn embedded(positions: &[[f32; 3]], indices: &[u16]) -> Value {
    let data = STANDARD.encode(buffer(positions, indices));
    document(Some(&format!("data:application/octet-stream;base64,{data}")))
}

/// The valid scene.
pub(crate) fn triangle() -> Value {
    embedded(&POSITIONS, &INDICES)
}

/// A GLB of `document` with the triangle as its binary chunk.
pub(crate) fn glb(document: &Value) -> Vec<u8> {
    scene_builder::document::glb(&document.to_string(), &buffer(&POSITIONS, &INDICES))
}
