//! Nodes of the binary trees from which light trees are made.

use super::light_bounds::CompactLightBounds;

/// A node of a binary tree over emitters. Siblings follow each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightNode {
    pub(super) bounds: CompactLightBounds,
    pub(super) is_two_sided: bool,
    pub(super) content: Content,
}

/// What a node holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// The emitter of this index.
    Emitter(u32),
    /// The nodes of this index and the next.
    Children(u32),
}

impl LightNode {
    /// Most nodes and emitters of a tree.
    pub(super) const LIMIT: usize = 1 << 30;
}
