//! The exact hits of a tile, once their triangles are settled: the definition of a hit, many rays at once.
//!
//! [`crate::geometry::ShearedRay::meet_surely`] in lanes, the same operations in the same order. Both give the same bits.

use fearless_simd::{Simd, f32x16, f64x8, mask64x8, prelude::*, u32x16};

use super::tile::{LANES, Tile};
use crate::bvh::Hit;
use crate::bvh::wide::WideTree;
use crate::geometry::Facing;

/// A triangle that fewer rays of a vector meet than this is met together with others, a triangle a lane.
const FEW: u32 = 4;

/// Three corners by axis, one number a ray.
type Corners = [[[f32; LANES]; 3]; 3];

/// Hits of a vector of rays.
pub(super) struct Resolved {
    primitive: [u32; LANES],
    t: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
    /// Lanes that meet the front.
    front: u32,
    /// Lanes that have a triangle.
    hit: u32,
}

/// A vector of rays as the definition uses them.
#[derive(Clone, Copy)]
struct Lines<S: Simd> {
    origin: [f32x16<S>; 3],
    shear: [f32x16<S>; 2],
}

/// The edge functions of eight rays and their triangles, and the weighted depth.
#[derive(Clone, Copy)]
struct Met<S: Simd> {
    depth: f64x8<S>,
    v: f64x8<S>,
    w: f64x8<S>,
    det: f64x8<S>,
}

impl Resolved {
    /// Computes the hits of one vector of rays with their triangles; lanes without a triangle hold anything.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, tree: &WideTree, tile: &Tile, vector: usize) -> Self {
        let leaves = u32x16::load_array_ref(simd, &tile.leaf[vector]);
        let lanes = u32x16::load_array_ref(simd, &tile.lane[vector]);
        let hit = leaves.simd_ne(0).to_bitmask() as u32;
        let mut resolved =
            Self { primitive: [0; LANES], t: [0.0; LANES], u: [0.0; LANES], v: [0.0; LANES], front: 0, hit };
        if hit == 0 {
            return resolved;
        }
        let primitive = &mut resolved.primitive;
        let mut met = [Met::none(simd); 2];
        let lines = Lines::new(simd, tile, vector);

        // Triangles that many rays meet
        let mut rest = hit;
        while rest != 0 {
            let first = rest.trailing_zeros() as usize & (LANES - 1);
            let Some(place) = tile.place(vector, first) else { break };
            let is_same = leaves.simd_eq(place.leaf.word()) & lanes.simd_eq(place.lane);
            let same = is_same.to_bitmask() as u32;
            if same.count_ones() < FEW {
                break;
            }
            rest &= !same;
            let triangles = tree.triangles(place.leaf);
            let id = u32x16::splat(simd, triangles.tag(place.lane as usize).primitive());
            is_same.select(id, u32x16::load_array_ref(simd, primitive)).store_array(primitive);
            let [a, b, c] = triangles.corners_in_order(place.lane as usize, tile.axes);
            let corners = [everywhere(simd, a), everywhere(simd, b), everywhere(simd, c)];
            met = choose(simd, same, lines.meet(corners), met);
        }

        // The others, a triangle a lane
        if rest != 0 {
            let mut corners: Corners = [[[1.0; LANES]; 3]; 3];
            let others = rest;
            while rest != 0 {
                let i = rest.trailing_zeros() as usize & (LANES - 1);
                rest &= rest - 1;
                let Some(place) = tile.place(vector, i) else { break };
                let triangles = tree.triangles(place.leaf);
                let triangle = triangles.corners_in_order(place.lane as usize, tile.axes);
                for (rows, [x, y, z]) in corners.iter_mut().zip(triangle) {
                    (rows[0][i], rows[1][i], rows[2][i]) = (x, y, z);
                }
                primitive[i] = triangles.tag(place.lane as usize).primitive();
            }
            let corners = [rows(simd, &corners[0]), rows(simd, &corners[1]), rows(simd, &corners[2])];
            met = choose(simd, others, lines.meet(corners), met);
        }

        let [low, high] = &met;
        let direction_z = f32x16::load_array_ref(simd, &tile.direction[tile.axes[2]][vector]);
        let (z_low, z_high) = direction_z.widen();
        low.t(z_low).narrow(high.t(z_high)).store_array(&mut resolved.t);
        (low.v / low.det).narrow(high.v / high.det).store_array(&mut resolved.u);
        (low.w / low.det).narrow(high.w / high.det).store_array(&mut resolved.v);
        resolved.front = low.front() | high.front() << (LANES / 2);
        resolved
    }

    /// The hit of a lane, if it has a triangle.
    #[inline(always)]
    pub(super) fn hit(&self, lane: usize) -> Option<Hit> {
        let facing = if self.front >> lane & 1 != 0 { Facing::Front } else { Facing::Back };
        (self.hit >> lane & 1 != 0).then_some(Hit {
            t: self.t[lane],
            primitive: self.primitive[lane],
            u: self.u[lane],
            v: self.v[lane],
            facing,
        })
    }
}

impl<S: Simd> Lines<S> {
    #[inline(always)]
    fn new(simd: S, tile: &Tile, vector: usize) -> Self {
        let [kx, ky, kz] = tile.axes;
        Self {
            origin: [
                f32x16::load_array_ref(simd, &tile.origin[kx][vector]),
                f32x16::load_array_ref(simd, &tile.origin[ky][vector]),
                f32x16::load_array_ref(simd, &tile.origin[kz][vector]),
            ],
            shear: [
                f32x16::load_array_ref(simd, &tile.shear[0][vector]),
                f32x16::load_array_ref(simd, &tile.shear[1][vector]),
            ],
        }
    }

    #[inline(always)]
    fn meet(&self, [a, b, c]: [[f32x16<S>; 3]; 3]) -> [Met<S>; 2] {
        let (a_low, a_high) = self.sheared(a);
        let (b_low, b_high) = self.sheared(b);
        let (c_low, c_high) = self.sheared(c);
        [Met::new([a_low, b_low, c_low]), Met::new([a_high, b_high, c_high])]
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

impl<S: Simd> Met<S> {
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

    /// These in the chosen lanes, others elsewhere.
    #[inline(always)]
    fn or(self, chosen: mask64x8<S>, others: Self) -> Self {
        Self {
            depth: chosen.select(self.depth, others.depth),
            v: chosen.select(self.v, others.v),
            w: chosen.select(self.w, others.w),
            det: chosen.select(self.det, others.det),
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

/// What was met by some lanes of a vector of rays, and by the others.
#[inline(always)]
fn choose<S: Simd>(simd: S, lanes: u32, chosen: [Met<S>; 2], others: [Met<S>; 2]) -> [Met<S>; 2] {
    let low = mask64x8::from_bitmask(simd, u64::from(lanes & 0xFF));
    let high = mask64x8::from_bitmask(simd, u64::from(lanes >> 8 & 0xFF));
    [chosen[0].or(low, others[0]), chosen[1].or(high, others[1])]
}

/// A corner that all rays share.
#[inline(always)]
fn everywhere<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [f32x16<S>; 3] {
    [f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)]
}

/// A corner of each ray's triangle.
#[inline(always)]
fn rows<S: Simd>(simd: S, corner: &[[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    [
        f32x16::load_array_ref(simd, &corner[0]),
        f32x16::load_array_ref(simd, &corner[1]),
        f32x16::load_array_ref(simd, &corner[2]),
    ]
}
