//! Mesh instances: one primitive of a mesh under one node.

use glam::{Vec2, Vec4};

use crate::scene::{MaterialIndex, MeshIndex, NodeIndex, Primitive, Scene};

use super::deform::MorphedAttributes;

/// One mesh primitive under one node, or under one of the node's GPU instances.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshInstance {
    /// The node of the mesh.
    pub node: NodeIndex,
    /// Index of the node's GPU instances (`EXT_mesh_gpu_instancing`); 0 for a node without any.
    pub node_instance: u32,
    /// The mesh.
    pub mesh: MeshIndex,
    /// Index of the mesh's primitives.
    pub primitive: usize,
    /// The material in the selected variant.
    pub material: MaterialIndex,
    /// Id of the first triangle, an index of [`super::Frame::triangles`].
    pub first_triangle: u32,
    /// Index of the first vertex in [`super::Frame::vertices`].
    pub first_vertex: usize,
    /// Whether the transform mirrors, which swaps the second and third corner of each triangle.
    pub mirrored: bool,
    /// See [`Primitive::is_inside_out`].
    pub is_inside_out: bool,
    /// Linear colour of the GPU instance, which multiplies the base colour.
    pub(super) color: Option<Vec4>,
    pub(super) morphed: MorphedAttributes,
}

impl MeshInstance {
    /// The mesh primitive in mesh space.
    pub fn primitive<'s>(&self, scene: &'s Scene) -> &'s Primitive {
        &scene.meshes[self.mesh.index()].primitives[self.primitive]
    }

    /// Texture coordinates of set `set` at three vertices; zero if the primitive has no such set.
    #[inline(always)]
    pub fn uvs(&self, scene: &Scene, set: usize, corners: [u32; 3]) -> [Vec2; 3] {
        self.stored_uvs(scene, set, corners).unwrap_or_default()
    }

    /// Texture coordinates of set `set` at three vertices; `None` where there is no such set.
    #[inline(always)]
    pub fn stored_uvs(&self, scene: &Scene, set: usize, corners: [u32; 3]) -> Option<[Vec2; 3]> {
        let sets = self.morphed.uvs.as_ref().unwrap_or(&self.primitive(scene).uvs);
        Some(gathered(sets.get(set)?, corners))
    }

    /// Whether the primitive has vertex colours, or the instance a colour.
    pub fn has_colors(&self, scene: &Scene) -> bool {
        self.vertex_colors(scene).is_some() || self.color.is_some()
    }

    /// Linear vertex colours at three vertices, times the colour of the instance; `None` without either.
    #[inline(always)]
    pub fn colors(&self, scene: &Scene, corners: [u32; 3]) -> Option<[Vec4; 3]> {
        let at_corners = self.vertex_colors(scene).map(|colors| gathered(colors, corners));
        match self.color {
            Some(own) => Some(at_corners.map_or([own; 3], |colors| colors.map(|color| color * own))),
            None => at_corners,
        }
    }

    fn vertex_colors<'s>(&'s self, scene: &'s Scene) -> Option<&'s Vec<Vec4>> {
        self.morphed.colors.as_ref().or(self.primitive(scene).colors.as_ref())
    }
}

/// The values at three corners.
#[inline(always)]
fn gathered<T: Copy>(values: &[T], [a, b, c]: [u32; 3]) -> [T; 3] {
    [values[a as usize], values[b as usize], values[c as usize]]
}
