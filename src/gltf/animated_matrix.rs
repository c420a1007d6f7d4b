//! Matrices of animated nodes. They are invalid, but exporters write them, and other programs play them.
//!
//! Source: glTF 2.0 specification, section 3.5.3 (transformations).

use super::context::Context;
use crate::scene::{Animation, AnimationTarget, DecomposedMatrix, LocalTransform, Node};

/// Replaces the matrices of nodes whose translation, rotation or scale is animated by these three, with a warning.
pub(super) fn decompose(context: &mut Context, nodes: &mut [Node], animations: &[Animation]) {
    for channel in animations.iter().flat_map(|animation| &animation.channels) {
        let (AnimationTarget::Translation(index)
        | AnimationTarget::Rotation(index)
        | AnimationTarget::Scale(index)) = channel.target
        else {
            continue;
        };
        let Some(node) = nodes.get_mut(index.index()) else { continue };
        let LocalTransform::Matrix(matrix) = &node.local else { continue };
        let parts = DecomposedMatrix::new(matrix);
        let message = if parts.has_shear {
            "some matrices of animated nodes shear; their translation, rotation and scale are used, the shear is left out"
        } else {
            "some animated nodes have a matrix; its translation, rotation and scale are used"
        };
        context.warn(format!("/nodes/{}/matrix", index.0), message);
        node.local = parts.into();
    }
}
