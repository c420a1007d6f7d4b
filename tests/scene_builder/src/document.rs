//! A text glTF 2.0 file: its top-level arrays, and one buffer that is embedded as base64.

use std::error::Error;

use base64::Engine as _;
use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::accessor::{Accessor, Component, Use, bounds_of, float_bytes, position_accessor};
use crate::json::{Json, list, object};
use crate::node::Node;

/// The result of building a scene.
pub type Built<T = Gltf> = Result<T, Box<dyn Error>>;

/// The top-level arrays in the order in which they are written.
const SECTIONS: [&str; 13] = [
    "scenes",
    "nodes",
    "cameras",
    "meshes",
    "materials",
    "textures",
    "samplers",
    "images",
    "skins",
    "animations",
    "accessors",
    "bufferViews",
    "buffers",
];

/// A glTF file under construction. Methods that add an element return its index.
#[derive(Clone, Debug)]
pub struct Gltf {
    shows: &'static str,
    shot: Vec<(&'static str, Json)>,
    bytes: Vec<u8>,
    sections: Vec<(&'static str, Vec<Json>)>,
    extensions: Vec<(&'static str, bool)>,
    lights: Vec<Json>,
    variants: Vec<Json>,
    child_nodes: Vec<usize>,
    default_scene: usize,
    /// Buffers after the first, without content.
    placeholders: Vec<Json>,
    /// Extensions of the whole file.
    root_extensions: Vec<(&'static str, Json)>,
}

impl Gltf {
    /// An empty file. `shows` describes a correct image of it.
    pub fn new(shows: &'static str) -> Self {
        Self {
            shows,
            shot: Vec::new(),
            bytes: Vec::new(),
            sections: Vec::new(),
            extensions: Vec::new(),
            lights: Vec::new(),
            variants: Vec::new(),
            child_nodes: Vec::new(),
            default_scene: 0,
            placeholders: Vec::new(),
            root_extensions: Vec::new(),
        }
    }

    /// Sets the frames, at 24 fps, that have a reference image. The default is frame 0.
    pub fn reference_frames(&mut self, frames: &[usize]) {
        self.shot("frames", list(frames.iter().copied()));
    }

    /// Sets a setting of the shot file by its name in docs/shots.md.
    pub fn shot(&mut self, setting: &'static str, value: impl Into<Json>) {
        self.shot.push((setting, value.into()));
    }

    /// Appends to a top-level array.
    pub fn add(&mut self, section: &'static str, value: Json) -> usize {
        if let Some((_, values)) = self.sections.iter_mut().find(|(name, _)| *name == section) {
            values.push(value);
            return values.len() - 1;
        }
        self.sections.push((section, vec![value]));
        0
    }

    /// Sets the `extensions` object of an element of a top-level array.
    pub fn extend(&mut self, section: &str, index: usize, extensions: Json) {
        self.set(section, index, "extensions", extensions);
    }

    /// Sets a property of an element of a top-level array.
    pub fn set(&mut self, section: &str, index: usize, key: &str, value: impl Into<Json>) {
        let written = self.sections.iter_mut().find(|(name, _)| *name == section);
        if let Some(element) = written.and_then(|(_, values)| values.get_mut(index)) {
            element.set(key, value);
        }
    }

    /// Adds an extension object of the whole file.
    pub fn extension(&mut self, name: &'static str, value: Json) {
        self.root_extensions.push((name, value));
    }

    /// Adds a fallback buffer of `byte_length` without content; `extension` stores its content elsewhere.
    pub fn placeholder_buffer(&mut self, byte_length: usize, extension: &str) {
        let fallback = object([("fallback", true.into())]);
        self.placeholders.push(object([
            ("byteLength", byte_length.into()),
            ("extensions", object([(extension, fallback)])),
        ]));
    }

    /// Adds a name to `extensionsUsed`.
    pub fn uses_extension(&mut self, name: &'static str) {
        if !self.extensions.iter().any(|(known, _)| *known == name) {
            self.extensions.push((name, false));
        }
    }

    /// Adds a name to `extensionsUsed` and `extensionsRequired`.
    pub fn requires_extension(&mut self, name: &'static str) {
        self.extensions.retain(|(known, _)| *known != name);
        self.extensions.push((name, true));
    }

    /// Adds a node.
    pub fn node(&mut self, node: Node) -> usize {
        self.child_nodes.extend(&node.children);
        if node.light.is_some() {
            self.uses_extension("KHR_lights_punctual");
        }
        self.add("nodes", node.into_json())
    }

    /// Adds a punctual light.
    pub fn light(&mut self, light: Json) -> usize {
        self.lights.push(light);
        self.lights.len() - 1
    }

    /// Sets the names of the material variants.
    pub fn variants(&mut self, names: &[&str]) {
        self.uses_extension("KHR_materials_variants");
        self.variants = names.iter().map(|name| object([("name", (*name).into())])).collect();
    }

    /// Adds a scene of root nodes. A file without any gets one of all nodes that are no children.
    pub fn scene(&mut self, name: &str, roots: &[usize]) -> usize {
        self.add("scenes", object([("name", name.into()), ("nodes", list(roots.iter().copied()))]))
    }

    /// Sets the default scene.
    pub fn show_scene(&mut self, index: usize) {
        self.default_scene = index;
    }

    /// Adds a buffer view of `data`, at the next multiple of four bytes.
    pub fn buffer_view(&mut self, data: &[u8], used_as: Use, byte_stride: Option<usize>) -> usize {
        let start = self.append_bytes(data);
        let mut view =
            object([("buffer", 0.into()), ("byteOffset", start.into()), ("byteLength", data.len().into())]);
        if let Some(stride) = byte_stride {
            view.set("byteStride", stride);
        }
        match used_as {
            Use::Vertices => view.set("target", 34962),
            Use::Indices => view.set("target", 34963),
            Use::Other => {}
        }
        self.add("bufferViews", view)
    }

    /// Appends `data` to the buffer at the next multiple of four bytes; returns its offset.
    pub fn append_bytes(&mut self, data: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let start = self.bytes.len();
        self.bytes.extend_from_slice(data);
        start
    }

    /// Adds an accessor and its bytes.
    pub fn accessor(&mut self, accessor: &Accessor) -> usize {
        let mut json = object([]);
        if let Some(data) = &accessor.data {
            json.set("bufferView", self.buffer_view(data, accessor.used_as, accessor.byte_stride));
        }
        json.set("componentType", accessor.component as usize);
        if accessor.normalized {
            json.set("normalized", true);
        }
        json.set("count", accessor.count);
        json.set("type", accessor.kind);
        if let Some((min, max)) = &accessor.bounds {
            json.set("min", list(min.iter().copied()));
            json.set("max", list(max.iter().copied()));
        }
        if let Some((indices, values)) = &accessor.sparse {
            let index_bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
            let index_view = self.buffer_view(&index_bytes, Use::Other, None);
            let value_view = self.buffer_view(values, Use::Other, None);
            json.set(
                "sparse",
                object([
                    ("count", indices.len().into()),
                    (
                        "indices",
                        object([
                            ("bufferView", index_view.into()),
                            ("componentType", (Component::U16 as usize).into()),
                        ]),
                    ),
                    ("values", object([("bufferView", value_view.into())])),
                ]),
            );
        }
        self.add("accessors", json)
    }

    /// Adds vertex positions, or morph target differences of them, with their bounds.
    pub fn positions(&mut self, values: &[Vec3]) -> usize {
        self.accessor(&position_accessor(values))
    }

    /// Adds three floats a vertex.
    pub fn vec3s(&mut self, values: &[Vec3]) -> usize {
        let data = float_bytes(values.iter().flat_map(Vec3::to_array));
        self.accessor(&Accessor::new(Component::F32, "VEC3", values.len(), data))
    }

    /// Adds two floats a vertex.
    pub fn vec2s(&mut self, values: &[Vec2]) -> usize {
        let data = float_bytes(values.iter().flat_map(Vec2::to_array));
        self.accessor(&Accessor::new(Component::F32, "VEC2", values.len(), data))
    }

    /// Adds four floats a vertex.
    pub fn vec4s(&mut self, values: &[Vec4]) -> usize {
        let data = float_bytes(values.iter().flat_map(Vec4::to_array));
        self.accessor(&Accessor::new(Component::F32, "VEC4", values.len(), data))
    }

    /// Adds four bytes a vertex: joint indices or, normalised, fractions of 255.
    pub fn bytes4(&mut self, values: &[[u8; 4]], normalized: bool) -> usize {
        let mut accessor = Accessor::new(Component::U8, "VEC4", values.len(), values.concat());
        accessor.normalized = normalized;
        self.accessor(&accessor)
    }

    /// Adds the joints of every vertex and their weights as fractions of 255. Joints without weight are written as 0.
    pub fn influences(&mut self, joints: &[[u8; 4]], weights: &[[u8; 4]]) -> (usize, usize) {
        let mut joints = joints.to_vec();
        for (joints, weights) in joints.iter_mut().zip(weights) {
            for (joint, weight) in joints.iter_mut().zip(weights) {
                if *weight == 0 {
                    *joint = 0;
                }
            }
        }
        (self.bytes4(&joints, false), self.bytes4(weights, true))
    }

    /// Adds vertex indices, of 16 bits where they fit.
    pub fn indices(&mut self, values: &[u32]) -> usize {
        let wide = values.iter().any(|&index| index >= 0xffff);
        let (component, data): (_, Vec<u8>) = if wide {
            (Component::U32, values.iter().flat_map(|value| value.to_le_bytes()).collect())
        } else {
            (Component::U16, values.iter().flat_map(|&value| (value as u16).to_le_bytes()).collect())
        };
        let mut accessor = Accessor::new(component, "SCALAR", values.len(), data);
        accessor.used_as = Use::Indices;
        self.accessor(&accessor)
    }

    /// Adds floats of an animation sampler or of matrices; an element of `kind` has `width` of them.
    pub fn track(&mut self, kind: &'static str, width: usize, values: &[f32]) -> usize {
        let mut accessor =
            Accessor::new(Component::F32, kind, values.len() / width, float_bytes(values.iter().copied()));
        accessor.used_as = Use::Other;
        if kind == "SCALAR" {
            accessor.bounds = Some(bounds_of(values, 1));
        }
        self.accessor(&accessor)
    }

    /// Adds a skin of `joints` with the inverse bind matrices `inverse_bind`.
    pub fn skin(&mut self, joints: &[usize], inverse_bind: &[Mat4]) -> usize {
        let values: Vec<f32> = inverse_bind.iter().flat_map(Mat4::to_cols_array).collect();
        let matrices = self.track("MAT4", 16, &values);
        self.add(
            "skins",
            object([("inverseBindMatrices", matrices.into()), ("joints", list(joints.iter().copied()))]),
        )
    }

    /// The text of the file.
    pub fn to_file_text(&self) -> String {
        let mut root = object([
            ("asset", object([("version", "2.0".into()), ("generator", "rayframe make_scenes".into())])),
            ("extras", object([("shows", self.shows.into())])),
        ]);
        let used = self.extensions.iter().map(|(name, _)| *name);
        let required = self.extensions.iter().filter(|(_, required)| *required).map(|(name, _)| *name);
        set_unless_empty(&mut root, "extensionsUsed", list(used));
        set_unless_empty(&mut root, "extensionsRequired", list(required));
        let mut extensions = object([]);
        if !self.lights.is_empty() {
            extensions.set("KHR_lights_punctual", object([("lights", self.lights.clone().into())]));
        }
        if !self.variants.is_empty() {
            let variants = object([("variants", self.variants.clone().into())]);
            extensions.set("KHR_materials_variants", variants);
        }
        for (name, value) in &self.root_extensions {
            extensions.set(name, value.clone());
        }
        set_unless_empty(&mut root, "extensions", extensions);
        root.set("scene", self.default_scene);
        for name in SECTIONS {
            set_unless_empty(&mut root, name, self.section(name).into());
        }
        root.to_file_text()
    }

    /// The text of the shot file for the scene file `name` beside it; `None` where the suite's settings suffice.
    pub fn to_shot_text(&self, name: &str) -> Option<String> {
        if self.shot.is_empty() {
            return None;
        }
        // A line of JSON is valid TOML except for objects, and no setting is an object.
        let scene = [("scene", name.into())];
        let lines =
            scene.iter().chain(&self.shot).map(|(key, value)| format!("{key} = {}\n", value.to_line()));
        Some(lines.collect())
    }

    fn section(&self, name: &str) -> Vec<Json> {
        let written = self.sections.iter().find(|(known, _)| *known == name);
        match (name, written) {
            (_, Some((_, values))) => values.clone(),
            ("scenes", None) => {
                let node_count = self.section("nodes").len();
                let roots = (0..node_count).filter(|node| !self.child_nodes.contains(node));
                vec![object([("nodes", list(roots))])]
            }
            ("buffers", None) if !self.bytes.is_empty() => {
                let text = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
                let uri = format!("data:application/octet-stream;base64,{text}");
                let first = object([("byteLength", self.bytes.len().into()), ("uri", uri.into())]);
                [&[first][..], &self.placeholders].concat()
            }
            _ => Vec::new(),
        }
    }
}

fn set_unless_empty(root: &mut Json, key: &str, value: Json) {
    if !value.is_empty() {
        root.set(key, value);
    }
}

/// A GLB container of a JSON chunk and a binary chunk.
pub fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], padding: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), padding);
        bytes
    };
    let chunks = [(*b"JSON", padded(json.as_bytes(), b' ')), (*b"BIN\0", padded(binary, 0))];
    let length: usize = 12 + chunks.iter().map(|(_, content)| 8 + content.len()).sum::<usize>();
    let mut file = [&b"glTF"[..], &2_u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (kind, content) in chunks {
        file.extend((content.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(content);
    }
    file
}
