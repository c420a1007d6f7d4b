//! Memory of posed surfaces and their BVH.

use glam::Mat4;

use crate::bvh::{BuilderKind, TriangleFlags};
use crate::frame::{MeshInstance, PosedVertex};
use crate::geometry::Triangle;
use crate::scene::{LocalTransform, NodeIndex, Scene};

/// A posed triangle besides its corners: flags and instance.
const BYTES_A_TAG: u128 = (size_of::<TriangleFlags>() + size_of::<u32>()) as u128;
/// A node of a pose: its transforms, whether it is hidden, and its morph weights.
const BYTES_A_NODE: u128 =
    (size_of::<LocalTransform>() + size_of::<Mat4>() + size_of::<bool>() + size_of::<Option<Vec<f32>>>())
        as u128;
/// A reference: its box (32), keys and scratch of the sort (20), an index and at most a third of a node of the binary tree (26), a slot (40), its
/// share of wide nodes before and after they are joined (40), lists of leaves (6).
const BYTES_A_REFERENCE: u128 = 164;
/// Karras' tree of a reference: the rest of a node of the binary tree (43), a key (16), a node and its parent (24), and its box with a counter (44).
const BYTES_A_RADIX_NODE: u128 = 127;
/// A reference that splitting adds: its box in the lists of parts, besides the above.
const BYTES_A_PART: u128 = 64;
/// A leaf's data for refitting, for each reference.
const BYTES_A_REFITTED_REFERENCE: u128 = 30;
/// The part of a split triangle that refitting follows (12), and its share of the list of leaves from which the parts are found (6).
const BYTES_A_FOLLOWED_PART: u128 = 18;

/// Numbers of what is posed, each instance counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PosedCounts {
    pub(super) triangles: u64,
    pub(super) vertices: u64,
    pub(super) instances: u64,
    pub(super) lights: u64,
    /// Of the whole scene.
    pub(super) nodes: u64,
}

/// What of a sequence poses its surfaces anew.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// The surfaces move between frames or shutter samples.
    pub(super) moves: bool,
    /// The frames before and after are posed, for motion vectors.
    pub(super) is_recorded: bool,
    /// Trees of split triangles are refitted.
    pub(super) follows_parts: bool,
}

/// Bytes of a reference in the build of a tree, and in the data for refitting where that is kept.
fn bytes_a_reference(builder: BuilderKind, motion: Motion) -> u128 {
    let radix_tree = if builder == BuilderKind::Karras { BYTES_A_RADIX_NODE } else { 0 };
    let part = if motion.follows_parts { BYTES_A_FOLLOWED_PART } else { 0 };
    let refitting = if motion.moves { BYTES_A_REFITTED_REFERENCE + part } else { 0 };
    BYTES_A_REFERENCE + radix_tree + refitting
}

/// The same for a reference that splitting adds.
pub(super) fn bytes_a_part(builder: BuilderKind, motion: Motion) -> u128 {
    bytes_a_reference(builder, motion) + BYTES_A_PART
}

impl PosedCounts {
    /// Counts what is below `roots`.
    pub(super) fn of(scene: &Scene, roots: &[NodeIndex]) -> Self {
        let mut counts = Self { nodes: scene.nodes.len() as u64, ..Self::default() };
        for node in scene.nodes_below(roots) {
            let Some(node) = scene.nodes.get(node.index()) else { continue };
            counts.lights += u64::from(node.light.is_some());
            let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh.index())) else { continue };
            let instances = node.instances.as_ref().map_or(1, |instances| instances.len() as u64);
            counts.triangles += mesh.triangle_count() as u64 * instances;
            counts.vertices += mesh.vertex_count() as u64 * instances;
            counts.instances += mesh.primitives.len() as u64 * instances;
        }
        counts
    }

    /// Bytes of one pose.
    pub(super) fn pose_bytes(self) -> u128 {
        u128::from(self.triangles) * (size_of::<Triangle>() as u128 + BYTES_A_TAG)
            + u128::from(self.vertices) * size_of::<PosedVertex>() as u128
            + u128::from(self.instances) * size_of::<MeshInstance>() as u128
    }

    /// Bytes of the poses of a frame, and of its BVH without splits.
    pub(super) fn frame_bytes(self, builder: BuilderKind, motion: Motion) -> u128 {
        let poses = 1 + u128::from(motion.moves) + if motion.is_recorded { 2 } else { 0 };
        // Poses that are made again keep what the nodes were before.
        let nodes = u128::from(self.nodes) * (1 + u128::from(motion.moves));
        poses * (self.pose_bytes() + nodes * BYTES_A_NODE)
            + u128::from(self.triangles) * bytes_a_reference(builder, motion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_surfaces_have_two_poses_and_motion_vectors_two_more() {
        let counts = PosedCounts { triangles: 10, vertices: 7, instances: 0, lights: 0, nodes: 0 };
        let pose = 10 * (36 + 1 + 4) + 7 * 40;
        assert_eq!(counts.pose_bytes(), pose);
        let builder = BuilderKind::Auto;
        let bytes = |moves, is_recorded| {
            counts.frame_bytes(builder, Motion { moves, is_recorded, ..Motion::default() })
        };
        assert_eq!(bytes(false, false), pose + 10 * 164);
        assert_eq!(bytes(true, false), 2 * pose + 10 * 194);
        assert_eq!(bytes(true, true), 4 * pose + 10 * 194);
        assert_eq!(counts.frame_bytes(BuilderKind::Karras, Motion::default()), pose + 10 * 291);
        let nodes = PosedCounts { nodes: 3, ..PosedCounts::default() };
        assert_eq!(nodes.frame_bytes(builder, Motion::default()), 3 * BYTES_A_NODE);
        let moves = Motion { moves: true, ..Motion::default() };
        assert_eq!(nodes.frame_bytes(builder, moves), 2 * 2 * 3 * BYTES_A_NODE);
    }

    #[test]
    fn refitting_split_triangles_keeps_their_parts() {
        let builder = BuilderKind::Auto;
        let bytes = |moves, follows_parts| {
            bytes_a_part(builder, Motion { moves, follows_parts, ..Motion::default() })
        };
        assert_eq!([bytes(true, false), bytes(true, true)], [258, 276]);
        // Trees of resting surfaces are not refitted.
        assert_eq!([bytes(false, false), bytes(false, true)], [228; 2]);
    }
}
