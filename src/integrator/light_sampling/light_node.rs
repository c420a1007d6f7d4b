//! Nodes of light trees.

use glam::Vec3;

use super::light_bounds::CompactLightBounds;

/// A node of a light tree. Siblings follow each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightNode {
    bounds: CompactLightBounds,
    /// The index of the first child or of the emitter, with two flags.
    content: u32,
}

impl LightNode {
    const LEAF: u32 = 1 << 31;
    const TWO_SIDED: u32 = 1 << 30;
    /// Most nodes and emitters of a tree.
    pub(super) const LIMIT: usize = 1 << 30;

    /// A node of one emitter.
    pub(super) fn leaf(bounds: CompactLightBounds, is_two_sided: bool, emitter: u32) -> Self {
        Self { bounds, content: emitter | Self::LEAF | if is_two_sided { Self::TWO_SIDED } else { 0 } }
    }

    /// A node of two children.
    pub(super) fn inner(bounds: CompactLightBounds, is_two_sided: bool, first_child: u32) -> Self {
        Self { bounds, content: first_child | if is_two_sided { Self::TWO_SIDED } else { 0 } }
    }

    pub(super) fn is_leaf(&self) -> bool {
        self.content & Self::LEAF != 0
    }

    /// The index of the first child, or of the emitter.
    pub(super) fn index(&self) -> usize {
        (self.content & !(Self::LEAF | Self::TWO_SIDED)) as usize
    }

    /// See [`CompactLightBounds::importance`].
    #[inline]
    pub(super) fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        self.bounds.importance(point, normal, self.content & Self::TWO_SIDED != 0)
    }
}
