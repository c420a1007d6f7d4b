//! What the shading of paths keeps from block to block.

use std::rc::Rc;

use super::dimensions::BounceKeys;
use super::guiding::PhotonStore;
use super::path_block::PathBlock;

/// Buffers of a tracer for paths; unused by Whitted's shading.
#[derive(Debug)]
pub(in crate::integrator) struct PathBuffers {
    /// Taken out while a block is shaded.
    pub(super) block: Option<Box<PathBlock>>,
    /// The keys of the sample points of the shaded paths.
    pub(super) bounce_keys: Rc<BounceKeys>,
    /// What surfaces store of photons; `None` for rays from a camera.
    pub(super) photon_store: Option<PhotonStore>,
}

impl Default for PathBuffers {
    fn default() -> Self {
        Self { block: Some(Box::default()), bounce_keys: Rc::default(), photon_store: None }
    }
}
