//! Scenes of `texture/` about minified textures: far away, in mirrors, and through glass.

use glam::{Quat, Vec2, Vec3};

use crate::texture::face_on;
use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{self, Filter, Image, Wrap};
use scene_builder::json::list;
use scene_builder::material::{Alpha, Material, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, floor, ico_sphere, quad};
use scene_builder::staging::{camera, key_and_fill};

pub(crate) const SCENES: [Entry; 5] = [
    entry("texture/chequer_to_horizon", chequer_to_horizon),
    entry("texture/mip_settings", mip_settings),
    entry("texture/mirrored", mirrored),
    entry("texture/through_glass", through_glass),
    entry("texture/no_fringe", no_fringe),
];

/// Squares in two strong colours, two by two.
fn squares() -> Image {
    Image::chequer(32, 16, [235, 235, 225], [30, 40, 90])
}

/// A floor whose texture repeats every `period` metres.
fn tiled_floor(width: f32, depth: f32, period: f32) -> TriangleMesh {
    let mut shape = floor(width, depth);
    for uv in &mut shape.uvs {
        *uv *= Vec2::new(width, depth) / period;
    }
    shape
}

fn unlit_squares(gltf: &mut Gltf) -> Built<usize> {
    let texture = squares().texture(gltf, "squares", Filter::Mipmapped)?;
    let material = Material {
        base_color_texture: Some(TextureUse::of(texture)),
        ..Material::unlit("squares", [1.0; 3])
    };
    Ok(material.add_to(gltf))
}

fn chequer_to_horizon() -> Built {
    let mut gltf = Gltf::new(
        "A chequered floor of a kilometre: squares stay sharp across while they shorten, and far away melt into one even \
         blue grey, without noise or rings.",
    );
    camera(&mut gltf, Vec3::new(0.3, 1.2, 0.0), Vec3::new(0.3, 0.9, -4.0), 45.0);
    let material = unlit_squares(&mut gltf)?;
    let mesh = tiled_floor(1000.0, 1000.0, 2.0).add_to(&mut gltf, material);
    gltf.node(Node::mesh(mesh));
    Ok(gltf)
}

fn mip_settings() -> Built {
    let mut gltf = Gltf::new(
        "Six strips of chequered floor, one a filter for small texels. From the left: nearest and linear without mip maps, noisy \
         far away; then nearest and linear within the nearest level, with steps between levels; then nearest and linear with a \
         blend of two levels, even at the far end.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.3, 1.2), Vec3::new(0.0, 0.4, -3.0), 40.0);
    let image = squares().add_to(&mut gltf, "squares")?;
    let strip = tiled_floor(0.95, 60.0, 0.95);
    for (index, minify) in [9728, 9729, 9984, 9985, 9986, 9987].into_iter().enumerate() {
        let texture = image::texture_with(&mut gltf, image, [9728, minify], [Wrap::Repeat; 2]);
        let material = Material {
            base_color_texture: Some(TextureUse::of(texture)),
            ..Material::unlit("strip", [1.0; 3])
        };
        let material = material.add_to(&mut gltf);
        let mesh = strip.add_to(&mut gltf, material);
        gltf.node(Node::mesh(mesh).at(index as f32 - 2.5, 0.0, -28.0));
    }
    Ok(gltf)
}

fn mirrored() -> Built {
    let mut gltf = Gltf::new(
        "A mirror ball and a flat mirror on a chequered floor: the flat one shows squares as small as they are at that distance, \
         the ball bends them and melts them into grey towards its edge, both without noise.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.2, 4.2), Vec3::new(0.0, 0.6, 0.0), 34.0);
    let squares = unlit_squares(&mut gltf)?;
    let ground = tiled_floor(60.0, 60.0, 0.5).add_to(&mut gltf, squares);
    gltf.node(Node::mesh(ground));
    let silver = Material::metal("silver", [0.95; 3], 0.0).add_to(&mut gltf);
    let ball = ico_sphere(0.7, 3).plain().add_to(&mut gltf, silver);
    gltf.node(Node::mesh(ball).at(-0.95, 0.7, 0.0));
    let mirror = quad(1.5, 1.3).plain().add_to(&mut gltf, silver);
    gltf.node(Node::mesh(mirror).at(0.95, 0.7, 0.0).turned(Quat::from_rotation_y(-0.25)));
    gltf.shot("env", list([0.35, 0.45, 0.6]));
    Ok(gltf)
}

fn through_glass() -> Built {
    let mut gltf = Gltf::new(
        "A glass ball before a chequered wall: the wall upside down and small inside, its squares sharp in the middle and melting \
         into grey towards the edge.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 26.0);
    let squares = unlit_squares(&mut gltf)?;
    let mut wall = quad(24.0, 24.0);
    for uv in &mut wall.uvs {
        *uv *= 60.0;
    }
    let wall = wall.add_to(&mut gltf, squares);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -2.0));
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let ball = ico_sphere(0.9, 3).plain().add_to(&mut gltf, glass);
    gltf.node(Node::mesh(ball));
    key_and_fill(&mut gltf);
    Ok(gltf)
}

fn no_fringe() -> Built {
    let mut gltf = Gltf::new(
        "Two green discs of few texels over white, whose surroundings are transparent black: large on the left, and as many \
         small ones on the right. Their soft edges are green and white, nowhere dark.",
    );
    face_on(&mut gltf);
    let white = Material::unlit("white", [0.9; 3]).add_to(&mut gltf);
    let white = quad(4.0, 3.0).plain().add_to(&mut gltf, white);
    gltf.node(Node::mesh(white).at(0.0, 0.0, -0.5));
    let disc = Image::new(16, 16, |x, y| {
        let (x, y) = (x as f32 - 7.5, y as f32 - 7.5);
        if x * x + y * y < 36.0 { [40, 160, 60, 255] } else { [0; 4] }
    });
    let texture = disc.texture(&mut gltf, "disc", Filter::Mipmapped)?;
    let material = Material {
        base_color_texture: Some(TextureUse::of(texture)),
        alpha: Alpha::Blend,
        ..Material::unlit("disc", [1.0; 3])
    };
    let material = material.add_to(&mut gltf);
    for (x, repeats) in [(-0.8, 1.0), (0.8, 12.0)] {
        let mut card = quad(1.5, 1.5);
        for uv in &mut card.uvs {
            *uv *= repeats;
        }
        let mesh = card.add_to(&mut gltf, material);
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}
