//! Lights and cameras of nodes in world space.

use glam::{Mat3, Mat4, Quat, Vec3, Vec4};

use super::animation::ScenePose;
use crate::geometry::unit;
use crate::scene::{Light, LocalTransform, NodeIndex, Projection, Scene};

/// Lengths, relative to the longest, and angles that may be rounding errors of a product of matrices.
const ROUNDING: f32 = 1e-5;

/// A light in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedLight {
    /// Metres.
    pub position: Vec3,
    /// Unit vector in which the light shines.
    pub direction: Vec3,
    /// Colour, intensity and kind.
    pub light: Light,
}

/// A camera in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedCamera {
    /// Rotation and translation; columns are right, up, backward, position.
    pub world_from_camera: Mat4,
    /// The projection.
    pub projection: Projection,
}

impl Default for PosedCamera {
    fn default() -> Self {
        let fov_y_radians = std::f32::consts::FRAC_PI_4;
        Self {
            world_from_camera: Mat4::IDENTITY,
            projection: Projection::Perspective {
                fov_y_radians,
                aspect_ratio: None,
                z_near: 0.0,
                z_far: None,
            },
        }
    }
}

/// The light of `node`, if it has one. `world` holds the world matrices of all nodes.
pub(super) fn posed_light(
    scene: &Scene,
    pose: &ScenePose,
    node: NodeIndex,
    world: &[Mat4],
) -> Option<PosedLight> {
    let light = pose.lights[scene.nodes[node.index()].light?.index()].clone();
    let (_, backward) = up_and_backward(scene, &pose.local, node, world);
    Some(PosedLight { position: world[node.index()].w_axis.truncate(), direction: -backward, light })
}

/// The camera of `node`, if it has one. `world` holds the world matrices of all nodes.
pub(super) fn posed_camera(
    scene: &Scene,
    pose: &ScenePose,
    node: NodeIndex,
    world: &[Mat4],
) -> Option<PosedCamera> {
    let camera = scene.nodes[node.index()].camera?;
    let (up, backward) = up_and_backward(scene, &pose.local, node, world);
    let right = unit(up.cross(backward)).unwrap_or_else(|| backward.any_orthonormal_vector());
    let up = backward.cross(right);
    let position = world[node.index()].w_axis.truncate();
    Some(PosedCamera {
        world_from_camera: Mat4::from_cols(
            right.extend(0.0),
            up.extend(0.0),
            backward.extend(0.0),
            Vec4::from((position, 1.0)),
        ),
        projection: pose.projections[camera.index()],
    })
}

/// The upward axis of `node`, of any length and not always perpendicular to the unit backward axis. glTF cameras and lights ignore
/// scale: axes that a scale of the node or an ancestor collapses are those of the node with other scales.
fn up_and_backward(scene: &Scene, local: &[LocalTransform], node: NodeIndex, world: &[Mat4]) -> (Vec3, Vec3) {
    let linear = Mat3::from_mat4(world[node.index()]);
    let [_, up, backward] = unit_axes(&linear);
    if let (Some(up), Some(backward)) = (up, backward)
        && up.cross(backward).length() > ROUNDING
    {
        return (linear.y_axis, backward);
    }
    let expanded = expanded_world(scene, local, node);
    let backward = backward.or_else(|| unit(expanded.z_axis)).unwrap_or(Vec3::Z);
    (expanded.y_axis, backward)
}

/// The columns as unit vectors; `None` for those that vanish beside the longest.
fn unit_axes(linear: &Mat3) -> [Option<Vec3>; 3] {
    let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
    let size = |axis: Vec3| axis.abs().max_element();
    let largest = axes.into_iter().map(size).fold(0.0, f32::max);
    axes.map(|axis| unit(axis).filter(|_| size(axis) > ROUNDING * largest))
}

/// The linear part of the world matrix of `node`, up to a factor, if no local transform collapsed an axis.
fn expanded_world(scene: &Scene, local: &[LocalTransform], node: NodeIndex) -> Mat3 {
    let nodes = std::iter::successors(Some(node), |node| scene.nodes[node.index()].parent);
    nodes.fold(Mat3::IDENTITY, |below, node| expanded(&local[node.index()]) * below)
}

/// The linear part of a local transform over its largest scale. Axes that vanish beside that are as long as the longest.
fn expanded(local: &LocalTransform) -> Mat3 {
    match *local {
        LocalTransform::Trs { rotation, scale, .. } => {
            let largest = scale.abs().max_element();
            let factor = |scale: f32| match scale {
                _ if scale.abs() > ROUNDING * largest => scale / largest,
                _ if scale < 0.0 => -1.0,
                _ => 1.0,
            };
            let scale = Vec3::from_array(scale.to_array().map(factor));
            Mat3::from_quat(rotation) * Mat3::from_diagonal(scale)
        }
        LocalTransform::Matrix(matrix) => expanded_matrix(&Mat3::from_mat4(matrix)),
    }
}

/// The matrix over its largest element. Of columns that vanish beside that, one is the cross product of the others, and several are
/// those of the smallest rotation to the column that is left.
fn expanded_matrix(linear: &Mat3) -> Mat3 {
    let units = unit_axes(linear);
    let largest =
        linear.to_cols_array().into_iter().fold(0.0, |largest: f32, element| largest.max(element.abs()));
    let rotation = (0..3).find_map(|i| Some(Quat::from_rotation_arc(Mat3::IDENTITY.col(i), units[i]?)));
    let rotated = Mat3::from_quat(rotation.unwrap_or_default());
    let column = |i: usize| match (units[i], units[(i + 1) % 3], units[(i + 2) % 3]) {
        (Some(_), ..) => linear.col(i) / largest,
        (None, Some(next), Some(last)) => unit(next.cross(last)).unwrap_or(rotated.col(i)),
        _ => rotated.col(i),
    };
    Mat3::from_cols(column(0), column(1), column(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::scene::{
        Camera, CameraChanges, CameraIndex, LightIndex, LightKind, Node, SelectedCamera, Selection,
    };

    /// The last of nodes below one another has a camera and a light.
    fn frame(chain: &[LocalTransform]) -> Frame {
        let parents = std::iter::once(None).chain((0..).map(|parent| Some(NodeIndex(parent))));
        let node = |(&local, parent)| Node {
            local,
            parent,
            camera: Some(CameraIndex(0)),
            light: Some(LightIndex(0)),
            ..Node::default()
        };
        let order: Vec<_> = (0..chain.len() as u32).map(NodeIndex).collect();
        let last = order[chain.len() - 1];
        let scene = Scene {
            nodes: chain.iter().zip(parents).map(node).collect(),
            node_order: order,
            cameras: vec![Camera { name: None, projection: PosedCamera::default().projection }],
            lights: vec![Light {
                name: None,
                color: Vec3::ONE,
                intensity: 1.0,
                range: None,
                kind: LightKind::Directional,
            }],
            ..Scene::default()
        };
        let selection = Selection {
            roots: vec![last],
            clips: Vec::new(),
            camera: SelectedCamera::Node(last),
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: None,
        };
        Frame::at(&scene, &selection, 0.0)
    }

    /// Camera and light of the last node have this rotation.
    #[track_caller]
    fn assert_rotated(chain: &[LocalTransform], rotation: Quat) {
        let frame = frame(chain);
        let camera = Mat3::from_mat4(frame.camera.world_from_camera);
        assert!(camera.abs_diff_eq(Mat3::from_quat(rotation), 1e-5), "{chain:?}: camera {camera}");
        let direction = frame.lights[0].direction;
        assert!(direction.abs_diff_eq(rotation * Vec3::NEG_Z, 1e-5), "{chain:?}: light {direction}");
    }

    fn trs(rotation: Quat, scale: Vec3) -> LocalTransform {
        LocalTransform::Trs { translation: Vec3::new(1.0, 2.0, 3.0), rotation, scale }
    }

    /// The scale where one, two or all factors are 0.
    fn flattened(scale: Vec3) -> impl Iterator<Item = Vec3> {
        (1..8).map(move |axes| {
            Vec3::from_array([0, 1, 2].map(|i| if axes >> i & 1 == 1 { 0.0 } else { scale[i] }))
        })
    }

    #[test]
    fn a_camera_ignores_scale_even_if_negative() {
        let rotation = Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let scaled = trs(rotation, Vec3::new(-2.0, 3.0, 0.5));
        assert_rotated(&[scaled], rotation);
        let position = frame(&[scaled]).camera.world_from_camera.w_axis.truncate();
        assert_eq!(position, Vec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn scales_of_0_keep_the_rotation() {
        let rotation = Quat::from_xyzw(0.1, -0.5, 0.7, 0.5).normalize();
        let parent = Quat::from_rotation_x(0.4);
        for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::new(-2.0, 3.0, 0.5)] {
            for flat in flattened(scale) {
                assert_rotated(&[trs(rotation, flat)], rotation);
                assert_rotated(&[trs(parent, Vec3::ONE), trs(rotation, flat)], parent * rotation);
                assert_rotated(&[trs(rotation, flat), trs(Quat::IDENTITY, Vec3::ONE)], rotation);
                assert_rotated(&[trs(parent, Vec3::ZERO), trs(rotation, flat)], parent * rotation);
            }
        }
        // Scales whose product underflows.
        let tiny = Vec3::splat(1e-30);
        assert_rotated(&[trs(parent, tiny), trs(rotation, tiny)], parent * rotation);
    }

    #[test]
    fn rounding_errors_are_no_directions() {
        // Turned downwards, the axis that the parent collapses is that of the light or of what is up.
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let parent = Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        for flat in [Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 0.0)] {
            assert_rotated(&[trs(parent, flat), trs(down, Vec3::ONE)], parent * down);
        }
        // Where both have one direction, up is that without the scale.
        let pitch = Quat::from_rotation_x(-0.8);
        let camera = frame(&[trs(parent, Vec3::new(1.0, 1.0, 0.0)), trs(pitch, Vec3::ONE)]).camera;
        let right = camera.world_from_camera.x_axis.truncate();
        assert!(right.abs_diff_eq(parent * Vec3::X, 1e-5), "{right}");
    }

    #[test]
    fn columns_of_0_of_a_matrix_are_rebuilt() {
        let rotation = Quat::from_xyzw(0.1, -0.5, 0.7, 0.5).normalize();
        let matrix = |scale| LocalTransform::Matrix(Mat4::from_quat(rotation) * Mat4::from_scale(scale));
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert_rotated(&[matrix(2.0 * (Vec3::ONE - axis))], rotation);
        }
        // Two columns of 0 leave the roll open.
        let turned = Quat::from_rotation_arc(Vec3::Z, rotation * Vec3::Z);
        assert_rotated(&[matrix(Vec3::Z)], turned);
        assert_rotated(&[matrix(Vec3::ZERO)], Quat::IDENTITY);
    }
}
