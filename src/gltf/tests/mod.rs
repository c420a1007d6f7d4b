//! Import tests on whole files that are built in code.

#![expect(clippy::arithmetic_side_effects, reason = "an overflow in a test is a failed test")]

mod absent_properties;
mod accessors;
mod animated_values;
mod animations;
mod coordinate_steps;
mod exporters;
mod geometry;
mod hierarchy;
mod image_light;
mod instancing;
mod material_extensions;
mod materials;
mod pointers;
mod properties;
mod resources;
mod shared_vertices;
mod storage;
mod textures;

use base64::Engine;
use serde_json::{Value, json};

use super::{ImportOptions, import};
use crate::error::{Error, Result};
use crate::scene::Scene;

/// Document builder: JSON and a growing buffer.
pub(super) struct Document {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
    /// Buffers after the first.
    pub(super) more_buffers: Vec<Value>,
}

impl Document {
    /// Scene of one node with one mesh of one triangle, (0,0,0) (1,0,0) (0,1,0).
    pub(super) fn triangle() -> Self {
        let mut document = Self {
            json: json!({
                "asset": {"version": "2.0"},
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {}}]}],
                "accessors": [], "bufferViews": [], "buffers": []
            }),
            bytes: Vec::new(),
            more_buffers: Vec::new(),
        };
        let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        document.attribute("POSITION", "VEC3", &positions);
        document
    }

    /// Appends `bytes` as a buffer view and returns its index.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push("bufferViews", view)
    }

    /// Appends an accessor over a new buffer view and returns its index.
    pub(super) fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "type": shape, "count": count});
        self.push("accessors", accessor)
    }

    /// Appends an accessor of floats.
    pub(super) fn floats(&mut self, shape: &str, values: &[f32]) -> usize {
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(5126, shape, values.len() / width, &bytes)
    }

    /// Adds an attribute of floats to the first primitive.
    pub(super) fn attribute(&mut self, name: &str, shape: &str, values: &[f32]) {
        let accessor = self.floats(shape, values);
        self.set_attribute(name, accessor);
    }

    pub(super) fn set_attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    pub(super) fn push(&mut self, array: &str, element: Value) -> usize {
        let list = &mut self.json[array];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(element);
        list.len() - 1
    }

    /// The JSON with the buffer embedded.
    fn to_json(&self) -> Value {
        let mut json = self.json.clone();
        let base64 = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{base64}");
        let first = json!({"byteLength": self.bytes.len(), "uri": uri});
        json["buffers"] = json!([&[first][..], &self.more_buffers].concat());
        json
    }

    pub(super) fn import(&self) -> Result<Scene> {
        import_bytes("scene.gltf", self.to_json().to_string().as_bytes())
    }

    /// Imports the document and returns the error text, after checking its exit code.
    pub(super) fn error(&self, exit_code: u8) -> String {
        error_text(self.import(), exit_code)
    }
}

/// Imports a file with the contents `bytes` in an otherwise empty folder.
fn import_bytes(name: &str, bytes: &[u8]) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    import(&path, &ImportOptions::default())
}

fn error_text(result: Result<Scene>, exit_code: u8) -> String {
    let error: Error = result.map(|_| ()).unwrap_err();
    let text = error.to_string();
    assert_eq!(error.exit_code(), exit_code, "{text}");
    assert!(!text.contains('\n'), "not one line: {text}");
    text
}

/// Builds a GLB of the given chunks.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, content) in chunks {
        let padded = content.len().next_multiple_of(4);
        body.extend((padded as u32).to_le_bytes());
        body.extend(*kind);
        body.extend(*content);
        let padding = if *kind == b"JSON" { b' ' } else { 0 };
        body.resize(body.len() + padded - content.len(), padding);
    }
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((body.len() as u32 + 12).to_le_bytes());
    file.extend(body);
    file
}
