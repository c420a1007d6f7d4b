//! A generated mesh: a bumpy ring, as a binary glTF file.

use glam::Vec3;
use scene_builder::document::glb;
use scene_builder::shapes::torus;
use serde_json::json;

/// The file of a ring of `cells` around and across, with two triangles a cell.
pub(crate) fn mesh_file([segments, sides]: [u32; 2]) -> Vec<u8> {
    let mut mesh = torus(1.0, 0.45, segments, sides);
    for (position, normal) in mesh.positions.iter_mut().zip(&mesh.normals) {
        let bump =
            libm::sinf(position.x * 25.0) * libm::sinf(position.y * 25.0) * libm::sinf(position.z * 25.0);
        *position += *normal * (bump * 0.03);
    }
    let (vertices, indices) = (mesh.positions.len(), mesh.indices.len());
    let attribute_bytes = vertices * 12;
    let floats = mesh.positions.iter().chain(&mesh.normals).flat_map(Vec3::to_array);
    let mut bytes: Vec<u8> = Vec::with_capacity(2 * attribute_bytes + 4 * indices);
    bytes.extend(floats.flat_map(f32::to_le_bytes));
    bytes.extend(mesh.indices.iter().flat_map(|index| index.to_le_bytes()));

    let attribute =
        |view| json!({"bufferView": view, "componentType": 5126, "count": vertices, "type": "VEC3"});
    let mut positions = attribute(0);
    positions["min"] = json!([-1.5, -0.5, -1.5]);
    positions["max"] = json!([1.5, 0.5, 1.5]);
    let view = |start: usize, length: usize| json!({"buffer": 0, "byteOffset": start, "byteLength": length});
    let json = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.5}}],
        "accessors": [
            positions,
            attribute(1),
            {"bufferView": 2, "componentType": 5125, "count": indices, "type": "SCALAR"},
        ],
        "bufferViews": [
            view(0, attribute_bytes),
            view(attribute_bytes, attribute_bytes),
            view(2 * attribute_bytes, 4 * indices),
        ],
        "buffers": [{"byteLength": bytes.len()}],
    });
    glb(&json.to_string(), &bytes)
}
