//! Scenes of `storage/`: one scene in every way that a file can pack geometry and images.
//!
//! The packed streams are made from `storage/plain` by `tests/oracles/storage_streams.mjs` with the encoders of the
//! formats' authors, without loss.

use base64::Engine as _;
use glam::{Vec2, Vec3};
use serde_json::Value;

use crate::{Entry, entry};
use scene_builder::accessor::{Use, bounds_of};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image, Wrap, opaque, texture};
use scene_builder::json::{Json, list, object};
use scene_builder::material::{Material, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{self, TriangleMesh, torus};
use scene_builder::staging::{grey_floor, lit_stage};

pub(crate) const SCENES: [Entry; 7] = [
    entry("storage/plain", plain),
    entry("storage/meshopt_ext", meshopt_ext),
    entry("storage/meshopt_khr", meshopt_khr),
    entry("storage/draco", draco),
    entry("storage/webp", webp),
    entry("storage/basis_uastc", basis_uastc),
    entry("storage/basis_etc1s", basis_etc1s),
];

const STREAMS: &str = include_str!("../../streams/ring.json");

/// An empty file for the ring; `how` describes its storage.
fn new(how: &'static str) -> Gltf {
    let mut gltf = Gltf::new(how);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.6, 2.4), Vec3::new(0.0, 0.25, 0.0), 36.0);
    grey_floor(&mut gltf, 6.0, 5.0);
    gltf
}

fn ring() -> TriangleMesh {
    let mut ring = torus(0.6, 0.25, 24, 12);
    for uv in &mut ring.uvs {
        *uv *= Vec2::new(2.0, 1.0);
    }
    ring
}

/// 8 by 4 cells of 4 by 4 texels, in colours that ETC1S holds exactly.
fn chequer() -> Image {
    Image::new(32, 16, |x, y| {
        opaque(if (x / 4 + y / 4).is_multiple_of(2) { [233, 200, 125] } else { [59, 92, 142] })
    })
}

fn painted(gltf: &mut Gltf, texture: usize) -> usize {
    let base_color_texture = Some(TextureUse::of(texture));
    Material { base_color_texture, ..Material::matte("chequer", [1.0; 3]) }.add_to(gltf)
}

fn place(gltf: &mut Gltf, mesh: usize) {
    gltf.node(Node::mesh(mesh).named("ring").at(0.0, 0.25, 0.0));
}

fn plain() -> Built {
    let mut gltf = new(
        "A ring with a chequer in two colours, stored without compression; the other scenes of this folder look the same.",
    );
    let texture = chequer().texture(&mut gltf, "chequer", Filter::Nearest)?;
    let material = painted(&mut gltf, texture);
    let mesh = ring().add_to(&mut gltf, material);
    place(&mut gltf, mesh);
    Ok(gltf)
}

/// A stream of `../../streams/ring.json`, by its keys.
fn stream(keys: &[&str]) -> Built<Vec<u8>> {
    let all: Value = serde_json::from_str(STREAMS)?;
    let text = keys.iter().fold(&all, |value, key| &value[key]).as_str().ok_or("no such stream")?;
    Ok(base64::engine::general_purpose::STANDARD.decode(text)?)
}

/// An accessor of the ring with its bounds if it has any; `view` holds the data unless an extension does.
fn accessor(
    gltf: &mut Gltf,
    (component, kind, count): (usize, &str, usize),
    view: Option<usize>,
    bounds: Option<(Vec<f32>, Vec<f32>)>,
) -> usize {
    let mut json =
        object([("componentType", component.into()), ("count", count.into()), ("type", kind.into())]);
    if let Some(view) = view {
        json.set("bufferView", view);
    }
    if let Some((min, max)) = bounds {
        json.set("min", list(min));
        json.set("max", list(max));
    }
    gltf.add("accessors", json)
}

fn position_bounds(ring: &TriangleMesh) -> (Vec<f32>, Vec<f32>) {
    let positions: Vec<f32> = ring.positions.iter().flat_map(Vec3::to_array).collect();
    bounds_of(&positions, 3)
}

fn meshopt_ext() -> Built {
    let mut gltf = new(
        "The ring in buffer views of EXT_meshopt_compression with the attribute codec's version 0; as storage/plain.",
    );
    meshopt(&mut gltf, "EXT_meshopt_compression", "v0")?;
    Ok(gltf)
}

fn meshopt_khr() -> Built {
    let mut gltf = new(
        "The ring in buffer views of KHR_meshopt_compression with the attribute codec's version 1; as storage/plain.",
    );
    meshopt(&mut gltf, "KHR_meshopt_compression", "v1")?;
    Ok(gltf)
}

fn meshopt(gltf: &mut Gltf, extension: &'static str, version: &str) -> Built<()> {
    gltf.requires_extension(extension);
    let texture = chequer().texture(gltf, "chequer", Filter::Nearest)?;
    let material = painted(gltf, texture);
    let ring = ring();
    let count = ring.positions.len();
    let mut place_of_next = 0;
    let mut view =
        |gltf: &mut Gltf, key: &str, mode: &str, (count, stride): (usize, usize)| -> Built<usize> {
            let stream = stream(&[version, key])?;
            let packed = gltf.append_bytes(&stream);
            let mut json = object([
                ("buffer", 1.into()),
                ("byteOffset", place_of_next.into()),
                ("byteLength", (count * stride).into()),
            ]);
            if mode == "ATTRIBUTES" {
                json.set("byteStride", stride);
            }
            let extension = (
                extension,
                object([
                    ("buffer", 0.into()),
                    ("byteOffset", packed.into()),
                    ("byteLength", stream.len().into()),
                    ("byteStride", stride.into()),
                    ("count", count.into()),
                    ("mode", mode.into()),
                ]),
            );
            json.set("extensions", object([extension]));
            place_of_next += (count * stride).next_multiple_of(4);
            Ok(gltf.add("bufferViews", json))
        };
    let positions = view(gltf, "positions", "ATTRIBUTES", (count, 12))?;
    let normals = view(gltf, "normals", "ATTRIBUTES", (count, 12))?;
    let uvs = view(gltf, "uvs", "ATTRIBUTES", (count, 8))?;
    let indices = view(gltf, "indices", "TRIANGLES", (ring.indices.len(), 2))?;
    gltf.placeholder_buffer(place_of_next, extension);
    let attributes = object([
        (
            "POSITION",
            accessor(gltf, (5126, "VEC3", count), Some(positions), Some(position_bounds(&ring))).into(),
        ),
        ("NORMAL", accessor(gltf, (5126, "VEC3", count), Some(normals), None).into()),
        ("TEXCOORD_0", accessor(gltf, (5126, "VEC2", count), Some(uvs), None).into()),
    ]);
    let indices = accessor(gltf, (5123, "SCALAR", ring.indices.len()), Some(indices), None);
    let mesh = shapes::mesh(gltf, attributes, indices, material);
    place(gltf, mesh);
    Ok(())
}

fn draco() -> Built {
    let mut gltf = new("The ring in a Draco stream without quantization; as storage/plain.");
    gltf.requires_extension("KHR_draco_mesh_compression");
    let texture = chequer().texture(&mut gltf, "chequer", Filter::Nearest)?;
    let material = painted(&mut gltf, texture);
    let all: Value = serde_json::from_str(STREAMS)?;
    let number = |key: &str| all["draco"][key].as_u64().map(|number| number as usize).ok_or("no such number");
    let (count, indices) = (number("vertices")?, number("indices")?);
    let view = gltf.buffer_view(&stream(&["draco", "stream"])?, Use::Other, None);
    let bounds = Some(position_bounds(&ring()));
    let attributes = object([
        ("POSITION", accessor(&mut gltf, (5126, "VEC3", count), None, bounds).into()),
        ("NORMAL", accessor(&mut gltf, (5126, "VEC3", count), None, None).into()),
        ("TEXCOORD_0", accessor(&mut gltf, (5126, "VEC2", count), None, None).into()),
    ]);
    let ids = object([
        ("POSITION", number("positions")?.into()),
        ("NORMAL", number("normals")?.into()),
        ("TEXCOORD_0", number("uvs")?.into()),
    ]);
    let packed = object([("bufferView", view.into()), ("attributes", ids)]);
    let primitive = object([
        ("attributes", attributes),
        ("indices", accessor(&mut gltf, (5123, "SCALAR", indices), None, None).into()),
        ("material", material.into()),
        ("extensions", object([("KHR_draco_mesh_compression", packed)])),
    ]);
    let mesh = gltf.add("meshes", object([("primitives", list([primitive]))]));
    place(&mut gltf, mesh);
    Ok(gltf)
}

fn webp() -> Built {
    let gltf = new("The ring with its chequer in a lossless WebP; as storage/plain.");
    packed_texture(gltf, "EXT_texture_webp", "image/webp", include_bytes!("../../streams/chequer.webp"))
}

fn basis_uastc() -> Built {
    let gltf = new(
        "The ring with its chequer in a KTX2 of Basis Universal UASTC blocks under Zstandard; as storage/plain.",
    );
    packed_texture(
        gltf,
        "KHR_texture_basisu",
        "image/ktx2",
        include_bytes!("../../streams/chequer_uastc.ktx2"),
    )
}

fn basis_etc1s() -> Built {
    let gltf = new("The ring with its chequer in a KTX2 of Basis Universal ETC1S; as storage/plain.");
    packed_texture(
        gltf,
        "KHR_texture_basisu",
        "image/ktx2",
        include_bytes!("../../streams/chequer_etc1s.ktx2"),
    )
}

/// The ring with an image that only `extension` can name; a PNG image of another colour is the fallback.
fn packed_texture(mut gltf: Gltf, extension: &'static str, kind: &str, bytes: &[u8]) -> Built {
    gltf.uses_extension(extension);
    let plain = Image::new(1, 1, |_, _| opaque([255, 0, 255])).add_to(&mut gltf, "fallback")?;
    let view = gltf.buffer_view(bytes, Use::Other, None);
    let image = gltf.add(
        "images",
        object([("name", "chequer".into()), ("mimeType", kind.into()), ("bufferView", view.into())]),
    );
    let texture = texture(&mut gltf, plain, Filter::Nearest, [Wrap::Repeat; 2]);
    let source: Json = object([("source", image.into())]);
    gltf.extend("textures", texture, object([(extension, source)]));
    let material = painted(&mut gltf, texture);
    let mesh = ring().add_to(&mut gltf, material);
    place(&mut gltf, mesh);
    Ok(gltf)
}
