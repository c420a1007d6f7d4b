//! The two queries of a tile: first hits, and whether there is any.

use fearless_simd::{Simd, f32x16, prelude::*, u32x16};

use super::edges::Distances;
use super::packet::{Sighting, TileVisitor, mask};
use super::resolve::Resolved;
use super::tile::{LANES, Tile, VECTORS};
use crate::bvh::query::{BatchFilter, Judge, Place};
use crate::bvh::wide::{Tag, WideTree};
use crate::bvh::{Hit, PrimitiveFlags};
use crate::geometry::{Facing, Ray};

/// Finds the first visible hit of each ray, as [`crate::bvh::Bvh::closest_hit`] does.
pub(super) struct NearestOfTile<'a> {
    /// The tree.
    pub(super) tree: &'a WideTree,
    /// The rays.
    pub(super) rays: &'a [Ray],
    /// The subscripts of the rays in their batch, if they are not their places here.
    pub(super) from: Option<&'a [u8]>,
    /// Asked about filtered triangles, with the subscript of the ray.
    pub(super) filter: BatchFilter<'a>,
}

/// Finds whether each ray meets anything, as [`crate::bvh::Bvh::occluded`] does.
pub(super) struct AnyOfTile<'a> {
    /// The tree.
    pub(super) tree: &'a WideTree,
    /// The rays.
    pub(super) rays: &'a [Ray],
    /// The subscripts of the rays in their batch, if they are not their places here.
    pub(super) from: Option<&'a [u8]>,
    /// Asked about filtered triangles, with the subscript of the ray.
    pub(super) filter: BatchFilter<'a>,
    /// Rays that meet something, by vector.
    found: [u32; VECTORS],
}

impl<'a> NearestOfTile<'a> {
    /// Writes the first hits of all rays.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, simd: S, tile: &Tile, hits: &mut [Option<Hit>]) {
        for (v, hits) in hits.chunks_mut(LANES).enumerate() {
            let resolved = Resolved::new(simd, self.tree, tile, v);
            for (i, hit) in hits.iter_mut().enumerate() {
                *hit = resolved.hit(i);
            }
        }
    }

    #[inline(always)]
    fn judge(&self, ray: usize) -> Judge<'a> {
        Judge { tree: self.tree, ray: &self.rays[ray] }
    }

    /// Decides between a ray's first hit so far and another one by the definition; whether the other one won.
    #[inline(never)]
    fn compare(&self, tile: &mut Tile, ray: usize, place: Place, tag: Tag) -> bool {
        let Some(hit) = self.judge(ray).meet(place) else { return false };
        let (v, i) = (ray / LANES, ray % LANES);
        let best = tile.place(v, i).map(|place| self.judge(ray).meet_surely(place));
        if best.is_some_and(|best| best.order() <= hit.order()) {
            return false;
        }
        let flags = tag.flags();
        if flags.has(PrimitiveFlags::SINGLE_SIDED) && hit.facing == Facing::Back {
            return false;
        }
        let subscript = self.from.map_or(ray, |from| usize::from(from[ray]));
        if flags.has(PrimitiveFlags::FILTERED) && !(self.filter)(subscript, &hit) {
            return false;
        }
        (tile.leaf[v][i], tile.lane[v][i]) = (place.leaf.word(), place.lane);
        (tile.near[v][i], tile.far[v][i]) = (hit.t, hit.t);
        true
    }
}

impl TileVisitor for NearestOfTile<'_> {
    #[inline(always)]
    fn sight<S: Simd>(&mut self, simd: S, tile: &mut Tile, sighting: &Sighting<S>) -> bool {
        let Sighting { vector: v, place, tag, .. } = *sighting;
        let flags = tag.flags();
        let Distances { near, far } = &sighting.distances;
        let (near, far) = (*near, *far);
        let best_near = f32x16::load_array_ref(simd, &tile.near[v]);
        let best_far = f32x16::load_array_ref(simd, &tile.far[v]);
        let lower = f32x16::load_array_ref(simd, &tile.lower[v]);

        // Rays that surely see something nearer, begin behind it, or see through the back.
        let mut settled = (near.simd_gt(best_far) | far.simd_lt(lower)).to_bitmask() as u32;
        if flags.has(PrimitiveFlags::SINGLE_SIDED) {
            settled |= sighting.back;
        }
        let open = sighting.possible & !(settled & sighting.sure);
        if open == 0 {
            return false;
        }

        // Rays for which it surely is the first hit so far.
        let in_front = (near.simd_gt(lower) & far.simd_lt(best_near)).to_bitmask() as u32;
        let mut first = open & sighting.sure & in_front;
        if flags.has(PrimitiveFlags::FILTERED) {
            first = 0;
        }
        if first != 0 {
            let lanes = mask(simd, first);
            lanes.select(near, best_near).store_array(&mut tile.near[v]);
            lanes.select(far, best_far).store_array(&mut tile.far[v]);
            let leaves = u32x16::load_array_ref(simd, &tile.leaf[v]);
            let leaf = u32x16::splat(simd, place.leaf.word());
            lanes.select(leaf, leaves).store_array(&mut tile.leaf[v]);
            let numbers = u32x16::load_array_ref(simd, &tile.lane[v]);
            let number = u32x16::splat(simd, place.lane);
            lanes.select(number, numbers).store_array(&mut tile.lane[v]);
        }
        let mut changed = first != 0;

        // Too close to call
        let mut rest = open & !first;
        while rest != 0 {
            let ray = v * LANES + (rest.trailing_zeros() as usize & (LANES - 1));
            rest &= rest - 1;
            changed |= self.compare(tile, ray, place, tag);
        }
        changed
    }
}

impl<'a> AnyOfTile<'a> {
    /// Nothing is found yet.
    #[inline(always)]
    pub(super) fn new(
        tree: &'a WideTree,
        rays: &'a [Ray],
        from: Option<&'a [u8]>,
        filter: BatchFilter<'a>,
    ) -> Self {
        Self { tree, rays, from, filter, found: [0; VECTORS] }
    }

    /// Whether a ray meets something.
    #[inline(always)]
    pub(super) fn is_occluded(&self, ray: usize) -> bool {
        self.found[ray / LANES] >> (ray % LANES) & 1 != 0
    }

    /// Decides by the definition.
    #[inline(never)]
    fn decide(&self, ray: usize, place: Place, tag: Tag) -> bool {
        let judge = Judge { tree: self.tree, ray: &self.rays[ray] };
        let subscript = self.from.map_or(ray, |from| usize::from(from[ray]));
        let counts = |hit: &Hit| !tag.flags().has(PrimitiveFlags::FILTERED) || (self.filter)(subscript, hit);
        judge.meet(place).is_some_and(|hit| counts(&hit))
    }
}

impl TileVisitor for AnyOfTile<'_> {
    #[inline(always)]
    fn sight<S: Simd>(&mut self, simd: S, tile: &mut Tile, sighting: &Sighting<S>) -> bool {
        let Sighting { vector: v, place, tag, .. } = *sighting;
        let (near, far) = (sighting.distances.near, sighting.distances.far);
        let lower = f32x16::load_array_ref(simd, &tile.lower[v]);
        let upper = f32x16::load_array_ref(simd, &tile.far[v]);

        // Rays beyond whose limits it surely is, and between whose limits it surely is.
        let beyond = (near.simd_gt(upper) | far.simd_lt(lower)).to_bitmask() as u32;
        let between = (near.simd_gt(lower) & far.simd_lt(upper)).to_bitmask() as u32;
        let open = sighting.possible & !self.found[v] & !(beyond & sighting.sure);
        let mut found = open & sighting.sure & between;
        if tag.flags().has(PrimitiveFlags::FILTERED) {
            found = 0;
        }

        // Too close to call
        let mut rest = open & !found;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize & (LANES - 1);
            rest &= rest - 1;
            if self.decide(v * LANES + lane, place, tag) {
                found |= 1 << lane;
            }
        }
        if found == 0 {
            return false;
        }
        // Rays that are done look no farther.
        self.found[v] |= found;
        let never = f32x16::splat(simd, f32::NEG_INFINITY);
        mask(simd, found).select(never, upper).store_array(&mut tile.far[v]);
        true
    }
}
