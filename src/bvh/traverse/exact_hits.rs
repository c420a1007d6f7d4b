//! Exact hits of a packet's rays with their closest triangles, or with one, by the definition of a hit in lanes.
//!
//! Performs the operations of [`crate::geometry::ShearedRay::intersect_known`] in the same order, so both give the same bits.

use fearless_simd::{Simd, f32x16, f64x8, mask64x8, prelude::*, u32x16};

use super::packet::{LANES, Packet};
use super::visitor::TriangleSlot;
use crate::bvh::hit::Hit;
use crate::bvh::wide_tree::WideTree;
use crate::geometry::Facing;

/// Least number of rays of a vector that are intersected with one triangle at once. The first triangle that fewer rays share ends that: all rays
/// that remain are intersected one per lane.
const MIN_SHARED: u32 = 4;

/// Three corners by axis, one number per ray.
type Corners = [[[f32; LANES]; 3]; 3];

/// Hits of a vector of rays.
pub(super) struct ExactHits {
    triangle: [u32; LANES],
    t: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
    /// Lanes that hit the front.
    front: u32,
    /// Lanes that have a hit; of one triangle alone, all.
    hit: u32,
}

/// Vector of rays, sheared as in the definition of a hit.
#[derive(Clone, Copy)]
struct ShearedRays<S: Simd> {
    origin: [f32x16<S>; 3],
    shear: [f32x16<S>; 2],
}

/// Edge functions of eight pairs of ray and triangle, their sum, and the weighted depth.
#[derive(Clone, Copy)]
struct EdgeSums<S: Simd> {
    depth: f64x8<S>,
    v: f64x8<S>,
    w: f64x8<S>,
    det: f64x8<S>,
}

impl ExactHits {
    /// Computes the hits of one vector of rays; lanes without a triangle are unspecified.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, tree: &WideTree, packet: &Packet, vector: usize) -> Self {
        let leaves = u32x16::load_array_ref(simd, &packet.leaf[vector]);
        let lanes = u32x16::load_array_ref(simd, &packet.lane[vector]);
        let hit = leaves.simd_ne(0).to_bitmask() as u32;
        let mut hits = Self::none(hit);
        if hit == 0 {
            return hits;
        }
        let ids = &mut hits.triangle;
        let mut sums = [EdgeSums::none(simd); 2];
        let rays = ShearedRays::new(simd, packet, vector);

        // Triangles that many rays share.
        let mut rest = hit;
        while rest != 0 {
            let first = rest.trailing_zeros() as usize & (LANES - 1);
            let Some(slot) = packet.slot(vector, first) else { break };
            let is_same = leaves.simd_eq(slot.leaf.word()) & lanes.simd_eq(slot.lane);
            let same = is_same.to_bitmask() as u32;
            if same.count_ones() < MIN_SHARED {
                break;
            }
            rest &= !same;
            let triangles = tree.triangles(slot.leaf);
            let id = u32x16::splat(simd, triangles.tag(slot.lane as usize).triangle());
            is_same.select(id, u32x16::load_array_ref(simd, ids)).store_array(ids);
            sums = select(simd, same, rays.intersect(shared_corners(simd, tree, packet, slot)), sums);
        }

        // The others, one triangle per lane.
        if rest != 0 {
            let corners = gather_corners(tree, packet, vector, rest, ids);
            let corners = [rows(simd, &corners[0]), rows(simd, &corners[1]), rows(simd, &corners[2])];
            sums = select(simd, rest, rays.intersect(corners), sums);
        }

        hits.divide(simd, packet, vector, &sums);
        hits
    }

    /// Computes the hits of one vector of rays with one triangle; those of rays beside it are unspecified.
    #[inline(always)]
    pub(super) fn with_triangle<S: Simd>(
        simd: S,
        tree: &WideTree,
        packet: &Packet,
        vector: usize,
        slot: TriangleSlot,
    ) -> Self {
        let mut hits = Self::none(u32::MAX);
        hits.triangle = [tree.triangles(slot.leaf).tag(slot.lane as usize).triangle(); LANES];
        let rays = ShearedRays::new(simd, packet, vector);
        hits.divide(simd, packet, vector, &rays.intersect(shared_corners(simd, tree, packet, slot)));
        hits
    }

    /// Lanes whose hits are not computed yet.
    #[inline(always)]
    fn none(hit: u32) -> Self {
        Self { triangle: [0; LANES], t: [0.0; LANES], u: [0.0; LANES], v: [0.0; LANES], front: 0, hit }
    }

    /// Sets all but the triangles.
    #[inline(always)]
    fn divide<S: Simd>(&mut self, simd: S, packet: &Packet, vector: usize, [low, high]: &[EdgeSums<S>; 2]) {
        let direction_z = f32x16::load_array_ref(simd, &packet.direction[packet.axes[2]][vector]);
        let (z_low, z_high) = direction_z.widen();
        low.t(z_low).narrow(high.t(z_high)).store_array(&mut self.t);
        (low.v / low.det).narrow(high.v / high.det).store_array(&mut self.u);
        (low.w / low.det).narrow(high.w / high.det).store_array(&mut self.v);
        self.front = low.front() | high.front() << (LANES / 2);
    }

    /// Hit of one lane.
    #[inline(always)]
    pub(super) fn hit(&self, lane: usize) -> Option<Hit> {
        let facing = if self.front >> lane & 1 != 0 { Facing::Front } else { Facing::Back };
        (self.hit >> lane & 1 != 0).then_some(Hit {
            t: self.t[lane],
            triangle: self.triangle[lane],
            u: self.u[lane],
            v: self.v[lane],
            facing,
        })
    }
}

/// Corners of a triangle, the same for all rays.
#[inline(always)]
fn shared_corners<S: Simd>(
    simd: S,
    tree: &WideTree,
    packet: &Packet,
    slot: TriangleSlot,
) -> [[f32x16<S>; 3]; 3] {
    let [a, b, c] = tree.triangles(slot.leaf).corners_in_order(slot.lane as usize, packet.axes);
    [splat(simd, a), splat(simd, b), splat(simd, c)]
}

/// Corners of the closest triangles of `lanes`; writes their indices to `ids`.
#[inline(always)]
fn gather_corners(
    tree: &WideTree,
    packet: &Packet,
    vector: usize,
    lanes: u32,
    ids: &mut [u32; LANES],
) -> Corners {
    let mut corners: Corners = [[[1.0; LANES]; 3]; 3];
    let mut rest = lanes;
    while rest != 0 {
        let i = rest.trailing_zeros() as usize & (LANES - 1);
        rest &= rest - 1;
        let Some(slot) = packet.slot(vector, i) else { break };
        let triangles = tree.triangles(slot.leaf);
        let triangle = triangles.corners_in_order(slot.lane as usize, packet.axes);
        for (rows, [x, y, z]) in corners.iter_mut().zip(triangle) {
            (rows[0][i], rows[1][i], rows[2][i]) = (x, y, z);
        }
        ids[i] = triangles.tag(slot.lane as usize).triangle();
    }
    corners
}

impl<S: Simd> ShearedRays<S> {
    #[inline(always)]
    fn new(simd: S, packet: &Packet, vector: usize) -> Self {
        let [kx, ky, kz] = packet.axes;
        Self {
            origin: [
                f32x16::load_array_ref(simd, &packet.origin[kx][vector]),
                f32x16::load_array_ref(simd, &packet.origin[ky][vector]),
                f32x16::load_array_ref(simd, &packet.origin[kz][vector]),
            ],
            shear: [
                f32x16::load_array_ref(simd, &packet.shear[0][vector]),
                f32x16::load_array_ref(simd, &packet.shear[1][vector]),
            ],
        }
    }

    #[inline(always)]
    fn intersect(&self, [a, b, c]: [[f32x16<S>; 3]; 3]) -> [EdgeSums<S>; 2] {
        let (a_low, a_high) = self.sheared(a);
        let (b_low, b_high) = self.sheared(b);
        let (c_low, c_high) = self.sheared(c);
        [EdgeSums::new([a_low, b_low, c_low]), EdgeSums::new([a_high, b_high, c_high])]
    }

    #[inline(always)]
    fn sheared(&self, corner: [f32x16<S>; 3]) -> ([f64x8<S>; 3], [f64x8<S>; 3]) {
        let x = corner[0] - self.origin[0];
        let y = corner[1] - self.origin[1];
        let z = corner[2] - self.origin[2];
        let (x_low, x_high) = (x - self.shear[0] * z).widen();
        let (y_low, y_high) = (y - self.shear[1] * z).widen();
        let (z_low, z_high) = z.widen();
        ([x_low, y_low, z_low], [x_high, y_high, z_high])
    }
}

impl<S: Simd> EdgeSums<S> {
    #[inline(always)]
    fn new([a, b, c]: [[f64x8<S>; 3]; 3]) -> Self {
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        Self { depth: u * a[2] + v * b[2] + w * c[2], v, w, det: u + v + w }
    }

    #[inline(always)]
    fn none(simd: S) -> Self {
        let one = f64x8::splat(simd, 1.0);
        Self { depth: one, v: one, w: one, det: one }
    }

    /// These values in the masked lanes, others elsewhere.
    #[inline(always)]
    fn select(self, mask: mask64x8<S>, others: Self) -> Self {
        Self {
            depth: mask.select(self.depth, others.depth),
            v: mask.select(self.v, others.v),
            w: mask.select(self.w, others.w),
            det: mask.select(self.det, others.det),
        }
    }

    #[inline(always)]
    fn t(&self, direction_z: f64x8<S>) -> f64x8<S> {
        self.depth / (self.det * direction_z)
    }

    #[inline(always)]
    fn front(&self) -> u32 {
        self.det.simd_gt(0.0).to_bitmask() as u32
    }
}

/// The values of `chosen` in `lanes`, others elsewhere.
#[inline(always)]
fn select<S: Simd>(
    simd: S,
    lanes: u32,
    chosen: [EdgeSums<S>; 2],
    others: [EdgeSums<S>; 2],
) -> [EdgeSums<S>; 2] {
    let low = mask64x8::from_bitmask(simd, u64::from(lanes & 0xFF));
    let high = mask64x8::from_bitmask(simd, u64::from(lanes >> 8 & 0xFF));
    [chosen[0].select(low, others[0]), chosen[1].select(high, others[1])]
}

/// A corner that all rays share.
#[inline(always)]
fn splat<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [f32x16<S>; 3] {
    [f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)]
}

/// One corner of each ray's triangle.
#[inline(always)]
fn rows<S: Simd>(simd: S, corner: &[[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    [
        f32x16::load_array_ref(simd, &corner[0]),
        f32x16::load_array_ref(simd, &corner[1]),
        f32x16::load_array_ref(simd, &corner[2]),
    ]
}
