//! Lights and cameras of nodes in world space.

use glam::{Mat4, Vec3, Vec4};

use crate::geometry::unit;
use crate::scene::{Light, NodeIndex, Projection, Scene};

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

/// The light of `node`, if it has one. `lights` holds the scene's lights at the time, `world` the world matrices of all nodes.
pub(super) fn posed_light(
    scene: &Scene,
    lights: &[Light],
    node: NodeIndex,
    world: &[Mat4],
) -> Option<PosedLight> {
    let light = lights[scene.nodes[node.index()].light?.index()].clone();
    let matrix = &world[node.index()];
    let direction = unit(-matrix.z_axis.truncate()).unwrap_or(Vec3::NEG_Z);
    Some(PosedLight { position: matrix.w_axis.truncate(), direction, light })
}

/// The camera of `node`, if it has one. `projections` holds those of the scene's cameras at the time.
pub(super) fn posed_camera(
    scene: &Scene,
    projections: &[Projection],
    node: NodeIndex,
    world: &[Mat4],
) -> Option<PosedCamera> {
    let camera = scene.nodes[node.index()].camera?;
    Some(PosedCamera {
        world_from_camera: without_scale(&world[node.index()]),
        projection: projections[camera.index()],
    })
}

/// The nearest rotation and translation. glTF cameras ignore scale.
fn without_scale(matrix: &Mat4) -> Mat4 {
    let backward = unit(matrix.z_axis.truncate()).unwrap_or(Vec3::Z);
    let up = matrix.y_axis.truncate();
    let right = unit(up.cross(backward)).unwrap_or_else(|| backward.any_orthonormal_vector());
    let up = backward.cross(right);
    let position = matrix.w_axis.truncate();
    Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), Vec4::from((position, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_ignores_scale_even_if_negative() {
        let rotation = glam::Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let position = Vec3::new(1.0, 2.0, 3.0);
        let expected = Mat4::from_rotation_translation(rotation, position);
        let scaled = Mat4::from_scale_rotation_translation(Vec3::new(-2.0, 3.0, 0.5), rotation, position);
        assert!(without_scale(&scaled).abs_diff_eq(expected, 1e-6));
    }
}
