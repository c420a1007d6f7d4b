//! The smallest right scene, and spoiled versions of it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// One triangle: positions, then indices of 16 bits, in one buffer.
pub(crate) const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
pub(crate) const INDICES: [u16; 3] = [0, 1, 2];
pub(crate) const BUFFER_BYTES: usize = 42;

pub(crate) fn buffer(positions: &[[f32; 3]], indices: &[u16]) -> Vec<u8> {
    let positions = positions.iter().flatten().flat_map(|value| value.to_le_bytes());
    positions.chain(indices.iter().flat_map(|index| index.to_le_bytes())).collect()
}

/// A right scene of one triangle; its buffer is at `buffer_uri`, or else the binary chunk of a GLB.
pub(crate) fn document(buffer_uri: Option<&str>) -> Value {
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0],
            },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": BUFFER_BYTES }],
    });
    if let Some(uri) = buffer_uri {
        document["buffers"][0]["uri"] = uri.into();
    }
    document
}

pub(crate) fn embedded(positions: &[[f32; 3]], indices: &[u16]) -> Value {
    let data = STANDARD.encode(buffer(positions, indices));
    document(Some(&format!("data:application/octet-stream;base64,{data}")))
}

pub(crate) fn triangle() -> Value {
    embedded(&POSITIONS, &INDICES)
}

/// A GLB of `document` with the triangle as its binary chunk.
pub(crate) fn glb(document: &Value) -> Vec<u8> {
    let padded = |mut bytes: Vec<u8>, padding: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), padding);
        bytes
    };
    let chunks = [
        (*b"JSON", padded(document.to_string().into_bytes(), b' ')),
        (*b"BIN\0", padded(buffer(&POSITIONS, &INDICES), 0)),
    ];
    let length: usize = 12 + chunks.iter().map(|(_, content)| 8 + content.len()).sum::<usize>();
    let mut file = [&b"glTF"[..], &2_u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (kind, content) in chunks {
        file.extend((content.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(content);
    }
    file
}
