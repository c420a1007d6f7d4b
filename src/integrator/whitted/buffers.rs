//! What the shading of Whitted's tree keeps from block to block.

use super::block_lookups::BlockLookups;
use super::lookup_keys::LookupKeys;
use super::occluder_buffers::OccluderBuffers;
use super::opaque_block::OpaqueBlock;
use super::sampled_lookups::SampledLookups;
use crate::integrator::lights::IncidenceLanes;

/// Buffers of a tracer for Whitted's shading; unused by paths.
#[derive(Debug)]
pub(in crate::integrator) struct WhittedBuffers<'a> {
    /// For each light what arrives at the points of a block without occlusion.
    pub(super) block_incidences: Vec<IncidenceLanes>,
    /// What those points see of the environment.
    pub(super) block_lookups: BlockLookups,
    /// Taken out while a block is shaded.
    pub(super) opaque_block: Option<Box<OpaqueBlock<'a>>>,
    /// The keys of the sample points of environment lookups.
    pub(super) lookup_keys: LookupKeys,
    /// Lookups of blocks whose shadow rays are sampled together.
    pub(super) sampled_lookups: SampledLookups,
    /// Taken out while it is filled.
    pub(super) occluders: OccluderBuffers,
}

impl WhittedBuffers<'_> {
    /// Empty buffers for a scene with so many lights.
    pub(in crate::integrator) fn new(lights: usize) -> Self {
        Self {
            block_incidences: Vec::new(),
            block_lookups: BlockLookups::default(),
            opaque_block: Some(Box::new(OpaqueBlock::new(lights))),
            lookup_keys: LookupKeys::default(),
            sampled_lookups: SampledLookups::default(),
            occluders: OccluderBuffers::default(),
        }
    }
}
