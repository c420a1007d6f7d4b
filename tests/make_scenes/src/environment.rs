//! Scenes of `environment/`: environment images, backgrounds and shadow catchers.

use glam::Vec3;

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::list;
use scene_builder::material::{DiffuseTransmission, Material};
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, floor, ico_sphere, quad};
use scene_builder::staging::{camera, chequered_wall, directional_light, point_light};

pub(crate) const SCENES: [Entry; 7] = [
    entry("environment/picture", three_balls_in_environment),
    entry("environment/turned", turned),
    entry("environment/background", background),
    entry("environment/shadow_catcher", shadow_catcher),
    entry("environment/lit_catcher", lit_catcher),
    entry("environment/ground", ground),
    entry("environment/frosted_glass", frosted_glass),
];

/// Path of [`image`] below `scenes/`.
pub(crate) const IMAGE_PATH: &str = "environment/quarters.hdr";

/// Width and height of the image.
const SIZE: (u32, u32) = (64, 32);

/// An equirectangular Radiance image without compression: quarters of red, green, blue and yellow from left to right, so that
/// in front (in the centre) green is on the left and blue on the right. The sky is white, the ground dark.
pub(crate) fn image() -> Vec<u8> {
    let mut file =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", SIZE.1, SIZE.0).into_bytes();
    for row in 0..SIZE.1 {
        for column in 0..SIZE.0 {
            let color = match (row, column * 4 / SIZE.0) {
                (0..4, _) => [3.0, 3.0, 3.0],
                (20.., _) => [0.0625, 0.0625, 0.0625],
                (_, 0) => [0.75, 0.09375, 0.0625],
                (_, 1) => [0.125, 0.5, 0.125],
                (_, 2) => [0.125, 0.25, 0.75],
                _ => [0.75, 0.625, 0.125],
            };
            file.extend(rgbe(color));
        }
    }
    file
}

/// Three mantissas and their shared exponent.
fn rgbe(color: [f32; 3]) -> [u8; 4] {
    let largest = color.into_iter().fold(0.0, |a, b| if a > b { a } else { b });
    let (mut exponent, mut scale) = (128_u8, 256.0);
    while largest * scale >= 256.0 {
        (exponent, scale) = (exponent + 1, scale * 0.5);
    }
    while largest * scale < 128.0 {
        (exponent, scale) = (exponent - 1, scale * 2.0);
    }
    let [red, green, blue] = color.map(|channel| (channel * scale) as u8);
    [red, green, blue, exponent]
}

/// A matte, a rough and a mirror ball.
fn three_balls(gltf: &mut Gltf) {
    camera(gltf, Vec3::new(0.0, 0.35, 5.0), Vec3::ZERO, 30.0);
    let materials = [
        Material::matte("matte", [0.8; 3]),
        Material::metal("rough", [0.95; 3], 0.45),
        Material::metal("mirror", [0.95; 3], 0.0),
    ];
    let materials = materials.map(|material| material.add_to(gltf));
    let balls = ico_sphere(0.7, 3).plain().add_with_each(gltf, &materials);
    for (x, mesh) in [-1.5, 0.0, 1.5].into_iter().zip(balls) {
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
}

fn three_balls_in_environment() -> Built {
    let mut gltf = Gltf::new(
        "Three balls in a room of four colours: behind them green to the left and blue to the right, in the mirror ball red to \
         the left and yellow to the right, the white sky on top of each; the rough ball shows the same blurred, the matte one only \
         its tint.",
    );
    three_balls(&mut gltf);
    gltf.shot("env", "quarters.hdr");
    Ok(gltf)
}

fn turned() -> Built {
    let mut gltf = Gltf::new(
        "The same room turned by 90° counter-clockwise from above, at half its strength: behind the balls blue to the left and \
         yellow to the right.",
    );
    three_balls(&mut gltf);
    gltf.shot("env", "quarters.hdr@90");
    gltf.shot("env_intensity", 0.5);
    Ok(gltf)
}

fn background() -> Built {
    let mut gltf = Gltf::new(
        "The room of four colours lights the balls and is seen in them, but behind them is an even dark violet.",
    );
    three_balls(&mut gltf);
    gltf.shot("env", "quarters.hdr");
    gltf.shot("background", list([0.06, 0.02, 0.1]));
    Ok(gltf)
}

fn shadow_catcher() -> Built {
    let mut gltf = Gltf::new(
        "A ball and a box on a floor that is not there: the picture is transparent but for them and their black shadows, darker where \
         both lights are blocked. The mirror ball shows the box and its shadow and else nothing.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.8, 5.0), Vec3::new(0.0, 0.4, 0.0), 32.0);
    directional_light(&mut gltf, Vec3::new(1.0, 1.6, 0.8), 3.0);
    point_light(&mut gltf, Vec3::new(-2.5, 2.5, 1.0), 12.0);
    grey_floor(&mut gltf);
    ball_and_box(&mut gltf);
    gltf.shot("background", "none");
    gltf.shot("shadow_catcher", list(["floor"]));
    Ok(gltf)
}

fn lit_catcher() -> Built {
    let mut gltf = Gltf::new(
        "The ball and the box on the floor that is not there, in the light of four colours alone: soft black shadows around their feet.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.8, 5.0), Vec3::new(0.0, 0.4, 0.0), 32.0);
    grey_floor(&mut gltf);
    ball_and_box(&mut gltf);
    gltf.shot("env", "quarters.hdr");
    gltf.shot("background", "none");
    gltf.shot("shadow_catcher", list(["floor"]));
    Ok(gltf)
}

fn ground() -> Built {
    let mut gltf = Gltf::new(
        "The ball and the box of the shadow catcher on the polished ground of the program, in a studio: their mirror images over black shadows.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.8, 5.0), Vec3::new(0.0, 0.4, 0.0), 32.0);
    ball_and_box(&mut gltf);
    gltf.shot("env", "studio");
    gltf.shot("background", "none");
    gltf.shot("ground", "reflection");
    Ok(gltf)
}

/// A wide floor, to be a shadow catcher.
fn grey_floor(gltf: &mut Gltf) {
    let ground = Material::matte("ground", [0.5; 3]).add_to(gltf);
    let ground = floor(20.0, 20.0).plain().add_to(gltf, ground);
    gltf.node(Node::mesh(ground).named("floor"));
}

/// A mirror ball and a red box on the ground.
fn ball_and_box(gltf: &mut Gltf) {
    let silver = Material::metal("silver", [0.95; 3], 0.0).add_to(gltf);
    let ball = ico_sphere(0.6, 3).plain().add_to(gltf, silver);
    gltf.node(Node::mesh(ball).at(-0.8, 0.6, 0.0));
    let red = Material::matte("red", [0.7, 0.1, 0.08]).add_to(gltf);
    let cube = cuboid(0.8, 0.8, 0.8).plain().add_to(gltf, red);
    gltf.node(Node::mesh(cube).named("box").at(0.8, 0.4, 0.0));
}

fn frosted_glass() -> Built {
    let mut gltf = Gltf::new(
        "A frosted pane, a frosted ball and a sheet of paper before a wall of orange and teal stripes: the pane shows the stripes \
         behind it washed out, the ball turns them over, and the paper mixes them.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.35, 5.0), Vec3::ZERO, 30.0);
    let orange = Material::matte("orange", [0.9, 0.35, 0.05]).add_to(&mut gltf);
    let teal = Material::matte("teal", [0.02, 0.4, 0.45]).add_to(&mut gltf);
    let wall = chequered_wall(&mut gltf, [8, 1], 0.9, [orange, teal]);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -0.9).scaled(1.0, 4.0, 1.0));
    let glass = |name| Material { roughness: 0.35, ..Material::glass(name, 1.5) };
    let pane = Material { volume: None, ..glass("frosted pane") }.two_sided().add_to(&mut gltf);
    // Of a roughness at which lookups and rays by facets have half of the light each
    let solid = Material { roughness: 0.6, ..glass("frosted ball") }.add_to(&mut gltf);
    let through = DiffuseTransmission { factor: 0.9, color: [1.0; 3] };
    let paper = Material { diffuse_transmission: Some(through), ..Material::matte("paper", [0.9; 3]) };
    let paper = paper.two_sided().add_to(&mut gltf);
    let sheets = quad(1.3, 1.3).plain().add_with_each(&mut gltf, &[pane, paper]);
    gltf.node(Node::mesh(sheets[0]).at(-1.5, 0.0, 0.0));
    let ball = ico_sphere(0.7, 3).plain().add_to(&mut gltf, solid);
    gltf.node(Node::mesh(ball));
    gltf.node(Node::mesh(sheets[1]).at(1.5, 0.0, 0.0));
    gltf.shot("env", "studio");
    Ok(gltf)
}
