//! The triangles that nodes move.

use std::ops::Range;

use glam::Vec3;

use super::Frame;
use crate::bvh::is_traced;
use crate::geometry::Aabb;
use crate::scene::{NodeIndex, Scene};

impl Frame {
    /// Ids of the triangles of an instance.
    pub(crate) fn triangle_range(&self, instance: usize) -> Range<usize> {
        let next = self.instances.get(instance + 1);
        let end = next.map_or(self.triangles.len(), |next| next.first_triangle as usize);
        self.instances[instance].first_triangle as usize..end
    }

    /// For each triangle, whether it follows `node` or a node below it: as part of its mesh, or as skin to joints among them, which have most of
    /// the weight of one of its vertices.
    pub(crate) fn triangles_of_node(&self, scene: &Scene, node: NodeIndex) -> Vec<bool> {
        let below = descendants(scene, node);
        let mut belongs = vec![false; self.triangles.len()];
        for (index, instance) in self.instances.iter().enumerate() {
            let triangles = &mut belongs[self.triangle_range(index)];
            let node = &scene.nodes[instance.node.index()];
            if below[instance.node.index()] {
                triangles.fill(true);
                continue;
            }
            let primitive = &scene.meshes[instance.mesh.index()].primitives[instance.primitive];
            let skin = node.skin.and_then(|skin| scene.skins.get(skin.index()));
            let (Some(skin), Some(influences)) = (skin, &primitive.influences) else { continue };
            let follows = |vertex: u32| {
                let own =
                    vertex as usize * influences.per_vertex..(vertex as usize + 1) * influences.per_vertex;
                let pairs = influences.joints[own.clone()].iter().zip(&influences.weights[own]);
                let is_below =
                    |joint: u32| skin.joints.get(joint as usize).is_some_and(|node| below[node.index()]);
                pairs.filter(|(joint, _)| is_below(**joint)).map(|(_, weight)| weight).sum::<f32>() > 0.5
            };
            for (belongs, corners) in triangles.iter_mut().zip(&primitive.triangles) {
                *belongs = corners.iter().any(|&vertex| follows(vertex));
            }
        }
        belongs
    }

    /// Centre of the bounds of the visible triangles that follow a node, metres; its origin where there are none, and `None` for an index that the posed
    /// scene does not have.
    pub(crate) fn node_center(&self, scene: &Scene, node: NodeIndex) -> Option<Vec3> {
        let origin = self.node_position(node)?;
        let belongs = self.triangles_of_node(scene, node);
        let mut bounds = Aabb::EMPTY;
        for ((triangle, flags), belongs) in self.triangles.iter().zip(&self.flags).zip(belongs) {
            if belongs && is_traced(triangle, *flags) {
                bounds = bounds.union(triangle.bounds());
            }
        }
        Some(if bounds.is_empty() { origin } else { bounds.center() })
    }
}

/// For each node, whether it is `node` or below it.
fn descendants(scene: &Scene, node: NodeIndex) -> Vec<bool> {
    let mut is_below = vec![false; scene.nodes.len()];
    let mut pending = vec![node];
    while let Some(index) = pending.pop() {
        is_below[index.index()] = true;
        pending.extend_from_slice(&scene.nodes[index.index()].children);
    }
    is_below
}
