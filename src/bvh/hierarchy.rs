//! Hierarchy of one frame and its queries.

use super::build::Refitter;
use super::hit::{Hit, HitOrder};
use super::reference::TriangleList;
use super::statistics::{BuildStatistics, TraversalCounters};
use super::traverse::{AnyHit, Batch, ClosestHit, LeafIntersector, traverse};
use super::wide_tree::WideTree;
use crate::geometry::Ray;

/// Bounding volume hierarchy over one frame's triangles.
#[derive(Debug)]
pub struct Bvh {
    pub(super) structure: Structure,
    pub(super) level: fearless_simd::Level,
    pub(super) statistics: BuildStatistics,
    pub(super) refitter: Refitter,
}

/// Data that rays traverse.
#[derive(Debug)]
pub(super) enum Structure {
    /// Tree with eight children per node.
    Wide(WideTree),
    /// List of triangles, for tests.
    BruteForce(TriangleList),
}

impl Bvh {
    /// Instruction set of queries, and of what is computed from their hits.
    pub(crate) fn simd_level(&self) -> fearless_simd::Level {
        self.level
    }

    /// Statistics of the build.
    pub fn statistics(&self) -> BuildStatistics {
        self.statistics
    }

    /// Closest visible hit of `ray` after `after`. Back faces of single-sided triangles are ignored. `filter` accepts or
    /// rejects hits with filtered triangles and is not called for others; being transmissive does not matter here.
    pub fn closest_hit(
        &self,
        ray: &Ray,
        after: Option<HitOrder>,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        self.closest(ray, ClosestHit::<true>::new(ray, after, &filter), counters)
    }

    /// Closest hit of `ray` after `after`, with either side of any triangle. `filter` accepts or rejects hits with filtered
    /// and transmissive triangles and is not called for others.
    pub fn closest_hit_of_any_side(
        &self,
        ray: &Ray,
        after: Option<HitOrder>,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        self.closest(ray, ClosestHit::<false>::new(ray, after, &filter), counters)
    }

    /// Whether `ray` hits any triangle from either side. Filtered and transmissive triangles count where `filter` accepts the
    /// hit.
    ///
    /// The order of the calls of `filter` is not defined.
    pub fn occluded(
        &self,
        ray: &Ray,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        counters.rays += 1;
        let mut any = AnyHit::new(ray, &filter);
        match &self.structure {
            Structure::Wide(tree) => traverse(self.level, &LeafIntersector { tree, ray }, &mut any, counters),
            Structure::BruteForce(list) => list.traverse(ray, &mut any, counters),
        }
        any.found
    }

    /// [`Bvh::closest_hit`] of every ray of a batch. `hits[i]` receives the hit of `rays[i]`; `filter` gets the ray's index.
    ///
    /// Neighbours in the batch share their traversal where they can, so coherent rays should be adjacent.
    pub fn closest_hits(
        &self,
        rays: &[Ray],
        filter: impl Fn(usize, &Hit) -> bool,
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) {
        counters.rays += rays.len() as u64;
        match &self.structure {
            Structure::Wide(tree) => {
                let batch = Batch { level: self.level, tree, rays, filter: &filter };
                batch.closest_hits(hits, counters);
            }
            Structure::BruteForce(list) => {
                for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
                    let filter = |hit: &Hit| filter(i, hit);
                    let mut closest = ClosestHit::<true>::new(ray, None, &filter);
                    list.traverse(ray, &mut closest, counters);
                    *hit = closest.exact();
                }
            }
        }
    }

    /// [`Bvh::occluded`] of every ray of a batch. `occluded[i]` receives the answer of `rays[i]`; `filter` gets the ray's
    /// index.
    pub fn occluded_rays(
        &self,
        rays: &[Ray],
        filter: impl Fn(usize, &Hit) -> bool,
        occluded: &mut [bool],
        counters: &mut TraversalCounters,
    ) {
        counters.rays += rays.len() as u64;
        match &self.structure {
            Structure::Wide(tree) => {
                let batch = Batch { level: self.level, tree, rays, filter: &filter };
                batch.occluded_rays(occluded, counters);
            }
            Structure::BruteForce(list) => {
                for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
                    let filter = |hit: &Hit| filter(i, hit);
                    let mut any = AnyHit::new(ray, &filter);
                    list.traverse(ray, &mut any, counters);
                    *occluded = any.found;
                }
            }
        }
    }

    fn closest<const CULL: bool>(
        &self,
        ray: &Ray,
        mut closest: ClosestHit<CULL>,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        counters.rays += 1;
        match &self.structure {
            Structure::Wide(tree) => {
                let leaves = LeafIntersector { tree, ray };
                traverse(self.level, &leaves, &mut closest, counters);
                closest.finish(&leaves)
            }
            Structure::BruteForce(list) => {
                list.traverse(ray, &mut closest, counters);
                closest.exact()
            }
        }
    }
}
