//! Tracing rays through the wide tree: one at a time, or in tiles of neighbours.
//!
//! A batch of rays is cut into tiles of up to 64 that follow each other. A tile whose rays have one depth axis, and run the same way
//! along it, is walked at once ([`packet`]). The rays of another one are sorted by direction ([`bundles`]), and each bundle is tried as a tile of its
//! own; what is no tile then are single rays ([`single`]).

mod bundles;
mod edges;
mod frustum;
#[cfg(test)]
mod lane_tests;
mod packet;
mod resolve;
mod single;
mod stack;
mod tile;
mod tile_query;

use fearless_simd::{Level, Simd, dispatch};

use super::query::{Any, BatchFilter, Judge, Nearest, Visitor};
use super::wide::{Leaf, WideTree};
use super::{Hit, TraversalCounters};
use crate::geometry::Ray;
use bundles::Bundles;
use packet::Refine;
use tile::{TILE, Tile};
use tile_query::{AnyOfTile, NearestOfTile};

/// Runs a task at the levels that tiles are compiled for, which have eight lanes or more, or many registers; false at others,
/// where single rays serve as well.
macro_rules! wide_dispatch {
    ($level:expr, $simd:ident => $task:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512($simd) => $simd.vectorize(
                #[inline(always)]
                || $task,
            ),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2($simd) => $simd.vectorize(
                #[inline(always)]
                || $task,
            ),
            #[cfg(target_arch = "aarch64")]
            Level::Neon($simd) => $simd.vectorize(
                #[inline(always)]
                || $task,
            ),
            _ => false,
        }
    };
}

/// Fewer rays than this are traced one by one.
const SMALLEST_TILE: usize = 8;
/// Tiles from one point that spread less than this over a unit of depth test boxes at leaves only.
const NARROW: f32 = 0.06;

/// Rays that had to be sorted, are fewer than [`MANY`] and spread more than this over a unit of depth have little in common.
const SCATTERED: f32 = 1.0;
/// See [`SCATTERED`].
const MANY: usize = 24;

/// Walks the judge's tree with its ray. Eight lanes are all that a single ray uses, so AVX2 serves it best.
pub(super) fn walk<V: Visitor>(
    level: Level,
    judge: &Judge,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    let level = level.as_avx2().map_or(level, Level::Avx2);
    dispatch!(level, simd => single::walk(simd, judge, visitor, counters));
}

/// A batch of rays for one tree.
#[derive(Clone, Copy)]
pub(super) struct Batch<'a> {
    /// What runs.
    pub(super) level: Level,
    /// The tree.
    pub(super) tree: &'a WideTree,
    /// The rays.
    pub(super) rays: &'a [Ray],
    /// Asked about hits with filtered triangles.
    pub(super) filter: BatchFilter<'a>,
}

/// Finds the first visible hits of a batch.
pub(super) fn closest_hits(batch: Batch, hits: &mut [Option<Hit>], counters: &mut TraversalCounters) {
    let mut tile = Tile::EMPTY;
    for (part, hits) in batch.parts().zip(hits.chunks_mut(TILE)) {
        if part.hits_of_tile(&mut tile, None, hits, counters) {
            continue;
        }
        let bundles = Bundles::new(part.batch.rays);
        let mut sorted = [None; TILE];
        for range in bundles.ranges() {
            let (bundle, from) = part.bundle(&bundles, range);
            let sorted = &mut sorted[..from.len()];
            if !bundle.hits_of_tile(&mut tile, Some(from), sorted, counters) {
                bundle.hits_one_by_one(from, sorted, counters);
            }
            for (&from, hit) in from.iter().zip(sorted) {
                hits[usize::from(from)] = *hit;
            }
        }
    }
}

/// Finds which rays of a batch meet anything.
pub(super) fn occluded_rays(batch: Batch, occluded: &mut [bool], counters: &mut TraversalCounters) {
    let mut tile = Tile::EMPTY;
    for (part, occluded) in batch.parts().zip(occluded.chunks_mut(TILE)) {
        if part.occlusion_of_tile(&mut tile, None, occluded, counters) {
            continue;
        }
        let bundles = Bundles::new(part.batch.rays);
        let mut sorted = [false; TILE];
        for range in bundles.ranges() {
            let (bundle, from) = part.bundle(&bundles, range);
            let sorted = &mut sorted[..from.len()];
            if !bundle.occlusion_of_tile(&mut tile, Some(from), sorted, counters) {
                bundle.occlusion_one_by_one(from, sorted, counters);
            }
            for (&from, is_occluded) in from.iter().zip(sorted) {
                occluded[usize::from(from)] = *is_occluded;
            }
        }
    }
}

/// Up to [`TILE`] rays of a batch.
struct Part<'a> {
    /// These rays alone.
    batch: Batch<'a>,
    /// The subscript of the first in the batch.
    first: usize,
}

impl<'a> Batch<'a> {
    fn parts(self) -> impl Iterator<Item = Part<'a>> {
        let parts = self.rays.chunks(TILE).enumerate();
        parts.map(move |(i, rays)| Part { batch: Batch { rays, ..self }, first: i * TILE })
    }
}

impl<'a> Part<'a> {
    /// The rays of a bundle, and their subscripts here.
    fn bundle<'b>(&self, bundles: &'b Bundles, range: std::ops::Range<usize>) -> (Part<'b>, &'b [u8])
    where
        'a: 'b,
    {
        let rays = &bundles.rays[range.clone()];
        (Part { batch: Batch { rays, ..self.batch }, first: self.first }, &bundles.from[range])
    }

    /// Traces the rays as a tile, if that is worth it. Rays that were sorted come `from` other subscripts.
    fn hits_of_tile(
        &self,
        tile: &mut Tile,
        from: Option<&[u8]>,
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Batch { level, tree, rays, filter } = self.batch;
        if !self.is_worth_a_tile() {
            return false;
        }
        let filter = |ray: usize, hit: &Hit| filter(self.first + ray, hit);
        let mut visitor = NearestOfTile { tree, rays, from, filter: &filter };
        wide_dispatch!(level, simd => closest_hits_of_tile(simd, tile, &mut visitor, hits, counters))
    }

    fn hits_one_by_one(&self, from: &[u8], hits: &mut [Option<Hit>], counters: &mut TraversalCounters) {
        for ((ray, &from), hit) in self.batch.rays.iter().zip(from).zip(hits) {
            let filter = |hit: &Hit| (self.batch.filter)(self.first + usize::from(from), hit);
            let judge = Judge { tree: self.batch.tree, ray };
            let mut nearest = Nearest::<true>::new(ray, None, &filter);
            walk(self.batch.level, &judge, &mut nearest, counters);
            *hit = nearest.finish(&judge);
        }
    }

    fn occlusion_one_by_one(&self, from: &[u8], occluded: &mut [bool], counters: &mut TraversalCounters) {
        for ((ray, &from), occluded) in self.batch.rays.iter().zip(from).zip(occluded) {
            let filter = |hit: &Hit| (self.batch.filter)(self.first + usize::from(from), hit);
            let mut any = Any::new(ray, &filter);
            walk(self.batch.level, &Judge { tree: self.batch.tree, ray }, &mut any, counters);
            *occluded = any.found;
        }
    }

    fn occlusion_of_tile(
        &self,
        tile: &mut Tile,
        from: Option<&[u8]>,
        occluded: &mut [bool],
        counters: &mut TraversalCounters,
    ) -> bool {
        let Batch { level, tree, rays, filter } = self.batch;
        if !self.is_worth_a_tile() {
            return false;
        }
        let filter = |ray: usize, hit: &Hit| filter(self.first + ray, hit);
        let mut visitor = AnyOfTile::new(tree, rays, from, &filter);
        wide_dispatch!(level, simd => occlusion_of_tile(simd, tile, &mut visitor, occluded, counters))
    }

    fn is_worth_a_tile(&self) -> bool {
        self.batch.rays.len() >= SMALLEST_TILE && Leaf::of(self.batch.tree.root).is_none()
    }
}

#[inline(always)]
fn closest_hits_of_tile<S: Simd>(
    simd: S,
    tile: &mut Tile,
    visitor: &mut NearestOfTile,
    hits: &mut [Option<Hit>],
    counters: &mut TraversalCounters,
) -> bool {
    let is_bundle = tile.fill(simd, visitor.rays) && is_worth_it(tile, visitor.from.is_some());
    if is_bundle {
        packet::walk(simd, visitor.tree, tile, refinement(tile), visitor, counters);
        visitor.finish(simd, tile, hits);
    }
    is_bundle
}

#[inline(always)]
fn occlusion_of_tile<S: Simd>(
    simd: S,
    tile: &mut Tile,
    visitor: &mut AnyOfTile,
    occluded: &mut [bool],
    counters: &mut TraversalCounters,
) -> bool {
    let is_bundle = tile.fill(simd, visitor.rays) && is_worth_it(tile, visitor.from.is_some());
    if is_bundle {
        packet::walk(simd, visitor.tree, tile, Refine::Nodes, visitor, counters);
        for (i, occluded) in occluded.iter_mut().enumerate() {
            *occluded = visitor.is_occluded(i);
        }
    }
    is_bundle
}

/// Whether rays that fill a tile are better walked together.
fn is_worth_it(tile: &Tile, is_sorted: bool) -> bool {
    !is_sorted || tile.frustum.has_one_origin() || tile.count >= MANY || tile.frustum.spread() < SCATTERED
}

fn refinement(tile: &Tile) -> Refine {
    if tile.frustum.has_one_origin() && tile.frustum.spread() < NARROW {
        Refine::Leaves
    } else {
        Refine::Nodes
    }
}
