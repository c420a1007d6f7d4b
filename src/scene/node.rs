//! Nodes and skins.

use glam::{Mat4, Quat, Vec3};

use super::{CameraIndex, LightIndex, MeshIndex, NodeIndex};

/// A node of the transform hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// The node above.
    pub parent: Option<NodeIndex>,
    /// The nodes below.
    pub children: Vec<NodeIndex>,
    /// Transform relative to the parent, before animation.
    pub local: LocalTransform,
    /// Geometry drawn here.
    pub mesh: Option<MeshIndex>,
    /// Skin that deforms `mesh`.
    pub skin: Option<super::SkinIndex>,
    /// Morph weights that replace the mesh's.
    pub weights: Option<Vec<f32>>,
    /// Camera placed here.
    pub camera: Option<CameraIndex>,
    /// Light placed here, looking down −Z.
    pub light: Option<LightIndex>,
    /// Where the mesh is drawn instead of once, relative to the node; `None` draws it once at the node.
    pub instances: Option<Vec<Mat4>>,
    /// Whether this node and all below it are hidden while no clip says otherwise.
    pub is_hidden: bool,
}

/// A transform relative to the parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// Translation · rotation · scale; the form that can be animated.
    Trs {
        /// Metres.
        translation: Vec3,
        /// Unit quaternion.
        rotation: Quat,
        /// Factor an axis; may be negative or zero.
        scale: Vec3,
    },
    /// Any affine matrix.
    Matrix(Mat4),
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

/// Joints that deform a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// The nodes that act as joints.
    pub joints: Vec<NodeIndex>,
    /// One matrix a joint, from mesh space to the joint's space in the bind pose.
    pub inverse_bind_matrices: Vec<Mat4>,
}
