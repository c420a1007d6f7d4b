//! Scenes of `path/`: light that bounces, by the path integrator.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, ico_sphere, quad};
use scene_builder::staging::camera;

pub(crate) const SCENES: [Entry; 1] = [entry("path/box", lit_box)];

const WHITE: [f32; 3] = [0.73, 0.73, 0.7];

fn lit_box() -> Built {
    let mut gltf = Gltf::new(
        "A white box with a red wall on the left and a green one on the right, open towards the camera, lit by an emissive panel below its \
         ceiling: soft shadows, walls that colour what stands beside them, a bright spot of light below the glass ball, and the whole box in \
         the mirror ball.",
    );
    gltf.shot("integrator", "path");
    gltf.shot("samples", 16);
    gltf.shot("env", "none");
    camera(&mut gltf, Vec3::new(0.0, 1.0, 3.9), Vec3::new(0.0, 0.95, 0.0), 36.0);
    walls(&mut gltf);
    let panel = Material {
        emissive: [1.0, 0.9, 0.75],
        emissive_strength: Some(8.0),
        ..Material::matte("panel", [0.0; 3])
    };
    let panel = panel.add_to(&mut gltf);
    let panel = quad(0.9, 0.8).plain().add_to(&mut gltf, panel);
    gltf.node(Node::mesh(panel).at(0.0, 1.995, 0.0).turned(Quat::from_rotation_x(FRAC_PI_2)));

    let white = Material::matte("block", WHITE).add_to(&mut gltf);
    let block = cuboid(0.55, 1.1, 0.5).plain().add_to(&mut gltf, white);
    gltf.node(Node::mesh(block).at(-0.5, 0.55, -0.4).turned(Quat::from_rotation_y(0.35)));
    let mirror = Material::metal("mirror", [0.95, 0.93, 0.88], 0.0).add_to(&mut gltf);
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let balls = ico_sphere(0.33, 3).plain().add_with_each(&mut gltf, &[mirror, glass]);
    gltf.node(Node::mesh(balls[0]).at(0.55, 0.335, -0.35));
    gltf.node(Node::mesh(balls[1]).at(0.1, 0.335, 0.45));
    Ok(gltf)
}

/// Five squares of 2 m that face the middle of the box.
fn walls(gltf: &mut Gltf) {
    let [white, red, green] = [("white", WHITE), ("red", [0.65, 0.06, 0.05]), ("green", [0.12, 0.48, 0.1])]
        .map(|(name, color)| Material::matte(name, color).add_to(gltf));
    let meshes = quad(2.0, 2.0).plain().add_with_each(gltf, &[white, red, green]);
    let walls = [
        (meshes[0], Vec3::ZERO, Quat::from_rotation_x(-FRAC_PI_2)),
        (meshes[0], Vec3::new(0.0, 2.0, 0.0), Quat::from_rotation_x(FRAC_PI_2)),
        (meshes[0], Vec3::new(0.0, 1.0, -1.0), Quat::IDENTITY),
        (meshes[1], Vec3::new(-1.0, 1.0, 0.0), Quat::from_rotation_y(FRAC_PI_2)),
        (meshes[2], Vec3::new(1.0, 1.0, 0.0), Quat::from_rotation_y(-FRAC_PI_2)),
    ];
    for (mesh, Vec3 { x, y, z }, rotation) in walls {
        gltf.node(Node::mesh(mesh).at(x, y, z).turned(rotation));
    }
}
