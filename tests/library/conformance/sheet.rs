//! A glTF file of cards in a row, and the colour at the centre of each.

use rayframe::cancel::CancelFlag;
use rayframe::film::PixelWindow;
use rayframe::frame::Frame;
use rayframe::render::RenderSettings;
use rayframe::sequence::render_single_frame;
use rayframe::shot::{ShotRequest, shot_job};
use scene_builder::accessor::{Accessor, Component, Use, bounds_of, float_bytes};
use scene_builder::document::Gltf;
use scene_builder::image::Image;
use serde_json::{Map, Value, json};

/// Width and height of a slot, pixels. A slot is one square metre with a card in its centre.
const PIXELS: u32 = 64;

/// A row of cards under construction.
pub(crate) struct Sheet {
    gltf: Gltf,
    cards: usize,
    animations: usize,
}

/// A square of 0.8 m that faces the camera.
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
    /// A card whose texture coordinates are all close to (`u`, `v`).
    pub(crate) fn at_uv(u: f32, v: f32) -> Self {
        // A small area, so that the ray differentials are not zero.
        let d = 1.0e-3;
        Self { uvs: [[u - d, v + d], [u + d, v + d], [u + d, v - d], [u - d, v - d]], ..Self::default() }
    }
}

/// An unlit material with `value` as its `pbrMetallicRoughness`.
pub(crate) fn unlit(value: &Value) -> Value {
    json!({ "pbrMetallicRoughness": value, "extensions": { "KHR_materials_unlit": {} } })
}

#[expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that cannot go on may panic")]
impl Sheet {
    pub(crate) fn new(extensions_used: &[&'static str]) -> Self {
        let mut gltf = Gltf::new("A row of cards.");
        for name in extensions_used.iter().chain(&["KHR_materials_unlit"]) {
            gltf.uses_extension(name);
        }
        Self { gltf, cards: 0, animations: 0 }
    }

    /// Adds a material; returns its index.
    pub(crate) fn material(&mut self, material: Value) -> usize {
        self.gltf.add("materials", material.into())
    }

    /// Adds a texture of `texels`, `width` a row; returns its index.
    pub(crate) fn texture(&mut self, width: u32, texels: &[[u8; 4]], sampler: Value) -> usize {
        let height = texels.len() as u32 / width;
        let image = Image::new(width, height, |x, y| texels[(y * width + x) as usize]);
        let image = image.add_to(&mut self.gltf, "texels").unwrap();
        let sampler = self.gltf.add("samplers", sampler.into());
        self.gltf.add("textures", json!({ "source": image, "sampler": sampler }).into())
    }

    /// Adds floats, `width` an element; returns the index of the accessor.
    pub(crate) fn floats(&mut self, floats: &[f32], width: usize) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        let data = float_bytes(floats.iter().copied());
        let mut accessor = Accessor::new(Component::F32, kind, floats.len() / width, data);
        accessor.used_as = Use::Other;
        accessor.bounds = Some(bounds_of(floats, width));
        self.gltf.accessor(&accessor)
    }

    /// Adds a card at the end of the row; returns the index of its node.
    pub(crate) fn card(&mut self, card: &Card, material: usize) -> usize {
        let node = self.card_at(card, material, 0.0);
        self.cards += 1;
        node
    }

    /// Adds a card to the next slot, `z` metres in front of its plane, or behind it if negative.
    pub(crate) fn card_at(&mut self, card: &Card, material: usize, z: f32) -> usize {
        let mut attributes = Map::new();
        let order = [0, 1, 2, 0, 2, 3];
        let mut put = |sheet: &mut Self, name: &str, rows: Option<Vec<Vec<f32>>>| {
            if let Some(rows) = rows {
                let floats: Vec<f32> = order.iter().flat_map(|&corner| rows[corner].clone()).collect();
                attributes.insert(name.to_owned(), sheet.floats(&floats, rows[0].len()).into());
            }
        };
        put(self, "POSITION", Some(card.corners.map(|row| row.to_vec()).to_vec()));
        put(self, "TEXCOORD_0", Some(card.uvs.map(|row| row.to_vec()).to_vec()));
        put(self, "COLOR_0", card.colors.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        put(self, "NORMAL", card.normals.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        put(self, "TANGENT", card.tangents.map(|rows| rows.map(|row| row.to_vec()).to_vec()));
        let mesh = json!({ "primitives": [{ "attributes": attributes, "material": material }] });
        let mesh = self.gltf.add("meshes", mesh.into());
        self.gltf.add("nodes", json!({ "mesh": mesh, "translation": [self.cards, 0, z] }).into())
    }

    /// X of the centre of the next slot, metres.
    pub(crate) fn next_x(&self) -> f32 {
        self.cards as f32
    }

    /// Sets a property of a node.
    pub(crate) fn set(&mut self, node: usize, key: &str, value: Value) {
        self.gltf.set("nodes", node, key, value);
    }

    /// Adds a node.
    pub(crate) fn node(&mut self, node: Value) {
        self.gltf.add("nodes", node.into());
    }

    /// Adds an extension object of the whole file.
    pub(crate) fn extension(&mut self, name: &'static str, value: Value) {
        self.gltf.extension(name, value.into());
    }

    /// Adds a clip of one property of a node; `times` and `values` are accessors.
    pub(crate) fn animate(
        &mut self,
        node: usize,
        path: &str,
        times: usize,
        values: usize,
        interpolation: &str,
    ) {
        let clip = json!({
            "samplers": [{ "input": times, "output": values, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
        });
        self.gltf.add("animations", clip.into());
        self.animations += 1;
    }

    /// Renders the sheet at time 0; returns the colour at the centre of every slot.
    pub(crate) fn look(self) -> Vec<[f32; 3]> {
        self.look_at(0.0)
    }

    /// Renders the sheet at a time; returns the colour at the centre of every slot.
    pub(crate) fn look_at(mut self, time_seconds: f64) -> Vec<[f32; 3]> {
        let cards = self.cards as f32;
        let lens = json!({ "xmag": cards * 0.5, "ymag": 0.5, "znear": 0.0, "zfar": 20.0 });
        let camera = self.gltf.add("cameras", json!({ "type": "orthographic", "orthographic": lens }).into());
        self.node(json!({ "camera": camera, "translation": [(cards - 1.0) * 0.5, 0, 5] }));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.gltf");
        std::fs::write(&path, self.gltf.to_file_text()).unwrap();
        let shot = shot_job(&ShotRequest { path: &path, suite: None, overrides: &[] }).unwrap();
        assert_eq!(shot.warnings, []);
        let job = shot.sequence;
        // All clips play; none replaces another.
        assert_eq!(job.selection.clips.len(), self.animations);
        let size = (self.cards as u32 * PIXELS, PIXELS);
        let window = PixelWindow::full(size.0, size.1);
        let settings = RenderSettings { resolution: size, window, samples: 1, ..job.render.clone() };
        let frame = Frame::at(&job.scene, &job.selection, time_seconds);
        let (film, _) = render_single_frame(&job, &frame, &settings, &CancelFlag::new()).unwrap();
        let center = |card: usize| {
            let pixel = (PIXELS / 2 * size.0 + card as u32 * PIXELS + PIXELS / 2) as usize;
            let [red, green, blue, _] = film.pixels[pixel];
            [red, green, blue]
        };
        (0..self.cards).map(center).collect()
    }
}

/// Asserts that cards have equal colours, two by two.
#[track_caller]
pub(crate) fn assert_pairs(seen: &[[f32; 3]]) {
    assert!(seen.len().is_multiple_of(2) && !seen.is_empty());
    for (i, pair) in seen.chunks(2).enumerate() {
        assert_close(pair[0], pair[1], i);
    }
}

/// Asserts that the colour of a card is `expected` within 0.002.
#[track_caller]
pub(crate) fn assert_close(seen: [f32; 3], expected: [f32; 3], card: usize) {
    let apart = seen.iter().zip(expected).any(|(seen, expected)| (seen - expected).abs() > 2.0e-3);
    assert!(!apart, "card {card}: {seen:?} is not {expected:?}");
}

/// The linear value of an sRGB byte (IEC 61966-2-1).
pub(crate) fn linear(value: u8) -> f32 {
    let value = f64::from(value) / 255.0;
    let linear = if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) };
    linear as f32
}
