//! A glTF file of cards in a row, and what is seen in the middle of each.

use std::io::Cursor;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::{ImageFormat, RgbaImage};
use rayframe::cancel::CancelFlag;
use rayframe::cli::{ShotRequest, shot_job};
use rayframe::film::PixelWindow;
use rayframe::frame::Frame;
use rayframe::render::RenderSettings;
use rayframe::sequence::film_of;
use serde_json::{Map, Value, json};

/// Pixels of a card's place, each way.
const PIXELS: u32 = 64;

/// A file in the making.
#[derive(Default)]
pub(crate) struct Sheet {
    cards: usize,
    blob: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    samplers: Vec<Value>,
    animations: Vec<Value>,
    extensions: Map<String, Value>,
    extensions_used: Vec<String>,
}

/// A square of half a metre each way, seen from the front.
pub(crate) struct Card {
    pub(crate) corners: [[f32; 3]; 4],
    pub(crate) uvs: [[f32; 2]; 4],
    pub(crate) colors: Option<[[f32; 4]; 4]>,
    pub(crate) normals: Option<[[f32; 3]; 4]>,
    pub(crate) tangents: Option<[[f32; 4]; 4]>,
}

impl Default for Card {
    fn default() -> Self {
        Self {
            corners: [[-0.4, -0.4, 0.0], [0.4, -0.4, 0.0], [0.4, 0.4, 0.0], [-0.4, 0.4, 0.0]],
            uvs: [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            colors: None,
            normals: None,
            tangents: None,
        }
    }
}

impl Card {
    /// The whole card has one place of the texture.
    pub(crate) fn at_uv(u: f32, v: f32) -> Self {
        // A little around it, so that the footprint is no point.
        let d = 1.0e-3;
        Self { uvs: [[u - d, v + d], [u + d, v + d], [u + d, v - d], [u - d, v - d]], ..Self::default() }
    }
}

/// A material that sends `value` of base colour and nothing else.
pub(crate) fn unlit(value: &Value) -> Value {
    json!({ "pbrMetallicRoughness": value, "extensions": { "KHR_materials_unlit": {} } })
}

#[expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that cannot go on may panic")]
impl Sheet {
    pub(crate) fn new(extensions_used: &[&str]) -> Self {
        let mut extensions_used: Vec<String> = extensions_used.iter().map(|&name| name.to_owned()).collect();
        extensions_used.push("KHR_materials_unlit".to_owned());
        Self { extensions_used, ..Self::default() }
    }

    /// Adds a material; gives its subscript.
    pub(crate) fn material(&mut self, material: Value) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a texture of a picture; gives its subscript.
    pub(crate) fn texture(&mut self, width: u32, texels: &[[u8; 4]], sampler: Value) -> usize {
        let height = texels.len() as u32 / width;
        let picture = RgbaImage::from_raw(width, height, texels.concat()).unwrap();
        let mut png = Cursor::new(Vec::new());
        picture.write_to(&mut png, ImageFormat::Png).unwrap();
        let uri = format!("data:image/png;base64,{}", STANDARD.encode(png.into_inner()));
        self.images.push(json!({ "uri": uri }));
        self.samplers.push(sampler);
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": self.samplers.len() - 1 }));
        self.textures.len() - 1
    }

    /// Adds numbers of `width` components; gives the accessor's subscript.
    pub(crate) fn numbers(&mut self, numbers: &[f32], width: usize) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        self.views
            .push(json!({ "buffer": 0, "byteOffset": self.blob.len(), "byteLength": 4 * numbers.len() }));
        self.blob.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let ends = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..width).map(|i| numbers.iter().skip(i).step_by(width).copied().reduce(pick).unwrap()).collect()
        };
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": 5126, "count": numbers.len() / width, "type": kind,
            "min": ends(f32::min), "max": ends(f32::max),
        }));
        self.accessors.len() - 1
    }

    /// Puts a card at the end of the row; gives its node.
    pub(crate) fn card(&mut self, card: &Card, material: usize) -> usize {
        let node = self.behind(card, material, 0.0);
        self.cards += 1;
        node
    }

    /// Puts a card into the next place, so far in front of (positive) or behind it.
    pub(crate) fn behind(&mut self, card: &Card, material: usize, z: f32) -> usize {
        let mut attributes = Map::new();
        let order = [0, 1, 2, 0, 2, 3];
        let mut put = |sheet: &mut Self, name: &str, rows: Option<Vec<Vec<f32>>>| {
            if let Some(rows) = rows {
                let numbers: Vec<f32> = order.iter().flat_map(|&corner| rows[corner].clone()).collect();
                attributes.insert(name.to_owned(), sheet.numbers(&numbers, rows[0].len()).into());
            }
        };
        put(self, "POSITION", Some(card.corners.map(|row| row.to_vec()).to_vec()));
        put(self, "TEXCOORD_0", Some(card.uvs.map(|row| row.to_vec()).to_vec()));
        put(self, "COLOR_0", card.colors.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        put(self, "NORMAL", card.normals.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        put(self, "TANGENT", card.tangents.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        self.meshes.push(json!({ "primitives": [{ "attributes": attributes, "material": material }] }));
        self.nodes.push(json!({ "mesh": self.meshes.len() - 1, "translation": [self.cards, 0, z] }));
        self.nodes.len() - 1
    }

    /// Where the next card goes, metres.
    pub(crate) fn places(&self) -> f32 {
        self.cards as f32
    }

    /// Changes a property of a node.
    pub(crate) fn set(&mut self, node: usize, key: &str, value: Value) {
        self.nodes[node][key] = value;
    }

    /// Adds a node.
    pub(crate) fn node(&mut self, node: Value) {
        self.nodes.push(node);
    }

    /// Sets an extension of the whole file.
    pub(crate) fn extension(&mut self, name: &str, value: Value) {
        self.extensions.insert(name.to_owned(), value);
    }

    /// Adds a clip that moves one property of a node.
    pub(crate) fn animate(
        &mut self,
        node: usize,
        path: &str,
        (input, output): (usize, usize),
        interpolation: &str,
    ) {
        self.animations.push(json!({
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
        }));
    }

    /// What is seen in the middle of every card's place.
    pub(crate) fn look(self) -> Vec<[f32; 3]> {
        self.look_at(0.0)
    }

    /// The same at a time.
    pub(crate) fn look_at(mut self, time_seconds: f64) -> Vec<[f32; 3]> {
        let cards = self.cards as f32;
        let camera = json!({ "camera": 0, "translation": [(cards - 1.0) * 0.5, 0, 5] });
        self.nodes.push(camera);
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.blob));
        let mut file = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "cameras": [{ "type": "orthographic", "orthographic": { "xmag": cards * 0.5, "ymag": 0.5, "znear": 0.0, "zfar": 20.0 } }],
            "buffers": [{ "byteLength": self.blob.len(), "uri": uri }],
            "extensionsUsed": self.extensions_used,
        });
        let lists = [
            ("nodes", self.nodes),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
            ("images", self.images),
            ("textures", self.textures),
            ("samplers", self.samplers),
            ("animations", self.animations),
        ];
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            file[name] = list.into();
        }
        if !self.extensions.is_empty() {
            file["extensions"] = self.extensions.into();
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.gltf");
        std::fs::write(&path, file.to_string()).unwrap();
        let shot = shot_job(&ShotRequest { path: &path, suite: None, overrides: &[] }).unwrap();
        assert_eq!(shot.warnings, []);
        let job = shot.sequence;
        // Nor did any clip give way to another.
        assert_eq!(job.selection.clips.len(), job.scene.animations.len());
        let size = (self.cards as u32 * PIXELS, PIXELS);
        let window = PixelWindow::full(size.0, size.1);
        let settings = RenderSettings { resolution: size, window, samples: 1, ..job.render.clone() };
        let frame = Frame::at(&job.scene, &job.selection, time_seconds);
        let (film, _) = film_of(&job, &frame, &settings, &CancelFlag::new()).unwrap();
        let middle = |card: usize| {
            let place = (PIXELS / 2 * size.0 + card as u32 * PIXELS + PIXELS / 2) as usize;
            let [red, green, blue, _] = film.pixels[place];
            [red, green, blue]
        };
        (0..self.cards).map(middle).collect()
    }
}

/// Asserts that cards look alike, two by two.
#[track_caller]
pub(crate) fn assert_pairs(seen: &[[f32; 3]]) {
    assert!(seen.len().is_multiple_of(2) && !seen.is_empty());
    for (i, pair) in seen.chunks(2).enumerate() {
        assert_close(pair[0], pair[1], i);
    }
}

#[track_caller]
pub(crate) fn assert_close(seen: [f32; 3], expected: [f32; 3], card: usize) {
    let apart = seen.iter().zip(expected).any(|(seen, expected)| (seen - expected).abs() > 2.0e-3);
    assert!(!apart, "card {card}: {seen:?} is not {expected:?}");
}

/// The linear value of an sRGB one (IEC 61966-2-1).
pub(crate) fn linear(value: u8) -> f32 {
    let value = f64::from(value) / 255.0;
    let linear = if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) };
    linear as f32
}
