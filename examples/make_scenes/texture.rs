//! Scenes of `texture/`.

use std::f32::consts::{FRAC_PI_6, TAU};

use glam::{Vec2, Vec3, Vec4};

use super::gltf_builder::{Accessor, Built, Component, Gltf, Node};
use super::json::{list, object};
use super::materials::{Material, TextureTransform, TextureUse};
use super::pictures::{self, Filter, Picture, Wrap, opaque};
use super::shapes::{self, Shape, cylinder, quad};
use super::stage::{camera, chequered_floor, directional_light, grey_floor};
use super::{Entry, entry};

pub(crate) const SCENES: [Entry; 11] = [
    entry("texture/base_color_srgb", base_color_srgb),
    entry("texture/wrap_modes", wrap_modes),
    entry("texture/nearest_filter", nearest_filter),
    entry("texture/transform", transform),
    entry("texture/normal_map", normal_map),
    entry("texture/normal_map_mirrored_uv", normal_map_mirrored_uv),
    entry("texture/metallic_roughness", metallic_roughness),
    entry("texture/occlusion", occlusion),
    entry("texture/emissive", emissive),
    entry("texture/two_uv_sets", two_uv_sets),
    entry("texture/vertex_color", vertex_color),
];

/// A camera that sees the rectangle of 3.2 by 1.8 around the origin.
fn face_on(gltf: &mut Gltf) {
    let camera = gltf.add("cameras", super::camera::orthographic(1.6, 0.9));
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
            Picture::new(2, 2, |_, _| opaque([stored; 3])).texture(&mut gltf, "grey", Filter::Linear)?;
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
    let image = Picture::letter_f(32).add_to(&mut gltf, "F")?;
    let mut card = quad(0.85, 0.85);
    for uv in &mut card.uvs {
        *uv = *uv * 3.0 - Vec2::ONE;
    }
    let sideways = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    for (row, down) in [Wrap::Repeat, Wrap::MirroredRepeat].into_iter().enumerate() {
        for (column, across) in sideways.into_iter().enumerate() {
            let texture = pictures::texture(&mut gltf, image, Filter::Nearest, [across, down]);
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
    let image = Picture::new(4, 4, |x, y| {
        [(x * 80) as u8, (y * 80) as u8, if (x + y) % 2 == 0 { 200 } else { 20 }, 255]
    });
    let image = image.add_to(&mut gltf, "texels")?;
    for (filter, x) in [(Filter::Nearest, -0.8), (Filter::Linear, 0.8)] {
        let texture = pictures::texture(&mut gltf, image, filter, [Wrap::Repeat; 2]);
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
    let texture = Picture::letter_f(32).texture(&mut gltf, "F", Filter::Nearest)?;
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

/// Three by three round bumps as a normal map.
fn bumps(gltf: &mut Gltf) -> Built<usize> {
    let map = Picture::normal_map(96, |u, v| {
        let (x, y) = (u * 3.0 - libm::floorf(u * 3.0) - 0.5, v * 3.0 - libm::floorf(v * 3.0) - 0.5);
        let distance = libm::sqrtf(x * x + y * y);
        if distance > 0.4 || distance < 0.001 {
            return [0.0; 2];
        }
        // The slope of a cosine bump.
        let slope = -libm::sinf(distance / 0.4 * TAU / 2.0) * 1.2;
        [slope * x / distance, slope * y / distance]
    });
    map.texture(gltf, "bumps", Filter::Linear)
}

fn bumpy(gltf: &mut Gltf, scale: f32) -> Built<usize> {
    let texture = bumps(gltf)?;
    let material = Material {
        normal_texture: Some(TextureUse { amount: Some(scale), ..TextureUse::of(texture) }),
        roughness: 0.6,
        ..Material::matte("bumpy", [0.55, 0.5, 0.45])
    };
    Ok(material.add_to(gltf))
}

fn normal_map() -> Built {
    let mut gltf = Gltf::new(
        "Two cards with nine round bumps each, lit from the upper left: bright at the upper left of every bump, dark at \
         the lower right. The left card brings its tangents, the right one leaves them to be computed; both look the same.",
    );
    face_on(&mut gltf);
    directional_light(&mut gltf, Vec3::new(-1.0, 1.0, 0.8), 3.0);
    let material = bumpy(&mut gltf, 1.0)?;
    let card = quad(1.45, 1.45);
    for (x, with_tangents) in [(-0.8, true), (0.8, false)] {
        let mut attributes = card.attributes(&mut gltf);
        if with_tangents {
            attributes.set("TANGENT", gltf.vec4s(&[Vec4::new(1.0, 0.0, 0.0, 1.0); 4]));
        }
        let indices = gltf.indices(&card.indices);
        let mesh = shapes::mesh(&mut gltf, attributes, indices, material);
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}

fn normal_map_mirrored_uv() -> Built {
    let mut gltf = Gltf::new(
        "Three cards of bumps lit from the upper left: plain, with mirrored coordinates, and with a mirroring scale of \
         the node; on all three every bump is raised and bright at its upper left.",
    );
    face_on(&mut gltf);
    directional_light(&mut gltf, Vec3::new(-1.0, 1.0, 0.8), 3.0);
    let material = bumpy(&mut gltf, 1.0)?;
    let card = quad(0.98, 0.98);
    let mut mirrored = card.clone();
    for uv in &mut mirrored.uvs {
        uv.x = 1.0 - uv.x;
    }
    let plain = card.add_to(&mut gltf, material);
    let mirrored = mirrored.add_to(&mut gltf, material);
    gltf.node(Node::mesh(plain).at(-1.03, 0.0, 0.0));
    gltf.node(Node::mesh(mirrored).named("mirrored coordinates"));
    gltf.node(Node::mesh(plain).named("mirrored node").at(1.03, 0.0, 0.0).scaled(-1.0, 1.0, 1.0));
    Ok(gltf)
}

fn metallic_roughness() -> Built {
    let mut gltf = Gltf::new(
        "An upright drum with four rings: from the top rough plastic, smooth plastic, rough metal and mirror metal, in \
         one red; the texture's red channel, full of noise, changes nothing.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.3, 5.0), Vec3::new(0.0, 0.95, 0.0), 28.0);
    chequered_floor(&mut gltf, [14, 10], 0.5);
    let map = Picture::new(4, 4, |x, y| {
        let roughness = if y % 2 == 0 { 204 } else { 0 };
        let metallic = if y < 2 { 0 } else { 255 };
        [((x * 7 + y * 5) % 4 * 85) as u8, roughness, metallic, 255]
    });
    let texture = map.texture(&mut gltf, "roughness and metal", Filter::Nearest)?;
    let material = Material {
        metallic: 1.0,
        roughness: 1.0,
        metallic_roughness_texture: Some(TextureUse::of(texture)),
        ..Material::matte("rings", [0.75, 0.1, 0.08])
    };
    let material = material.add_to(&mut gltf);
    let drum = cylinder(0.8, 1.8, 48).add_to(&mut gltf, material);
    gltf.node(Node::mesh(drum).at(0.0, 0.92, 0.0));
    Ok(gltf)
}

fn occlusion() -> Built {
    let mut gltf = Gltf::new(
        "Three white cards under the studio whose occlusion texture is dark in stripes: strength 0 shows none, 0.5 faint \
         ones, 1 clear ones; the key light fills them all evenly.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.9, 4.6), Vec3::new(0.0, 0.7, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let stripes = Picture::new(8, 8, |x, _| opaque(if x % 2 == 0 { [255, 9, 9] } else { [0, 240, 240] }));
    let texture = stripes.texture(&mut gltf, "occlusion", Filter::Nearest)?;
    for (x, strength) in [(-1.25, 0.0), (0.0, 0.5), (1.25, 1.0)] {
        let material = Material {
            occlusion_texture: Some(TextureUse { amount: Some(strength), ..TextureUse::of(texture) }),
            ..Material::matte("striped", [0.8; 3])
        };
        let material = material.add_to(&mut gltf);
        let card = quad(1.1, 1.2).add_to(&mut gltf, material);
        gltf.node(Node::mesh(card).at(x, 0.7, 0.0));
    }
    Ok(gltf)
}

fn emissive() -> Built {
    let mut gltf = Gltf::new(
        "A dark grey card with a glowing chequer, orange as factor times texture; between the glowing squares the card \
         is lit like the floor.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.9, 4.0), Vec3::new(0.0, 0.7, 0.0), 32.0);
    directional_light(&mut gltf, Vec3::new(1.0, 1.5, 1.0), 2.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let chequer = Picture::chequer(8, 2, [255, 255, 255], [0, 0, 0]);
    let texture = chequer.texture(&mut gltf, "glow", Filter::Nearest)?;
    let material = Material {
        emissive: [0.9, 0.4, 0.05],
        emissive_texture: Some(TextureUse::of(texture)),
        ..Material::matte("card", [0.1; 3])
    };
    let material = material.add_to(&mut gltf);
    let card = quad(1.3, 1.3).add_to(&mut gltf, material);
    gltf.node(Node::mesh(card).at(0.0, 0.7, 0.0));
    Ok(gltf)
}

fn two_uv_sets() -> Built {
    let mut gltf = Gltf::new(
        "A card whose base colour, a large F, uses the first set of coordinates and whose glow, a fine blue chequer, uses \
         the second, which is turned by 45° about the middle.",
    );
    face_on(&mut gltf);
    directional_light(&mut gltf, Vec3::Z, 2.5);
    let letter = Picture::letter_f(32).texture(&mut gltf, "F", Filter::Nearest)?;
    let chequer =
        Picture::chequer(16, 2, [0, 0, 0], [0, 40, 160]).texture(&mut gltf, "chequer", Filter::Nearest)?;
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
    let card: Shape = quad(1.4, 1.4).plain();
    let indices = gltf.indices(&card.indices);
    let blend = Material { alpha: super::materials::Alpha::Blend, ..Material::unlit("bytes", [1.0; 3]) };
    let blend = blend.add_to(&mut gltf);
    let halved = Material::unlit("floats", [0.5; 3]).add_to(&mut gltf);
    let bytes = gltf.bytes4(&colors, true);
    let floats =
        colors.map(|[red, green, blue, _]| [red, green, blue].map(|value| value as f32 / 255.0)).concat();
    let floats = super::gltf_builder::float_bytes(floats);
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
