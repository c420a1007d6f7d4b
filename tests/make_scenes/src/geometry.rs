//! Scenes of `geometry/`: primitive topologies and node transforms.

use std::f32::consts::PI;

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::{Json, list, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, ico_sphere, quad, torus};
use scene_builder::staging::{grey_floor, lit_stage};

pub(crate) const SCENES: [Entry; 4] = [
    entry("geometry/strip_and_fan", strip_and_fan),
    entry("geometry/negative_scale", negative_scale),
    entry("geometry/flat_normals", flat_normals),
    entry("geometry/instancing", instancing),
];

pub(crate) fn paint(gltf: &mut Gltf) -> usize {
    Material::matte("paint", [0.1, 0.4, 0.55]).add_to(gltf)
}

pub(crate) fn before_wall(gltf: &mut Gltf) {
    lit_stage(gltf, Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 0.9, 0.0), 30.0);
    let material = Material::matte("wall", [0.6; 3]).add_to(gltf);
    let wall = quad(8.0, 5.0).plain().add_to(gltf, material);
    gltf.node(Node::mesh(wall).named("wall").at(0.0, 1.0, -0.5));
}

pub(crate) fn primitive_mesh(
    gltf: &mut Gltf,
    attributes: Json,
    indices: Option<usize>,
    material: usize,
    mode: usize,
) -> usize {
    let mut primitive = object([("attributes", attributes)]);
    if let Some(indices) = indices {
        primitive.set("indices", indices);
    }
    primitive.set("material", material);
    if mode != 4 {
        primitive.set("mode", mode);
    }
    gltf.add("meshes", object([("primitives", list([primitive]))]))
}

fn strip_and_fan() -> Built {
    let mut gltf = Gltf::new(
        "A zigzag ribbon stored as a triangle strip and a disc stored as a fan, once with indices above and once without \
         below; no triangle is missing or turned away.",
    );
    before_wall(&mut gltf);
    let material = paint(&mut gltf);
    // Upper left, lower left, upper right: the first triangle of the strip runs counter-clockwise.
    let strip: Vec<Vec3> = (0..10)
        .map(|index| Vec3::new((index as f32 - 4.5) * 0.15, if index % 2 == 0 { 0.3 } else { -0.3 }, 0.0))
        .collect();
    let mut fan = vec![Vec3::ZERO];
    for index in 0..=16 {
        let (sin, cos) = libm::sincosf(2.0 * PI * index as f32 / 16.0);
        fan.push(Vec3::new(cos, sin, 0.0) * 0.4);
    }
    for (corners, mode, x) in [(strip, 5, -0.9), (fan, 6, 0.9)] {
        let attributes = object([("POSITION", gltf.positions(&corners).into())]);
        let order: Vec<u32> = (0..corners.len() as u32).collect();
        let indices = gltf.indices(&order);
        let indexed = primitive_mesh(&mut gltf, attributes.clone(), Some(indices), material, mode);
        let plain = primitive_mesh(&mut gltf, attributes, None, material, mode);
        gltf.node(Node::mesh(indexed).at(x, 1.4, 0.0));
        gltf.node(Node::mesh(plain).at(x, 0.45, 0.0));
    }
    Ok(gltf)
}

fn negative_scale() -> Built {
    let mut gltf = Gltf::new(
        "Four equal steps of one single-sided mesh: as it is, mirrored in x, in all three axes (turned, so that it looks \
         mirrored), and mirrored twice by parent and child (as it is again); all are solid and lit from the upper right.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 6.0), Vec3::new(0.0, 0.5, 0.0), 28.0);
    grey_floor(&mut gltf, 10.0, 6.0);
    let material = paint(&mut gltf);
    let mut steps = cuboid(0.9, 0.3, 0.6).moved(1.0, Quat::IDENTITY, Vec3::new(0.0, -0.3, 0.0));
    steps.join(&cuboid(0.6, 0.3, 0.6).moved(1.0, Quat::IDENTITY, Vec3::new(-0.15, 0.0, 0.0)));
    steps.join(&cuboid(0.3, 0.3, 0.6).moved(1.0, Quat::IDENTITY, Vec3::new(-0.3, 0.3, 0.0)));
    let mesh = steps.plain().add_to(&mut gltf, material);
    let place = |x| Node::mesh(mesh).at(x, 0.46, 0.0);
    gltf.node(place(-1.8));
    gltf.node(place(-0.6).scaled(-1.0, 1.0, 1.0));
    gltf.node(place(0.6).turned(Quat::from_rotation_x(PI)).scaled(-1.0, -1.0, -1.0));
    let child = gltf.node(Node::mesh(mesh).scaled(-1.0, 1.0, 1.0));
    gltf.node(Node::group(&[child]).at(1.8, 0.46, 0.0).scaled(-1.0, 1.0, 1.0));
    Ok(gltf)
}

fn flat_normals() -> Built {
    let mut gltf = Gltf::new(
        "The same coarse ball without normals on the left, where every triangle is a flat facet of its own, and with \
         normals on the right, where the shading is smooth.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.1, 5.0), Vec3::new(0.0, 0.75, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 6.0);
    let material = paint(&mut gltf);
    let smooth = ico_sphere(0.75, 1);
    let flat = TriangleMesh { normals: Vec::new(), ..smooth.clone() };
    let flat = flat.add_to(&mut gltf, material);
    let smooth = smooth.add_to(&mut gltf, material);
    gltf.node(Node::mesh(flat).at(-1.0, 0.75, 0.0));
    gltf.node(Node::mesh(smooth).at(1.0, 0.75, 0.0));
    Ok(gltf)
}

fn instancing() -> Built {
    let mut gltf = Gltf::new(
        "Nine rings from one mesh by nine nodes, three by three, each column scaled differently and each row turned \
         differently; the middle one is sheared by its parent's scale.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO, 30.0);
    let material = paint(&mut gltf);
    let ring = torus(0.4, 0.12, 24, 10).plain().add_to(&mut gltf, material);
    for index in 0..9 {
        let (column, row) = ((index % 3) as f32 - 1.0, (index / 3) as f32 - 1.0);
        let turn = Quat::from_rotation_x(PI / 2.0 + row * 0.8);
        if index == 4 {
            // Scaled along an axis that the ring does not lie in: a shear, as only parents can make it.
            let leaning = turn * Quat::from_rotation_y(0.7);
            let child = Node { matrix: Some(glam::Mat4::from_quat(leaning)), ..Node::mesh(ring) };
            let child = gltf.node(child);
            let parent = Node::group(&[child]).turned(Quat::from_rotation_z(0.6));
            gltf.node(parent.scaled(1.5, 0.7, 1.0));
            continue;
        }
        let wide = 1.0 + 0.4 * column;
        let node = Node::mesh(ring).at(column * 1.4, -row, 0.0).turned(turn).scaled(wide, 1.0, 1.0);
        gltf.node(node);
    }
    Ok(gltf)
}
