//! Scenes of `morph/`.

use std::f32::consts::FRAC_PI_2;

use glam::{Mat4, Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::accessor::{Accessor, Component, bounds_of, float_bytes};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::{Json, list, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, ico_sphere, strip};
use scene_builder::staging::{Track, clip, grey_floor, lit_stage};

pub(crate) const SCENES: [Entry; 3] = [
    entry("morph/weights", weights),
    entry("morph/normals", normals),
    entry("morph/morph_then_skin", morph_then_skin),
];

/// Adds a mesh with morph targets and, if any, default weights.
pub(crate) fn morph_mesh(
    gltf: &mut Gltf,
    attributes: Json,
    indices: usize,
    material: usize,
    targets: Vec<Json>,
    weights: &[f32],
) -> usize {
    let primitive = object([
        ("attributes", attributes),
        ("indices", indices.into()),
        ("material", material.into()),
        ("targets", targets.into()),
    ]);
    let mut mesh = object([("primitives", list([primitive]))]);
    if !weights.is_empty() {
        mesh.set("weights", list(weights.iter().copied()));
    }
    gltf.add("meshes", mesh)
}

fn weights() -> Built {
    let mut gltf = Gltf::new(
        "Four boxes of one mesh with two targets, taller by 1 m and wider by 0.6 m: the first has the mesh's weights (half, \
         none), the second its node's (none, all), the third is animated from none to all of both within 1 s although its \
         node says otherwise, the fourth has negative and large ones (−0.5, 1.5).",
    );
    gltf.reference_frames(&[0, 12, 24]);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.6, 6.5), Vec3::new(0.0, 0.8, 0.0), 36.0);
    grey_floor(&mut gltf, 10.0, 6.0);
    let material = Material::matte("box", [0.1, 0.4, 0.55]).add_to(&mut gltf);
    let shape = cuboid(0.5, 1.0, 0.5).moved(1.0, Quat::IDENTITY, Vec3::new(0.0, 0.5, 0.0)).plain();
    let taller: Vec<Vec3> =
        shape.positions.iter().map(|corner| if corner.y > 0.5 { Vec3::Y } else { Vec3::ZERO }).collect();
    let wider: Vec<Vec3> =
        shape.positions.iter().map(|corner| Vec3::new(0.3 * corner.x.signum(), 0.0, 0.0)).collect();
    let attributes = shape.attributes(&mut gltf);
    let indices = gltf.indices(&shape.indices);
    let taller = sparse_difference(&mut gltf, &taller);
    let targets =
        vec![object([("POSITION", taller.into())]), object([("POSITION", gltf.positions(&wider).into())])];
    let mesh = morph_mesh(&mut gltf, attributes, indices, material, targets, &[0.5, 0.0]);
    let place = |x| Node::mesh(mesh).at(x, 0.0, 0.0);
    gltf.node(place(-2.1));
    gltf.node(Node { weights: vec![0.0, 1.0], ..place(-0.75) });
    let animated = gltf.node(Node { weights: vec![1.0, 0.0], ..place(0.75) });
    gltf.node(Node { weights: vec![-0.5, 1.5], ..place(2.3) });
    let values = vec![0.0, 0.0, 1.0, 1.0];
    clip(
        &mut gltf,
        "grow",
        &[Track { node: animated, path: "weights", interpolation: "LINEAR", times: &[0.0, 1.0], values }],
    );
    Ok(gltf)
}

/// Sparse differences: only those that are not zero are stored.
fn sparse_difference(gltf: &mut Gltf, differences: &[Vec3]) -> usize {
    let moved = differences.iter().enumerate().filter(|(_, value)| **value != Vec3::ZERO);
    let (indices, values): (Vec<u16>, Vec<Vec3>) = moved.map(|(index, value)| (index as u16, *value)).unzip();
    let all: Vec<f32> = differences.iter().flat_map(Vec3::to_array).collect();
    let values = float_bytes(values.iter().flat_map(Vec3::to_array));
    let accessor = Accessor {
        data: None,
        bounds: Some(bounds_of(&all, 3)),
        sparse: Some((indices, values)),
        ..Accessor::new(Component::F32, "VEC3", differences.len(), Vec::new())
    };
    gltf.accessor(&accessor)
}

fn normals() -> Built {
    let mut gltf = Gltf::new(
        "Three balls flattened to discs that lean back: the left one's normals are morphed with it and it is shaded as the \
         flat thing it is; the middle one's target has no normals and it is shaded like a ball; the right one is the ball.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.0, 5.5), Vec3::new(0.0, 0.8, 0.0), 28.0);
    grey_floor(&mut gltf, 9.0, 6.0);
    let material = Material::matte("ball", [0.7, 0.6, 0.4]).add_to(&mut gltf);
    let ball = ico_sphere(0.7, 2);
    // Squashed to a fifth along an axis half way between up and the viewer.
    let axis = Vec3::new(0.0, 0.5, 0.8660254);
    let squash = |vector: Vec3, factor: f32| axis * (axis.dot(vector) * (factor - 1.0));
    let moved: Vec<Vec3> = ball.positions.iter().map(|position| squash(*position, 0.2)).collect();
    // Normals follow the inverse transpose: five times longer along the axis, then unit again.
    let turned: Vec<Vec3> =
        ball.normals.iter().map(|normal| (*normal + squash(*normal, 5.0)).normalize() - *normal).collect();
    let attributes = ball.attributes(&mut gltf);
    let indices = gltf.indices(&ball.indices);
    let position = gltf.positions(&moved);
    let with_normals = vec![object([("POSITION", position.into()), ("NORMAL", gltf.vec3s(&turned).into())])];
    let without = vec![object([("POSITION", position.into())])];
    let shaded = morph_mesh(&mut gltf, attributes.clone(), indices, material, with_normals, &[1.0]);
    let unshaded = morph_mesh(&mut gltf, attributes, indices, material, without, &[1.0]);
    gltf.node(Node::mesh(shaded).at(-1.5, 0.8, 0.0));
    gltf.node(Node::mesh(unshaded).at(0.0, 0.8, 0.0));
    gltf.node(Node { weights: vec![0.0], ..Node::mesh(unshaded).at(1.5, 0.8, 0.0) });
    Ok(gltf)
}

fn morph_then_skin() -> Built {
    let mut gltf = Gltf::new(
        "A strip grows a bulge to its right at its upper end, by a morph target, and its upper half is bent to the right by \
         90°: the bulge, bent along, points down. It would point right if the skin came first.",
    );
    lit_stage(&mut gltf, Vec3::new(0.3, 0.9, 5.0), Vec3::new(0.3, 0.9, 0.0), 28.0);
    let paint = Material::matte("strip", [0.65, 0.25, 0.05]).two_sided().add_to(&mut gltf);
    let shape: TriangleMesh = strip(0.3, 2.0, 8).plain();
    let mut attributes = shape.attributes(&mut gltf);
    let weights: Vec<[u8; 4]> = shape
        .positions
        .iter()
        .map(|corner| if corner.y > 1.0 { [0, 255, 0, 0] } else { [255, 0, 0, 0] })
        .collect();
    let (joints, weights) = gltf.influences(&vec![[0, 1, 0, 0]; weights.len()], &weights);
    attributes.set("JOINTS_0", joints);
    attributes.set("WEIGHTS_0", weights);
    let indices = gltf.indices(&shape.indices);
    let bulge: Vec<Vec3> = shape
        .positions
        .iter()
        .map(|corner| if corner.x > 0.0 && corner.y > 1.4 { Vec3::new(0.5, 0.0, 0.0) } else { Vec3::ZERO })
        .collect();
    let targets = vec![object([("POSITION", gltf.positions(&bulge).into())])];
    let mesh = morph_mesh(&mut gltf, attributes, indices, paint, targets, &[1.0]);
    let upper = gltf.node(Node::default().at(0.0, 1.0, 0.0).turned(Quat::from_rotation_z(-FRAC_PI_2)));
    let lower = gltf.node(Node::group(&[upper]));
    let skin = gltf.skin(&[lower, upper], &[Mat4::IDENTITY, Mat4::from_translation(Vec3::NEG_Y)]);
    gltf.node(Node { skin: Some(skin), ..Node::mesh(mesh) });
    Ok(gltf)
}
