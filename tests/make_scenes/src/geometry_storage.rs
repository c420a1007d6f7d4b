//! Scenes of `geometry/`: component types, strides and sparse storage.

use glam::Vec3;

use crate::geometry::{before_wall, paint, primitive_mesh};
use crate::{Entry, entry};
use scene_builder::accessor::{Accessor, Component, Use, float_bytes, position_accessor};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::{Json, list, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, torus, uv_sphere};
use scene_builder::staging::{grey_floor, lit_stage};

pub(crate) const SCENES: [Entry; 4] = [
    entry("geometry/quantized", quantized),
    entry("geometry/sparse", sparse),
    entry("geometry/no_buffer_view", no_buffer_view),
    entry("geometry/non_indexed", non_indexed),
];

fn quantized() -> Built {
    let mut gltf = Gltf::new(
        "Two equal rings with a fine chequer: the left one in floats, the right one with 16-bit positions (normalised), 8-bit \
         normals and 16-bit texture coordinates; the same shape, shading and pattern to the eye.",
    );
    gltf.requires_extension("KHR_mesh_quantization");
    lit_stage(&mut gltf, Vec3::new(0.0, 2.2, 4.2), Vec3::new(0.0, 0.3, 0.0), 32.0);
    grey_floor(&mut gltf, 9.0, 7.0);
    let chequer = scene_builder::image::Image::chequer(16, 8, [225, 200, 120], [60, 90, 140]);
    let texture = chequer.texture(&mut gltf, "chequer", scene_builder::image::Filter::Nearest)?;
    let mut ring = torus(0.6, 0.25, 32, 16);
    for uv in &mut ring.uvs {
        *uv *= glam::Vec2::new(8.0, 4.0);
    }
    let textured = |scale: [f32; 2]| Material {
        base_color_texture: Some(scene_builder::material::TextureUse {
            transform: (scale != [1.0; 2]).then_some(scene_builder::material::TextureTransform {
                offset: [0.0; 2],
                rotation_radians: 0.0,
                scale,
            }),
            ..scene_builder::material::TextureUse::of(texture)
        }),
        ..Material::matte("chequer", [1.0; 3])
    };
    let floats = textured([1.0; 2]).add_to(&mut gltf);
    let floats = ring.add_to(&mut gltf, floats);
    gltf.node(Node::mesh(floats).at(-1.0, 0.3, 0.0));
    // Normalised coordinates end at 1: the texture transform multiplies them back.
    let packed = textured([8.0, 4.0]).add_to(&mut gltf);
    let attributes = quantized_attributes(&mut gltf, &ring);
    let indices = gltf.indices(&ring.indices);
    let mesh = primitive_mesh(&mut gltf, attributes, Some(indices), packed, 4);
    gltf.node(Node::mesh(mesh).at(1.0, 0.3, 0.0));
    Ok(gltf)
}

/// Positions as fractions of 32767, normals of 127, coordinates of 65535 over (8, 4); rows padded to 4 bytes.
fn quantized_attributes(gltf: &mut Gltf, shape: &TriangleMesh) -> Json {
    let signed16 = |value: f32| libm::roundf(value * 32767.0) as i16;
    let signed8 = |value: f32| libm::roundf(value * 127.0) as i8;
    let positions: Vec<[i16; 3]> =
        shape.positions.iter().map(|position| position.to_array().map(signed16)).collect();
    let bytes =
        positions.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0].map(i16::to_le_bytes).concat()).collect();
    let bound = |start: i16, choose: fn(i16, i16) -> i16| -> Vec<f32> {
        (0..3).map(|axis| positions.iter().map(|p| p[axis]).fold(start, choose) as f32).collect()
    };
    let position = Accessor {
        normalized: true,
        byte_stride: Some(8),
        bounds: Some((bound(i16::MAX, Ord::min), bound(i16::MIN, Ord::max))),
        ..Accessor::new(Component::I16, "VEC3", positions.len(), bytes)
    };
    let bytes = shape
        .normals
        .iter()
        .flat_map(|normal| {
            let [x, y, z] = normal.to_array().map(|value| signed8(value) as u8);
            [x, y, z, 0]
        })
        .collect();
    let normal = Accessor {
        normalized: true,
        byte_stride: Some(4),
        ..Accessor::new(Component::I8, "VEC3", shape.normals.len(), bytes)
    };
    let fraction = |value: f32| (libm::roundf(value * 65535.0) as u16).to_le_bytes();
    let bytes =
        shape.uvs.iter().flat_map(|uv| [fraction(uv.x / 8.0), fraction(uv.y / 4.0)].concat()).collect();
    let uv = Accessor { normalized: true, ..Accessor::new(Component::U16, "VEC2", shape.uvs.len(), bytes) };
    object([
        ("POSITION", gltf.accessor(&position).into()),
        ("NORMAL", gltf.accessor(&normal).into()),
        ("TEXCOORD_0", gltf.accessor(&uv).into()),
    ])
}

fn sparse() -> Built {
    let mut gltf = Gltf::new(
        "A flat grid whose sparse accessor lifts three of its points: three equal tents in a diagonal row on the left; on \
         the right the grid without the replacement stays flat.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 2.4, 3.8), Vec3::new(0.0, 0.1, 0.0), 32.0);
    grey_floor(&mut gltf, 9.0, 7.0);
    let material = Material::matte("grid", [0.1, 0.4, 0.55]).two_sided().add_to(&mut gltf);
    let corners: Vec<Vec3> = (0..81)
        .map(|index| Vec3::new((index % 9) as f32 * 0.2 - 0.8, 0.1, (index / 9) as f32 * 0.2 - 0.8))
        .collect();
    let lifted = [20_u16, 40, 60];
    let values = lifted.iter().flat_map(|&index| {
        let corner = corners[index as usize];
        [corner.x, 0.6, corner.z]
    });
    let flat = position_accessor(&corners);
    let mut bounds = flat.bounds.clone();
    if let Some((_, greatest)) = &mut bounds {
        greatest[1] = 0.6;
    }
    let tents = Accessor { sparse: Some((lifted.to_vec(), float_bytes(values))), bounds, ..flat.clone() };
    let indices = gltf.indices(&scene_builder::shapes::grid_indices(8, 8, false));
    for (accessor, x) in [(tents, -1.0), (flat, 1.0)] {
        let attributes = object([("POSITION", gltf.accessor(&accessor).into())]);
        let mesh = primitive_mesh(&mut gltf, attributes, Some(indices), material, 4);
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}

fn no_buffer_view() -> Built {
    let mut gltf = Gltf::new(
        "A square whose positions have no buffer view, so that all are zero but those the sparse part replaces, which is \
         three of four corners: a whole square on the left; on the right the same square in black, by vertex colours from an \
         accessor of zeros.",
    );
    before_wall(&mut gltf);
    let material = paint(&mut gltf);
    let corners = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let position = Accessor {
        data: None,
        bounds: Some((vec![0.0; 3], vec![1.0, 1.0, 0.0])),
        sparse: Some((vec![1, 2, 3], float_bytes(corners.iter().flat_map(Vec3::to_array)))),
        ..Accessor::new(Component::F32, "VEC3", 4, Vec::new())
    };
    let position = gltf.accessor(&position);
    let zeros = Accessor { data: None, ..Accessor::new(Component::F32, "VEC3", 4, Vec::new()) };
    let zeros = gltf.accessor(&zeros);
    let indices = gltf.indices(&[0, 1, 2, 0, 2, 3]);
    let plain = object([("POSITION", position.into())]);
    let black = object([("POSITION", position.into()), ("COLOR_0", zeros.into())]);
    for (attributes, x) in [(plain, -1.5), (black, 0.5)] {
        let mesh = primitive_mesh(&mut gltf, attributes, Some(indices), material, 4);
        gltf.node(Node::mesh(mesh).at(x, 0.4, 0.0));
    }
    Ok(gltf)
}

fn non_indexed() -> Built {
    let mut gltf = Gltf::new(
        "The same ball three times: without indices, with 8-bit indices, and with 32-bit indices and interleaved attributes; \
         no difference.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 0.6, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 6.0);
    let material = paint(&mut gltf);
    let ball = uv_sphere(0.6, 12, 8).plain();
    // Every corner of every triangle on its own.
    let corner =
        |values: &[Vec3]| ball.indices.iter().map(|&index| values[index as usize]).collect::<Vec<_>>();
    let spread = object([
        ("POSITION", gltf.positions(&corner(&ball.positions)).into()),
        ("NORMAL", gltf.vec3s(&corner(&ball.normals)).into()),
    ]);
    let spread = primitive_mesh(&mut gltf, spread, None, material, 4);
    let attributes = ball.attributes(&mut gltf);
    let small: Vec<u8> = ball.indices.iter().map(|&index| index as u8).collect();
    let small = index_accessor(&mut gltf, Component::U8, ball.indices.len(), small);
    let small = primitive_mesh(&mut gltf, attributes, Some(small), material, 4);
    let wide: Vec<u8> = ball.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let wide = index_accessor(&mut gltf, Component::U32, ball.indices.len(), wide);
    let attributes = interleaved(&mut gltf, &ball);
    let wide = primitive_mesh(&mut gltf, attributes, Some(wide), material, 4);
    for (mesh, x) in [(spread, -1.4), (small, 0.0), (wide, 1.4)] {
        gltf.node(Node::mesh(mesh).at(x, 0.6, 0.0));
    }
    Ok(gltf)
}

fn index_accessor(gltf: &mut Gltf, component: Component, count: usize, data: Vec<u8>) -> usize {
    let accessor = Accessor { used_as: Use::Indices, ..Accessor::new(component, "SCALAR", count, data) };
    gltf.accessor(&accessor)
}

/// Positions and normals in one buffer view of 24 bytes a vertex.
fn interleaved(gltf: &mut Gltf, shape: &TriangleMesh) -> Json {
    let pairs = shape.positions.iter().zip(&shape.normals);
    let bytes =
        float_bytes(pairs.flat_map(|(position, normal)| [position.to_array(), normal.to_array()].concat()));
    let view = gltf.buffer_view(&bytes, Use::Vertices, Some(24));
    let (least, greatest) = position_accessor(&shape.positions).bounds.unwrap_or_default();
    let accessor = |byte_offset: usize| {
        object([
            ("bufferView", view.into()),
            ("byteOffset", byte_offset.into()),
            ("componentType", (Component::F32 as usize).into()),
            ("count", shape.positions.len().into()),
            ("type", "VEC3".into()),
        ])
    };
    let mut position = accessor(0);
    position.set("min", list(least));
    position.set("max", list(greatest));
    object([
        ("POSITION", gltf.add("accessors", position).into()),
        ("NORMAL", gltf.add("accessors", accessor(12)).into()),
    ])
}
