//! The scene at one time: world-space triangles with their attributes, materials, lights and the camera.
//!
//! [`Frame::at`] is a pure function of scene, selection and time. [`Frame::pose`] does the same and reuses the memory of an earlier
//! frame; [`Frame::pose_again`] keeps what has not moved. Posing runs the animation, then computes node matrices, then morphs, skins and transforms every primitive
//! under the selected roots. Triangle ids are indices of [`Frame::triangles`]. They cover all of these primitives, hidden ones
//! included, and are the same at every time. This module builds no acceleration structure.

mod animation;
mod camera;
mod content;
mod deform;
mod material_flags;
mod mesh_instance;
mod node_pose;
mod node_triangles;
mod posed_nodes;
mod surface_pose;
mod surfaces;
mod transform;
mod unmoved;

pub use content::{PosedContent, PosedMesh};
pub use deform::PosedVertex;
pub(crate) use deform::VertexParts;
pub use mesh_instance::MeshInstance;
pub(crate) use node_pose::NodePose;
pub use posed_nodes::{PosedCamera, PosedLight};
pub use surfaces::Frame;

#[cfg(test)]
mod tests;
