//! Scenes of `bvh/`: difficult input for the acceleration structure.

use std::f32::consts::PI;

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, cylinder, floor, ico_sphere, quad, torus};
use scene_builder::staging::{camera, grey_floor, key_and_fill, lit_stage};

pub(crate) const SCENES: [Entry; 5] = [
    entry("bvh/slivers", slivers),
    entry("bvh/coincident_faces", coincident_faces),
    entry("bvh/teapot_in_stadium", teapot_in_stadium),
    entry("bvh/long_diagonals", long_diagonals),
    entry("bvh/degenerate_triangles", degenerate_triangles),
];

fn slivers() -> Built {
    let mut gltf = Gltf::new(
        "Bright rails, 4 cm wide and up to 4 km long (aspect 10³ to 10⁵), run to the horizon; above them stands a tilted \
         panel of 300 slivers of aspect 10³, closed and evenly shaded, without holes or specks.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 4.5), Vec3::new(0.0, 0.9, 0.0), 35.0);
    let dark = Material::matte("ground", [0.12, 0.12, 0.14]).add_to(&mut gltf);
    let ground = floor(8000.0, 8000.0).plain().add_to(&mut gltf, dark);
    gltf.node(Node::mesh(ground).named("ground"));
    let bright = Material::matte("rails", [0.8, 0.75, 0.6]).add_to(&mut gltf);
    let mut rails = TriangleMesh::default();
    for index in 0..41 {
        let length = [40.0, 400.0, 4000.0][index % 3];
        let x = (index as f32 - 20.0) * 0.4;
        rails.join(
            &floor(0.04, length).moved(1.0, Quat::IDENTITY, Vec3::new(x, 0.02, 4.0 - length / 2.0)).plain(),
        );
    }
    let rails = rails.add_to(&mut gltf, bright);
    gltf.node(Node::mesh(rails).named("rails"));
    let paint = Material::matte("panel", [0.65, 0.3, 0.05]).two_sided().add_to(&mut gltf);
    let panel = sliver_panel(150).add_to(&mut gltf, paint);
    let tilt = Quat::from_rotation_z(0.6) * Quat::from_rotation_y(0.5);
    gltf.node(Node::mesh(panel).named("panel").at(0.0, 1.2, 0.0).turned(tilt));
    Ok(gltf)
}

/// A panel 3 m wide of `rows` rows 3 mm high, two triangles each.
fn sliver_panel(rows: u32) -> TriangleMesh {
    let mut shape = TriangleMesh::default();
    for row in 0..=rows {
        let y = (row as f32 - rows as f32 / 2.0) * -0.003;
        shape.positions.extend([Vec3::new(-1.5, y, 0.0), Vec3::new(1.5, y, 0.0)]);
        shape.normals.extend([Vec3::Z; 2]);
    }
    shape.indices = scene_builder::shapes::grid_indices(1, rows, false);
    shape
}

fn coincident_faces() -> Built {
    let mut gltf = Gltf::new(
        "Two cards in one place, orange stored before blue, show orange alone; of three boxes that touch and overlap with \
         faces in common planes, the one stored first shows in every shared place; no speckle anywhere.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.3, 5.0), Vec3::new(0.0, 0.6, 0.0), 30.0);
    grey_floor(&mut gltf, 9.0, 6.0);
    let orange = Material::matte("orange", [0.75, 0.3, 0.04]).add_to(&mut gltf);
    let blue = Material::matte("blue", [0.05, 0.15, 0.65]).add_to(&mut gltf);
    let green = Material::matte("green", [0.08, 0.5, 0.1]).add_to(&mut gltf);
    let cards = quad(1.2, 1.2).plain().add_with_each(&mut gltf, &[orange, blue]);
    for card in cards {
        gltf.node(Node::mesh(card).at(-1.3, 0.65, 0.0).turned(Quat::from_rotation_y(0.3)));
    }
    let boxes = cuboid(0.75, 0.75, 0.75).plain().add_with_each(&mut gltf, &[orange, blue, green]);
    for (mesh, x, y) in [(boxes[0], 0.75, 0.375), (boxes[1], 1.25, 0.375), (boxes[2], 1.0, 0.625)] {
        gltf.node(Node::mesh(mesh).at(x, y, 0.0));
    }
    Ok(gltf)
}

fn teapot_in_stadium() -> Built {
    let mut gltf = Gltf::new(
        "A finely meshed pot 4 cm across stands on the grass of a stadium 400 m long, whose stands rise behind it out of \
         focus of any grid; the pot is whole, finely faceted and casts a sharp shadow.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.05, 0.16), Vec3::new(0.0, 0.025, 0.0), 30.0);
    key_and_fill(&mut gltf);
    let grass = Material::matte("grass", [0.1, 0.35, 0.06]).add_to(&mut gltf);
    let ground = floor(400.0, 400.0).plain().add_to(&mut gltf, grass);
    gltf.node(Node::mesh(ground).named("grass"));
    let concrete = Material::matte("stands", [0.55, 0.53, 0.5]).add_to(&mut gltf);
    let mut stands = TriangleMesh::default();
    for step in 0..24 {
        let place = Vec3::new(0.0, 1.0 + step as f32 * 1.2, -80.0 - step as f32 * 2.5);
        stands.join(&cuboid(400.0, 2.0, 2.5).moved(1.0, Quat::IDENTITY, place));
    }
    let stands = stands.plain().add_to(&mut gltf, concrete);
    gltf.node(Node::mesh(stands).named("stands"));
    let glaze = Material { roughness: 0.4, ..Material::matte("glaze", [0.7, 0.68, 0.6]) };
    let glaze = glaze.add_to(&mut gltf);
    // Belly, lid knob, handle and foot.
    let mut pot = ico_sphere(0.02, 3).moved(1.0, Quat::IDENTITY, Vec3::new(0.0, 0.022, 0.0));
    pot.join(&ico_sphere(0.004, 1).moved(1.0, Quat::IDENTITY, Vec3::new(0.0, 0.045, 0.0)));
    let upright = Quat::from_rotation_x(PI / 2.0);
    pot.join(&torus(0.01, 0.0025, 20, 8).plain().moved(1.0, upright, Vec3::new(-0.022, 0.024, 0.0)));
    let tilted = Quat::from_rotation_z(-0.9);
    pot.join(&cylinder(0.0035, 0.022, 20).plain().moved(1.0, tilted, Vec3::new(0.025, 0.03, 0.0)));
    // Flat normals are enough for a mesh this fine, and keep the file small.
    pot.normals.clear();
    let pot = pot.add_to(&mut gltf, glaze);
    gltf.node(Node::mesh(pot).named("pot"));
    Ok(gltf)
}

fn long_diagonals() -> Built {
    let mut gltf = Gltf::new(
        "Forty-eight straight pipes cross a hall in all diagonal directions, each whole from end to end, with clean \
         shadows on the wall behind.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, 40.0);
    let plaster = Material::matte("wall", [0.6; 3]).add_to(&mut gltf);
    let wall = quad(16.0, 10.0).plain().add_to(&mut gltf, plaster);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -3.0));
    let colors = [("copper", [0.65, 0.25, 0.1]), ("steel", [0.3, 0.35, 0.4]), ("paint", [0.1, 0.4, 0.2])];
    let materials = colors.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    let pipes = cylinder(0.05, 1.0, 10).plain().add_with_each(&mut gltf, &materials);
    for index in 0..48_u32 {
        // Ends on two opposite sides of the hall, spread by multiples of the golden ratio.
        let spread = |factor: f32| {
            let value = (index as f32 + 0.5) * factor;
            (value - libm::floorf(value)) * 2.0 - 1.0
        };
        let from = Vec3::new(-4.5, 2.3 * spread(0.618034), 2.0 * spread(0.381966));
        let to = Vec3::new(4.5, 2.3 * spread(0.7548777), 2.0 * spread(0.5698403));
        let along = to - from;
        let middle = (from + to) / 2.0;
        let turned = Quat::from_rotation_arc(Vec3::Y, along.normalize());
        let node = Node::mesh(pipes[index as usize % 3]).at(middle.x, middle.y, middle.z);
        gltf.node(node.turned(turned).scaled(1.0, along.length(), 1.0));
    }
    Ok(gltf)
}

fn degenerate_triangles() -> Built {
    let mut gltf = Gltf::new(
        "A ball and a card on a floor, as if nothing were wrong: between their triangles lie others without area, as \
         points, as lines of three corners in a row and with repeated corners, and they leave no trace.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.1, 4.5), Vec3::new(0.0, 0.6, 0.0), 32.0);
    grey_floor(&mut gltf, 8.0, 6.0);
    let paint = Material::matte("paint", [0.1, 0.4, 0.55]).add_to(&mut gltf);
    let mut shape = ico_sphere(0.6, 2).moved(1.0, Quat::IDENTITY, Vec3::new(-0.8, 0.6, 0.0));
    shape.join(&quad(1.1, 1.1).plain().moved(1.0, Quat::IDENTITY, Vec3::new(0.8, 0.6, 0.0)));
    let first = shape.positions.len() as u32;
    // Three collinear corners across the view, and one point three times.
    for x in [-2.0, 0.5, 3.0, 0.0, 0.0, 0.0] {
        shape.positions.push(Vec3::new(x, 1.0, 0.4));
        shape.normals.push(Vec3::Z);
    }
    let whole = std::mem::take(&mut shape.indices);
    for (index, triangle) in whole.chunks_exact(3).enumerate() {
        shape.indices.extend(triangle);
        match index % 8 {
            0 => shape.indices.extend([first, first + 1, first + 2]),
            2 => shape.indices.extend([first + 3, first + 4, first + 5]),
            4 => shape.indices.extend([triangle[0], triangle[1], triangle[1]]),
            6 => shape.indices.extend([triangle[0]; 3]),
            _ => {}
        }
    }
    let mesh = shape.add_to(&mut gltf, paint);
    gltf.node(Node::mesh(mesh));
    Ok(gltf)
}
