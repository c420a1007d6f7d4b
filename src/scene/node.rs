//! Nodes and skins.

use glam::{Mat4, Quat, Vec3, Vec4};

use super::{CameraIndex, LightIndex, MeshIndex, NodeIndex};

/// Node of the transform hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Parent node.
    pub parent: Option<NodeIndex>,
    /// Child nodes.
    pub children: Vec<NodeIndex>,
    /// Transform relative to the parent, before animation.
    pub local: LocalTransform,
    /// Mesh of the node.
    pub mesh: Option<MeshIndex>,
    /// Skin that deforms the mesh.
    pub skin: Option<super::SkinIndex>,
    /// Morph weights that override the mesh's.
    pub weights: Option<Vec<f32>>,
    /// Camera of the node, which looks along −Z.
    pub camera: Option<CameraIndex>,
    /// Light of the node, which shines along −Z.
    pub light: Option<LightIndex>,
    /// Transforms of mesh instances relative to the node (`EXT_mesh_gpu_instancing`); `None` is one instance at the node.
    pub instances: Option<Vec<Mat4>>,
    /// Linear colours of these instances, which multiply the base colour (`_COLOR_0`); empty without any.
    pub instance_colors: Vec<Vec4>,
    /// Whether the node and its descendants are hidden; clips may animate it.
    pub is_hidden: bool,
}

/// Transform relative to the parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// Translation · rotation · scale, which clips can animate.
    Trs {
        /// Metres.
        translation: Vec3,
        /// Unit quaternion.
        rotation: Quat,
        /// Factors along the axes; may be negative or zero.
        scale: Vec3,
    },
    /// Any affine matrix.
    Matrix(Mat4),
}

impl LocalTransform {
    /// The matrix from the node to its parent.
    pub fn matrix(&self) -> Mat4 {
        match *self {
            Self::Trs { translation, rotation, scale } => {
                Mat4::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(matrix) => matrix,
        }
    }
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

/// Skin: joints that deform a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// The nodes that act as joints.
    pub joints: Vec<NodeIndex>,
    /// Matrices from mesh space to the joints' spaces in the bind pose, one for each joint.
    pub inverse_bind_matrices: Vec<Mat4>,
}
