//! Scenes of `texture/` about texture lookup.

use std::f32::consts::FRAC_PI_6;

use glam::{Vec2, Vec3};

use crate::{Entry, entry};
use scene_builder::accessor::{Accessor, Component};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{self, Filter, Image, Wrap, opaque};
use scene_builder::json::{list, object};
use scene_builder::material::{Material, TextureTransform, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{self, TriangleMesh, quad};
use scene_builder::staging::directional_light;

pub(crate) const SCENES: [Entry; 6] = [
    entry("texture/base_color_srgb", base_color_srgb),
    entry("texture/wrap_modes", wrap_modes),
    entry("texture/nearest_filter", nearest_filter),
    entry("texture/transform", transform),
    entry("texture/two_uv_sets", two_uv_sets),
    entry("texture/vertex_color", vertex_color),
];

/// A camera that sees the rectangle of 3.2 by 1.8 around the origin.
pub(crate) fn face_on(gltf: &mut Gltf) {
    let camera = gltf.add("cameras", crate::camera::orthographic(1.6, 0.9));
    gltf.node(Node { camera: Some(camera), ..Node::default() }.at(0.0, 0.0, 3.0));
}

/// `material` with `texture` as its unlit base colour.
fn unlit_with(gltf: &mut Gltf, texture: TextureUse) -> usize {
    let material = Material { base_color_texture: Some(texture), ..Material::unlit("textured", [1.0; 3]) };
    material.add_to(gltf)
}

fn base_color_srgb() -> Built {
    let mut gltf = Gltf::new(
        "Four pairs of touching squares, each a texture of sRGB values above and the same colour as a linear factor \
         below: no seam can be seen within a pair.",
    );
    face_on(&mut gltf);
    // sRGB 188, 128, 64, 20 of 255 decode to these linear values (IEC 61966-2-1).
    let greys = [(188_u8, 0.50289), (128, 0.21586), (64, 0.05126), (20, 0.0069954)];
    let square = quad(0.7, 0.7);
    for (index, (stored, linear)) in greys.into_iter().enumerate() {
        let x = (index as f32 - 1.5) * 0.75;
        let texture =
            Image::new(2, 2, |_, _| opaque([stored; 3])).texture(&mut gltf, "grey", Filter::Linear)?;
        let above = unlit_with(&mut gltf, TextureUse::of(texture));
        let below = Material::unlit("factor", [linear; 3]).add_to(&mut gltf);
        let above = square.add_to(&mut gltf, above);
        let below = square.clone().plain().add_to(&mut gltf, below);
        gltf.node(Node::mesh(above).at(x, 0.35, 0.0));
        gltf.node(Node::mesh(below).at(x, -0.35, 0.0));
    }
    Ok(gltf)
}

fn wrap_modes() -> Built {
    let mut gltf = Gltf::new(
        "The letter F with coordinates from −1 to 2: columns repeat, mirror and clamp sideways; the upper row repeats \
         downwards, the lower one mirrors.",
    );
    face_on(&mut gltf);
    let image = Image::letter_f(32).add_to(&mut gltf, "F")?;
    let mut card = quad(0.85, 0.85);
    for uv in &mut card.uvs {
        *uv = *uv * 3.0 - Vec2::ONE;
    }
    let sideways = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    for (row, down) in [Wrap::Repeat, Wrap::MirroredRepeat].into_iter().enumerate() {
        for (column, across) in sideways.into_iter().enumerate() {
            let texture = image::texture(&mut gltf, image, Filter::Nearest, [across, down]);
            let material = unlit_with(&mut gltf, TextureUse::of(texture));
            let mesh = card.add_to(&mut gltf, material);
            gltf.node(Node::mesh(mesh).at(column as f32 * 0.95 - 0.95, 0.44 - 0.88 * row as f32, 0.0));
        }
    }
    Ok(gltf)
}

fn nearest_filter() -> Built {
    let mut gltf = Gltf::new(
        "The same four by four texels twice: as hard squares on the left, as soft blobs on the right, where the outer \
         half texel blends with the opposite side.",
    );
    face_on(&mut gltf);
    let image = Image::new(4, 4, |x, y| {
        [(x * 80) as u8, (y * 80) as u8, if (x + y) % 2 == 0 { 200 } else { 20 }, 255]
    });
    let image = image.add_to(&mut gltf, "texels")?;
    for (filter, x) in [(Filter::Nearest, -0.8), (Filter::Linear, 0.8)] {
        let texture = image::texture(&mut gltf, image, filter, [Wrap::Repeat; 2]);
        let material = unlit_with(&mut gltf, TextureUse::of(texture));
        let mesh = quad(1.5, 1.5).add_to(&mut gltf, material);
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}

fn transform() -> Built {
    let mut gltf = Gltf::new(
        "The letter F as it is; moved left by a quarter and up by a half; turned counter-clockwise by 30° about its top \
         left corner; at half size; and all three at once.",
    );
    face_on(&mut gltf);
    let texture = Image::letter_f(32).texture(&mut gltf, "F", Filter::Nearest)?;
    let (still, unit) = ([0.0; 2], [1.0; 2]);
    let transforms = [
        None,
        Some(([0.25, 0.5], 0.0, unit)),
        Some((still, FRAC_PI_6, unit)),
        Some((still, 0.0, [2.0, 2.0])),
        Some(([0.25, 0.5], FRAC_PI_6, [2.0, 2.0])),
    ];
    let card = quad(0.58, 0.58);
    for (index, values) in transforms.into_iter().enumerate() {
        let transform = values.map(|(offset, rotation_radians, scale)| TextureTransform {
            offset,
            rotation_radians,
            scale,
        });
        let material = unlit_with(&mut gltf, TextureUse { transform, ..TextureUse::of(texture) });
        let mesh = card.add_to(&mut gltf, material);
        gltf.node(Node::mesh(mesh).at((index as f32 - 2.0) * 0.63, 0.0, 0.0));
    }
    Ok(gltf)
}

fn two_uv_sets() -> Built {
    let mut gltf = Gltf::new(
        "A card whose base colour, a large F, uses the first set of coordinates and whose glow, a fine blue chequer, uses \
         the second, which is turned by 45° about the middle.",
    );
    face_on(&mut gltf);
    directional_light(&mut gltf, Vec3::Z, 2.5);
    let letter = Image::letter_f(32).texture(&mut gltf, "F", Filter::Nearest)?;
    let chequer =
        Image::chequer(16, 2, [0, 0, 0], [0, 40, 160]).texture(&mut gltf, "chequer", Filter::Nearest)?;
    let material = Material {
        base_color_texture: Some(TextureUse::of(letter)),
        emissive: [1.0; 3],
        emissive_texture: Some(TextureUse { uv_set: 1, ..TextureUse::of(chequer) }),
        ..Material::matte("card", [1.0; 3])
    };
    let material = material.add_to(&mut gltf);
    let card = quad(1.7, 1.7);
    let mut attributes = card.attributes(&mut gltf);
    let turned: Vec<Vec2> = card
        .uvs
        .iter()
        .map(|uv| Vec2::new(uv.x - uv.y, uv.x + uv.y - 1.0) * 0.70710677 + Vec2::splat(0.5))
        .collect();
    attributes.set("TEXCOORD_1", gltf.vec2s(&turned));
    let indices = gltf.indices(&card.indices);
    let mesh = shapes::mesh(&mut gltf, attributes, indices, material);
    gltf.node(Node::mesh(mesh));
    Ok(gltf)
}

fn vertex_color() -> Built {
    let mut gltf = Gltf::new(
        "Two cards whose corners are red, green, blue and yellow with straight blends in linear light: bytes with alpha \
         on the left, floats without alpha on the right, halved by the material's grey; the left one's upper corners \
         fade into the wall.",
    );
    face_on(&mut gltf);
    let wall = Material::unlit("wall", [0.3; 3]).add_to(&mut gltf);
    let wall = quad(4.0, 3.0).plain().add_to(&mut gltf, wall);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -0.5));
    // From the lower left counter-clockwise.
    let colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 0], [255, 255, 0, 0_u8]];
    let card: TriangleMesh = quad(1.4, 1.4).plain();
    let indices = gltf.indices(&card.indices);
    let blend =
        Material { alpha: scene_builder::material::Alpha::Blend, ..Material::unlit("bytes", [1.0; 3]) };
    let blend = blend.add_to(&mut gltf);
    let halved = Material::unlit("floats", [0.5; 3]).add_to(&mut gltf);
    let bytes = gltf.bytes4(&colors, true);
    let floats =
        colors.map(|[red, green, blue, _]| [red, green, blue].map(|value| value as f32 / 255.0)).concat();
    let floats = scene_builder::accessor::float_bytes(floats);
    let floats = gltf.accessor(&Accessor::new(Component::F32, "VEC3", 4, floats));
    for (x, color, material) in [(-0.8, bytes, blend), (0.8, floats, halved)] {
        let mut attributes = card.attributes(&mut gltf);
        attributes.set("COLOR_0", color);
        let primitive =
            object([("attributes", attributes), ("indices", indices.into()), ("material", material.into())]);
        let mesh = gltf.add("meshes", object([("primitives", list([primitive]))]));
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}
