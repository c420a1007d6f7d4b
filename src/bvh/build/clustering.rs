//! Clustering of the radix tree: its setting, and what a task of [`super::hploc`] gets and gives.

use super::binary_tree::{PackedPair, Subtree};
use super::clusters::{Clusters, Join, Search};
use super::morton::MortonOrder;
use crate::bvh::references::Reference;
use crate::cancel::CancelFlag;

/// How far the nodes of the radix tree are clustered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clustering {
    /// Positions to either side among which the nearest cluster is searched.
    pub(crate) radius: u32,
    /// Clusters that every node may pass on.
    pub(crate) min_clusters: usize,
    /// References per cluster that a large node passes on.
    pub(crate) references_per_cluster: usize,
    /// Maximum of clusters that a node passes on, and that the root splits.
    pub(crate) max_clusters: usize,
}

/// Inputs of the builder.
#[derive(Clone, Copy)]
pub(crate) struct Input<'a> {
    /// References in Morton order.
    pub(crate) order: &'a MortonOrder,
    /// The references.
    pub(crate) references: &'a [Reference],
    /// Factor of lengths before areas are computed.
    pub(crate) scale: f32,
    /// How far to cluster.
    pub(crate) clustering: Clustering,
    /// Cancels the build when raised.
    pub(crate) cancel: &'a CancelFlag,
}

/// Output of a range of positions: a node and a triangle index for each.
pub(crate) struct Output<'a> {
    /// First position.
    pub(crate) first: usize,
    /// Nodes; a range needs one less than it has positions, and uses the first ones.
    pub(crate) nodes: &'a mut [PackedPair],
    /// Triangle indices in the order of leaves.
    pub(crate) triangle_ids: &'a mut [u32],
}

/// Clusters of a range, and the sum of their nodes' areas.
pub(crate) struct Built {
    /// The clusters in Morton order.
    pub(crate) clusters: Vec<Subtree>,
    /// Sum of the areas of all nodes below.
    pub(crate) area_sum: f64,
}

impl Clustering {
    /// Karras' radix tree.
    pub(crate) const NONE: Self =
        Self { radius: 1, min_clusters: 1, references_per_cluster: usize::MAX, max_clusters: 1 };

    /// The clustered tree.
    pub(crate) const MERGED: Self =
        Self { radius: 4, min_clusters: 64, references_per_cluster: 64, max_clusters: 1024 };

    /// Clusters that a node of `references` may pass on.
    #[inline(always)]
    pub(crate) fn threshold(&self, references: usize) -> usize {
        (references / self.references_per_cluster).clamp(self.min_clusters, self.max_clusters)
    }
}

impl Input<'_> {
    /// Reference at a position.
    #[inline(always)]
    pub(crate) fn reference(&self, position: usize) -> &Reference {
        &self.references[self.order.index(position) as usize]
    }

    /// Merges the clusters from `first` on, those of a node of `references`, if they are more than its threshold.
    #[inline(always)]
    pub(crate) fn limit(
        &self,
        clusters: &mut Clusters,
        first: usize,
        references: usize,
        sink: &mut impl Join,
    ) {
        let threshold = self.clustering.threshold(references);
        if clusters.len() - first > threshold {
            let search = Search { radius: self.clustering.radius, scale: self.scale };
            clusters.merge_from(first, threshold, search, sink);
        }
    }
}
