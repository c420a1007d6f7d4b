//! Scenes of `camera/`.

use std::f32::consts::FRAC_PI_6;

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::{Json, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, quad};
use scene_builder::staging::{
    Track, chequered_floor, clip, flat3, flat4, key_and_fill, looking, perspective,
};

pub(crate) const SCENES: [Entry; 6] = [
    entry("camera/perspective", perspective_field),
    entry("camera/orthographic", orthographic_field),
    entry("camera/animated", animated),
    entry("camera/aspect_narrow", aspect_narrow),
    entry("camera/aspect_wide", aspect_wide),
    entry("camera/no_camera", no_camera),
];

/// An orthographic camera of half sizes `x` and `y`.
pub(crate) fn orthographic(x: f32, y: f32) -> Json {
    object([
        ("type", "orthographic".into()),
        (
            "orthographic",
            object([("xmag", x.into()), ("ymag", y.into()), ("zfar", 100.0.into()), ("znear", 0.01.into())]),
        ),
    ])
}

/// Two unlit colours, for images whose edges matter.
fn two_colours(gltf: &mut Gltf) -> [usize; 2] {
    [
        Material::unlit("green", [0.1, 0.5, 0.15]).add_to(gltf),
        Material::unlit("red", [0.7, 0.05, 0.04]).add_to(gltf),
    ]
}

/// A green field of the given size before an endless red one, both facing the camera at the origin.
fn field(gltf: &mut Gltf, width: f32, height: f32, distance: f32) {
    let [green, red] = two_colours(gltf);
    let green = quad(width, height).plain().add_to(gltf, green);
    let red = quad(40.0, 40.0).plain().add_to(gltf, red);
    gltf.node(Node::mesh(green).at(0.0, 0.0, -distance));
    gltf.node(Node::mesh(red).at(0.0, 0.0, -distance - 0.01));
}

fn perspective_field() -> Built {
    let mut gltf = Gltf::new(
        "A green field that covers nine tenths of the picture's width and height, red around it: yfov 60° at 3 m sees \
         3.46 m from top to bottom. The camera node's scale of 5 changes nothing.",
    );
    // 2 · 3 · tan 30° = 3.4641 high, 16/9 of it wide.
    field(&mut gltf, 0.9 * 3.4641016 * 16.0 / 9.0, 0.9 * 3.4641016, 3.0);
    let camera = perspective(&mut gltf, 60.0, Some(scene_builder::staging::ASPECT_RATIO));
    gltf.node(Node { camera: Some(camera), ..Node::default() }.scaled(5.0, 5.0, 5.0));
    Ok(gltf)
}

fn orthographic_field() -> Built {
    let mut gltf = Gltf::new(
        "Three equal upright boxes one behind the other look equally large and the chequered floor's lines do not meet: \
         there is no perspective.",
    );
    let camera = gltf.add("cameras", orthographic(3.2, 1.8));
    let eye = Vec3::new(4.0, 3.0, 6.0);
    let turned = looking(eye, Vec3::ZERO);
    gltf.node(Node { camera: Some(camera), ..Node::default() }.at(eye.x, eye.y, eye.z).turned(turned));
    key_and_fill(&mut gltf);
    chequered_floor(&mut gltf, [8, 8], 0.5);
    let paint = Material::matte("box", [0.65, 0.3, 0.05]).add_to(&mut gltf);
    let mesh = cuboid(0.5, 0.9, 0.5).plain().add_to(&mut gltf, paint);
    for x in [-1.2, 0.0, 1.2] {
        gltf.node(Node::mesh(mesh).at(x, 0.45, -x));
    }
    Ok(gltf)
}

fn animated() -> Built {
    let mut gltf = Gltf::new(
        "The camera slides to the right and turns back to the box by its parent: the red box stays in the middle and \
         shows its left side first, its front at 0.5 s, its right side at 1 s.",
    );
    gltf.reference_frames(&[0, 12, 24]);
    let camera = perspective(&mut gltf, 30.0, Some(scene_builder::staging::ASPECT_RATIO));
    let camera = gltf.node(Node { camera: Some(camera), ..Node::default() }.at(0.0, 0.0, 5.0));
    let pivot = gltf.node(Node::group(&[camera]).named("pivot").at(0.0, 0.6, 0.0));
    key_and_fill(&mut gltf);
    chequered_floor(&mut gltf, [16, 16], 0.5);
    let red = Material::matte("box", [0.7, 0.07, 0.05]).add_to(&mut gltf);
    let mesh = cuboid(0.9, 0.9, 0.9).plain().add_to(&mut gltf, red);
    gltf.node(Node::mesh(mesh).at(0.0, 0.45, 0.0));
    let turns = [-FRAC_PI_6, FRAC_PI_6].map(Quat::from_rotation_y);
    let track =
        |node, path, values| Track { node, path, interpolation: "LINEAR", times: &[0.0, 1.0], values };
    let slide = flat3(&[Vec3::new(0.0, 0.6, 0.0), Vec3::new(0.0, 0.9, 0.0)]);
    clip(&mut gltf, "slide", &[track(pivot, "rotation", flat4(&turns)), track(pivot, "translation", slide)]);
    Ok(gltf)
}

fn aspect_narrow() -> Built {
    let mut gltf = Gltf::new(
        "A camera made for pictures 2.4 times as wide as high, shown in a narrower one: the green field, as wide as the \
         camera's own picture, fills the width from edge to edge; above and below it red shows what the camera's picture \
         would cut off.",
    );
    // 40° at 3 m: 2 · 3 · tan 20° = 2.18382 high.
    field(&mut gltf, 2.4 * 2.1838214, 2.1838214, 3.0);
    let camera = perspective(&mut gltf, 40.0, Some(2.4));
    gltf.node(Node { camera: Some(camera), ..Node::default() });
    Ok(gltf)
}

fn aspect_wide() -> Built {
    let mut gltf = Gltf::new(
        "A camera made for square pictures, shown in a wider one: the green square fills the height from edge to edge and \
         red shows at its sides.",
    );
    field(&mut gltf, 2.1838214, 2.1838214, 3.0);
    let camera = perspective(&mut gltf, 40.0, Some(1.0));
    gltf.node(Node { camera: Some(camera), ..Node::default() });
    Ok(gltf)
}

fn no_camera() -> Built {
    let mut gltf = Gltf::new(
        "No camera in the file: the view from +Z holds the whole box and all of its way, from the lower left to the upper \
         right, with a small margin; the box does not leave the picture in any frame.",
    );
    gltf.reference_frames(&[0, 24]);
    key_and_fill(&mut gltf);
    let paint = Material::matte("box", [0.1, 0.4, 0.55]).add_to(&mut gltf);
    let mesh = cuboid(1.0, 1.0, 1.0).plain().add_to(&mut gltf, paint);
    let node = gltf.node(Node::mesh(mesh));
    let values = flat3(&[Vec3::new(-30.0, -10.0, 5.0), Vec3::new(-24.0, -7.0, 5.0)]);
    clip(
        &mut gltf,
        "move",
        &[Track { node, path: "translation", interpolation: "LINEAR", times: &[0.0, 1.0], values }],
    );
    Ok(gltf)
}
