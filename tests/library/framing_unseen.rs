//! What the automatic camera and the ground leave out: what no ray hits, and clips that move no surface.

use glam::{Quat, Vec3};
use rayframe::framing::ground_below;
use rayframe::scene::{AnimationTarget, LocalTransform, Node, NodeIndex, Scene, SelectedCamera, ViewRequest};

use crate::framing::{cubes, resolve};
use crate::stage::{animate, select_all};

#[test]
fn what_has_a_scale_of_0_is_not_framed() {
    let seen = [(Vec3::ZERO, 1.0), (Vec3::X * 3.0, 0.5)];
    let shown = resolve(&cubes(&seen), &ViewRequest::default(), 1.5);
    // Elsewhere, in the midst, and below: neither content nor a floor.
    for hidden in [Vec3::Z * -30.0, Vec3::X * 1.5, Vec3::Y * -9.0] {
        let mut scene = cubes(&[seen[0], seen[1], (hidden, 0.5)]);
        scene.nodes[2].local =
            LocalTransform::Trs { translation: hidden, rotation: Quat::IDENTITY, scale: Vec3::ZERO };
        let camera = resolve(&scene, &ViewRequest::default(), 1.5);
        assert_eq!(camera.selection.camera, shown.selection.camera, "{hidden}");
        let ground = |scene: &Scene| {
            let selection = select_all(scene, SelectedCamera::Auto);
            ground_below(scene, &selection, &ViewRequest::default(), false)
        };
        assert_eq!(ground(&scene), ground(&cubes(&seen)), "{hidden}");
    }
}

#[test]
fn clips_that_move_no_surface_change_no_camera() {
    let still = cubes(&[(Vec3::ZERO, 1.0), (Vec3::X * 3.0, 0.5)]);
    let expected = resolve(&still, &ViewRequest::default(), 1.5);
    let mut scene = still;
    scene.nodes.push(Node::default());
    scene.node_order.push(NodeIndex(2));
    animate(&mut scene, AnimationTarget::Translation(NodeIndex(2)), &[0.0; 3], &[9.0, 0.0, 0.0]);
    let camera = resolve(&scene, &ViewRequest::default(), 1.5);
    assert_eq!(camera.selection.camera, expected.selection.camera);
}
