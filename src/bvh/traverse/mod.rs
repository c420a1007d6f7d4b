//! Tracing rays through the wide tree: one at a time, or in tiles of neighbours.
//!
//! A batch of rays is cut into tiles of up to 64 that follow each other. A tile whose rays run along one axis is walked at
//! once ([`packet`]); other ones are halved, and what is left of them are single rays ([`single`]).

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

/// Fewer rays than this are traced one by one.
const SMALLEST_TILE: usize = 8;
/// Tiles from one point that spread less than this over a unit of depth test boxes at leaves only.
const NARROW: f32 = 0.06;
/// Rays that spread more than this over a unit of depth have little in common.
const WIDE: f32 = 1.0;

/// Walks the judge's tree with its ray.
pub(super) fn walk<V: Visitor>(
    level: Level,
    judge: &Judge,
    visitor: &mut V,
    counters: &mut TraversalCounters,
) {
    dispatch!(level, simd => single::walk(simd, judge, visitor, counters));
}

/// Finds the first visible hits of a batch.
pub(super) fn closest_hits(
    level: Level,
    tree: &WideTree,
    rays: &[Ray],
    filter: BatchFilter,
    hits: &mut [Option<Hit>],
    counters: &mut TraversalCounters,
) {
    dispatch!(level, simd => {
        let mut tile = Tile::EMPTY;
        let mut first = 0;
        for (rays, hits) in rays.chunks(TILE).zip(hits.chunks_mut(TILE)) {
            let filter = |ray: usize, hit: &Hit| filter(first + ray, hit);
            closest_hits_of_tile(simd, tree, &mut tile, rays, &filter, hits, counters);
            first += rays.len();
        }
    });
}

#[inline(always)]
fn closest_hits_of_tile<S: Simd>(
    simd: S,
    tree: &WideTree,
    tile: &mut Tile,
    rays: &[Ray],
    filter: BatchFilter,
    hits: &mut [Option<Hit>],
    counters: &mut TraversalCounters,
) {
    let mut visitor = NearestOfTile { tree, rays, from: None, filter };
    if is_bundle(simd, tree, tile, rays) {
        packet::walk(simd, tree, tile, refinement(tile), &mut visitor, counters);
        visitor.finish(simd, tile, hits);
        return;
    }
    let bundles = Bundles::new(rays);
    let mut sorted = [None; TILE];
    for range in bundles.ranges() {
        let (rays, from) = (&bundles.rays[range.clone()], &bundles.from[range.clone()]);
        if is_bundle(simd, tree, tile, rays) {
            let mut visitor = NearestOfTile { tree, rays, from: Some(from), filter };
            packet::walk(simd, tree, tile, refinement(tile), &mut visitor, counters);
            visitor.finish(simd, tile, &mut sorted[..rays.len()]);
            for (&from, hit) in from.iter().zip(&sorted) {
                hits[usize::from(from)] = *hit;
            }
            continue;
        }
        for (ray, &from) in rays.iter().zip(from) {
            let from = usize::from(from);
            let judge = Judge { tree, ray };
            let filter = |hit: &Hit| filter(from, hit);
            let mut nearest = Nearest::<true>::new(ray, None, &filter);
            single::walk(simd, &judge, &mut nearest, counters);
            hits[from] = nearest.finish(&judge);
        }
    }
}

/// Finds which rays of a batch meet anything.
pub(super) fn occluded_rays(
    level: Level,
    tree: &WideTree,
    rays: &[Ray],
    filter: BatchFilter,
    occluded: &mut [bool],
    counters: &mut TraversalCounters,
) {
    dispatch!(level, simd => {
        let mut tile = Tile::EMPTY;
        let mut first = 0;
        for (rays, occluded) in rays.chunks(TILE).zip(occluded.chunks_mut(TILE)) {
            let filter = |ray: usize, hit: &Hit| filter(first + ray, hit);
            occluded_rays_of_tile(simd, tree, &mut tile, rays, &filter, occluded, counters);
            first += rays.len();
        }
    });
}

#[inline(always)]
fn occluded_rays_of_tile<S: Simd>(
    simd: S,
    tree: &WideTree,
    tile: &mut Tile,
    rays: &[Ray],
    filter: BatchFilter,
    occluded: &mut [bool],
    counters: &mut TraversalCounters,
) {
    if is_bundle(simd, tree, tile, rays) {
        let mut visitor = AnyOfTile::new(tree, rays, filter);
        packet::walk(simd, tree, tile, refinement(tile), &mut visitor, counters);
        for (i, occluded) in occluded.iter_mut().enumerate() {
            *occluded = visitor.is_occluded(i);
        }
        return;
    }
    for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
        let filter = |hit: &Hit| filter(i, hit);
        let mut any = Any::new(ray, &filter);
        single::walk(simd, &Judge { tree, ray }, &mut any, counters);
        *occluded = any.found;
    }
}

/// Makes a tile of the rays if that is worth it.
#[inline(always)]
fn is_bundle<S: Simd>(simd: S, tree: &WideTree, tile: &mut Tile, rays: &[Ray]) -> bool {
    rays.len() >= SMALLEST_TILE
        && Leaf::of(tree.root).is_none()
        && tile.fill(simd, rays)
        && tile.frustum.spread() < WIDE
}

fn refinement(tile: &Tile) -> Refine {
    if tile.has_one_origin() && tile.frustum.spread() < NARROW { Refine::Leaves } else { Refine::Nodes }
}
