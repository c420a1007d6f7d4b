//! Scenes of `showcase/`: an interior, a game level, a character, an object and a product, without cameras. Documentation
//! and tests of the automatic camera use them.

mod apartment;
mod bottle;
mod character;
mod character_body;
mod furniture;
mod helmet;
mod level;
mod level_parts;
mod solids;

use std::f32::consts::PI;

use glam::{Quat, Vec3, Vec4};

use crate::{Entry, entry};
use scene_builder::accessor::{Accessor, Component};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Image, byte, opaque};
use scene_builder::json::{Json, list, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::TriangleMesh;

pub(crate) const SCENES: [Entry; 5] = [
    entry("showcase/apartment", apartment::apartment),
    entry("showcase/bottle", bottle::bottle),
    entry("showcase/character", character::character),
    entry("showcase/helmet", helmet::helmet),
    entry("showcase/level", level::level),
];

/// Meshes with the materials of their primitives.
pub(crate) type Parts = Vec<(TriangleMesh, usize)>;

/// A scene under construction, whose nodes are children of one root.
struct Stage {
    gltf: Gltf,
    nodes: Vec<usize>,
    /// Whether normals are bytes, which is enough for surfaces that reflect no images.
    is_matte: bool,
}

impl Stage {
    fn new(shows: &'static str) -> Self {
        Self { gltf: Gltf::new(shows), nodes: Vec::new(), is_matte: false }
    }

    fn matte(shows: &'static str) -> Self {
        Self { is_matte: true, ..Self::new(shows) }
    }

    /// Adds a mesh of one primitive a part.
    fn mesh(&mut self, parts: &[(TriangleMesh, usize)]) -> usize {
        let primitives: Vec<_> = parts
            .iter()
            .map(|(shape, material)| {
                let shape = solids::compact(shape);
                let attributes = if self.is_matte {
                    matte_attributes(&mut self.gltf, &shape)
                } else {
                    shape.attributes(&mut self.gltf)
                };
                let indices = self.gltf.indices(&shape.indices);
                object([
                    ("attributes", attributes),
                    ("indices", indices.into()),
                    ("material", (*material).into()),
                ])
            })
            .collect();
        self.gltf.add("meshes", object([("primitives", list(primitives))]))
    }

    /// Adds a node with a mesh, turned about Y.
    fn stand(&mut self, name: &'static str, mesh: usize, at: [f32; 3], degrees: f32) {
        let mut node = Node::mesh(mesh).named(name);
        if at != [0.0; 3] {
            node = node.at(at[0], at[1], at[2]);
        }
        if degrees != 0.0 {
            node = node.turned(Quat::from_rotation_y(degrees.to_radians()));
        }
        let node = self.gltf.node(node);
        self.nodes.push(node);
    }

    /// Adds a node with a mesh, moved and rotated.
    fn pose(&mut self, name: &'static str, mesh: usize, at: Vec3, rotation: Quat) {
        let node = self.gltf.node(Node::mesh(mesh).named(name).at(at.x, at.y, at.z).turned(rotation));
        self.nodes.push(node);
    }

    /// Adds a node with a mesh, turned about Y and scaled.
    fn stand_scaled(&mut self, name: &'static str, mesh: usize, at: [f32; 3], degrees: f32, scale: f32) {
        let node = Node::mesh(mesh).named(name).at(at[0], at[1], at[2]).scaled(scale, scale, scale);
        let node = self.gltf.node(node.turned(Quat::from_rotation_y(degrees.to_radians())));
        self.nodes.push(node);
    }

    /// Adds a mesh and its node.
    fn add(&mut self, name: &'static str, parts: &[(TriangleMesh, usize)], at: [f32; 3], degrees: f32) {
        let mesh = self.mesh(parts);
        self.stand(name, mesh, at, degrees);
    }

    /// Adds a point light, in candela.
    fn lamp(&mut self, name: &'static str, color: u32, candela: f32, at: [f32; 3]) {
        let light = scene_builder::staging::light(&mut self.gltf, "point", srgb(color), candela);
        let node = Node { light: Some(light), ..Node::default() }.named(name).at(at[0], at[1], at[2]);
        let node = self.gltf.node(node);
        self.nodes.push(node);
    }

    /// Adds a directional light, in lux, that shines from `from` towards the origin.
    fn sun(&mut self, color: u32, lux: f32, from: Vec3) {
        let light = scene_builder::staging::light(&mut self.gltf, "directional", srgb(color), lux);
        let rotation = scene_builder::staging::looking(from, Vec3::ZERO);
        let node =
            self.gltf.node(Node { light: Some(light), ..Node::default() }.named("sun").turned(rotation));
        self.nodes.push(node);
    }

    /// The scene with its root and an environment of `EXT_lights_image_based`: radiance `above` and `below`, linear between.
    fn finished(mut self, name: &'static str, above: Vec3, below: Vec3) -> Built {
        let root = self.gltf.node(Node::group(&self.nodes).named(name));
        let scene = self.gltf.scene(name, &[root]);
        let middle = (above + below) / 2.0;
        let radiance = |height: f32| middle + (above - below) / 2.0 * height;
        let mut faces = Vec::new();
        for face in 0..6 {
            faces.push(gradient_face(face, radiance).add_to(&mut self.gltf, "sky")?);
        }
        // Radiance a + b·y gives the irradiance π a + 2π/3 b·y; the basis is that of Ramamoorthi and Hanrahan.
        let mut coefficients = vec![list([0.0; 3]); 9];
        coefficients[0] = list((middle * (PI / (0.5 / PI.sqrt()))).to_array());
        let slope = (above - below) / 2.0;
        coefficients[1] = list((slope * (2.0 * PI / 3.0 / (3.0 / (4.0 * PI)).sqrt())).to_array());
        let light = object([
            ("intensity", 1.0.into()),
            ("irradianceCoefficients", list(coefficients)),
            ("specularImageSize", (FACE_SIZE as usize).into()),
            ("specularImages", list([list(faces)])),
        ]);
        self.gltf.uses_extension("EXT_lights_image_based");
        self.gltf.extension("EXT_lights_image_based", object([("lights", list([light]))]));
        let selected = object([("EXT_lights_image_based", object([("light", 0.into())]))]);
        self.gltf.extend("scenes", scene, selected);
        Ok(self.gltf)
    }
}

/// The attributes of a mesh with normals of four bytes (`KHR_mesh_quantization`).
fn matte_attributes(gltf: &mut Gltf, shape: &TriangleMesh) -> Json {
    let mut attributes = TriangleMesh { normals: Vec::new(), ..shape.clone() }.attributes(gltf);
    if !shape.normals.is_empty() {
        gltf.requires_extension("KHR_mesh_quantization");
        let bytes = shape.normals.iter().flat_map(|normal| {
            let [x, y, z] = normal.to_array().map(|value| (value * 127.0).round() as i8 as u8);
            [x, y, z, 0]
        });
        let accessor = Accessor::new(Component::I8, "VEC3", shape.normals.len(), bytes.collect());
        let accessor = Accessor { normalized: true, byte_stride: Some(4), ..accessor };
        attributes.set("NORMAL", gltf.accessor(&accessor));
    }
    attributes
}

/// The colour at `position` between the sRGB colours of the two nearest stops.
fn gradient(stops: &[(f32, u32)], position: f32) -> Vec4 {
    let above = stops.iter().position(|stop| stop.0 >= position).unwrap_or(stops.len() - 1).max(1);
    let [(low, first), (high, last)] = [stops[above - 1], stops[above]];
    let share = ((position - low) / (high - low)).clamp(0.0, 1.0);
    Vec3::from_array(srgb(first)).lerp(Vec3::from_array(srgb(last)), share).extend(1.0)
}

/// Texels along an edge of a cube face.
const FACE_SIZE: u32 = 8;

/// A face of a cube map whose radiance depends on the height of a direction, in OpenGL's order.
fn gradient_face(face: usize, radiance: impl Fn(f32) -> Vec3) -> Image {
    Image::new(FACE_SIZE, FACE_SIZE, |x, y| {
        let coordinate = |texel: u32| (texel as f32 + 0.5) / FACE_SIZE as f32 * 2.0 - 1.0;
        let (right, up) = (coordinate(x), -coordinate(y));
        let length = (1.0 + right * right + up * up).sqrt();
        let height = match face {
            2 => 1.0,
            3 => -1.0,
            _ => up,
        };
        opaque(radiance(height / length).to_array().map(|channel| byte(encoded(channel))))
    })
}

/// The linear colour of an sRGB colour 0xRRGGBB.
fn srgb(color: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| {
        let value = (color >> shift & 255) as f32 / 255.0;
        if value <= 0.04045 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) }
    })
}

/// The sRGB encoding of a linear value.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}

/// A dielectric of an sRGB colour.
fn paint(name: &'static str, color: u32, roughness: f32) -> Material {
    Material { roughness, ..Material::matte(name, srgb(color)) }
}

/// A metal of an sRGB colour.
fn metal(name: &'static str, color: u32, roughness: f32) -> Material {
    Material::metal(name, srgb(color), roughness)
}

/// A number from 0 to 1 that looks random.
fn noise(index: u32) -> f32 {
    let mut bits = index.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
    bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    (bits ^ bits >> 16) as f32 / u32::MAX as f32
}
