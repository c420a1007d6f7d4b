//! Scenes of `texture/` about textures other than the base colour.

use std::f32::consts::TAU;

use glam::{Vec3, Vec4};

use crate::texture::face_on;
use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image, opaque};
use scene_builder::material::{Material, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{self, cylinder, quad};
use scene_builder::staging::{camera, chequered_floor, directional_light, grey_floor};

pub(crate) const SCENES: [Entry; 5] = [
    entry("texture/normal_map", normal_map),
    entry("texture/normal_map_mirrored_uv", normal_map_mirrored_uv),
    entry("texture/metallic_roughness", metallic_roughness),
    entry("texture/occlusion", occlusion),
    entry("texture/emissive", emissive),
];

/// Normal map of three by three round bumps.
fn bumps(gltf: &mut Gltf) -> Built<usize> {
    let map = Image::normal_map(96, |u, v| {
        let (x, y) = (u * 3.0 - libm::floorf(u * 3.0) - 0.5, v * 3.0 - libm::floorf(v * 3.0) - 0.5);
        let distance = libm::sqrtf(x * x + y * y);
        if !(0.001..=0.4).contains(&distance) {
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
    let map = Image::new(4, 4, |x, y| {
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
    let stripes = Image::new(8, 8, |x, _| opaque(if x % 2 == 0 { [255, 9, 9] } else { [0, 240, 240] }));
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
    // Where occlusion is traced, the map has no effect.
    gltf.shot("env_samples", 0);
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
    let chequer = Image::chequer(8, 2, [255, 255, 255], [0, 0, 0]);
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
