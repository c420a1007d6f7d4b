//! Fronts of skins whose node, joints and bind pose are mirrored or not.

use std::f32::consts::PI;

use glam::{Mat4, Quat, Vec3};
use rayframe::film::AovFlags;
use rayframe::integrator::Integrator;
use rayframe::scene::{
    Environment, LightKind, LocalTransform, Material, Node, NodeIndex, Primitive, Skin, SkinIndex,
    SkinInfluences, Volume,
};

use super::glass::glass;
use crate::stage::{Stage, assert_close, cuboid, lambert};

/// Scales along x, 1 or −1.
#[derive(Clone, Copy, Debug)]
struct Rig {
    /// The vertices in the file. Mirrored ones are wound inward, but their normals point outward.
    vertices: f32,
    /// The node of the mesh.
    node: f32,
    joint: f32,
    /// The inverse bind matrix.
    inverse_bind: f32,
}

/// A box of half edges 1, 0.75 and 0.5 around the origin that follows one joint.
fn skinned_box(rig: Rig, material: Material) -> Stage {
    let scale = |x| Vec3::new(x, 1.0, 1.0);
    let scaled =
        |x| LocalTransform::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: scale(x) };
    let mut stage = Stage::new();
    stage.add(bound_box(rig.vertices < 0.0), material);
    stage.scene.nodes[0].local = scaled(rig.node);
    stage.scene.nodes[0].skin = Some(SkinIndex(0));
    stage.push_node(Node { local: scaled(rig.joint), ..Node::default() });
    let inverse_bind_matrices = vec![Mat4::from_scale(scale(rig.inverse_bind))];
    stage.scene.skins.push(Skin { name: None, joints: vec![NodeIndex(1)], inverse_bind_matrices });
    stage
}

fn bound_box(is_mirrored: bool) -> Primitive {
    let mut primitive = cuboid(Vec3::ZERO, Vec3::new(1.0, 0.75, 0.5));
    let mut normals = vec![Vec3::ZERO; primitive.positions.len()];
    for corners in &mut primitive.triangles {
        let [a, b, c] = corners.map(|corner| primitive.positions[corner as usize]);
        let outward = (b - a).cross(c - a).normalize();
        for corner in *corners {
            normals[corner as usize] = outward;
        }
        if is_mirrored {
            corners.swap(1, 2);
        }
    }
    let count = normals.len();
    let influences = SkinInfluences { per_vertex: 1, joints: vec![0; count], weights: vec![1.0; count] };
    Primitive { normals: Some(normals), influences: Some(influences), ..primitive }
}

#[test]
fn the_front_of_a_skin_is_its_outside_whatever_is_mirrored() {
    let eye = Vec3::Z * 4.0;
    for [vertices, node, joint, inverse_bind] in [
        [1.0, 1.0, 1.0, 1.0],
        // An armature of negative scale, as Blender exports it: the vertices are in world space.
        [-1.0, -1.0, -1.0, -1.0],
        // A mesh of negative scale with an armature that is not mirrored, as Blender exports it.
        [-1.0, -1.0, 1.0, 1.0],
        // A mirrored node above a whole rig.
        [1.0, -1.0, -1.0, 1.0],
        // A mesh of negative scale in an inverse bind matrix, as in FBX files.
        [1.0, -1.0, 1.0, -1.0],
        // A bone that a pose mirrors.
        [1.0, 1.0, -1.0, 1.0],
        // A bone that is mirrored in the bind pose, too.
        [1.0, 1.0, -1.0, -1.0],
    ] {
        let rig = Rig { vertices, node, joint, inverse_bind };

        // π lux along the normal of the near face give a radiance of 1; from inside, the far face would be black.
        let mut stage = skinned_box(rig, lambert(Vec3::ONE));
        stage.add_light(LightKind::Directional, PI, Vec3::ZERO, Vec3::NEG_Z);
        assert_close(stage.look(eye, Vec3::ZERO), Vec3::ONE, 1e-5);
        stage.settings.integrator = Integrator::Path;
        stage.settings.aovs = AovFlags { guides: true, ..AovFlags::NONE };
        let guide = stage.render(eye, Vec3::ZERO).aovs.guides.unwrap()[0];
        assert!(guide.normal.abs_diff_eq(Vec3::Z, 1e-6), "{rig:?} {guide:?}");

        // n = 1 neither refracts nor reflects: with colour c at 0.5 m, c² is left after 1 m.
        let color = Vec3::new(0.9, 0.5, 0.2);
        let volume = Volume { thickness: 1.0, attenuation_distance: 0.5, attenuation_color: color };
        for double_sided in [false, true] {
            let material = Material { double_sided, ..glass(1.0, Some(volume)) };
            let mut stage = skinned_box(rig, material);
            stage.environment = Environment::Constant(Vec3::ONE);
            assert_close(stage.look(eye, Vec3::ZERO), color * color, 1e-5);
        }
    }
}
