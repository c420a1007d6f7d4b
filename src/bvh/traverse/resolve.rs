//! The exact hits of a tile, once their triangles are settled: the definition of a hit, many rays at once.
//!
//! [`crate::geometry::ShearedRay::meet_surely`] in `f64` lanes, the same operations in the same order, for rays whose own depth
//! axis is the tile's. Both give the same bits.

use fearless_simd::{Simd, f32x16, f64x8, prelude::*};

use super::tile::{LANES, Tile};
use crate::bvh::Hit;
use crate::bvh::wide::WideTree;
use crate::geometry::Facing;

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

/// Eight rays as the definition uses them.
struct Lines<S: Simd> {
    origin: [f64x8<S>; 3],
    direction_z: f64x8<S>,
    shear: [f64x8<S>; 2],
}

/// Where eight rays meet their triangles.
struct Met<S: Simd> {
    t: f64x8<S>,
    u: f64x8<S>,
    v: f64x8<S>,
    front: u32,
}

impl Resolved {
    /// Computes the hits of one vector of rays with their triangles; lanes without a triangle hold anything.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, tree: &WideTree, tile: &Tile, vector: usize) -> Self {
        // Gather the triangles.
        let mut corners: Corners = [[[1.0; LANES]; 3]; 3];
        let mut primitive = [0; LANES];
        let mut hit = 0;
        for i in 0..LANES {
            let Some(place) = tile.place(vector, i) else { continue };
            let triangles = tree.triangles(place.leaf);
            let triangle = triangles.corners_in_order(place.lane as usize, tile.axes);
            for (rows, [x, y, z]) in corners.iter_mut().zip(triangle) {
                (rows[0][i], rows[1][i], rows[2][i]) = (x, y, z);
            }
            primitive[i] = triangles.tag(place.lane as usize).primitive();
            hit |= 1 << i;
        }

        // Meet them.
        let mut resolved =
            Self { primitive, t: [0.0; LANES], u: [0.0; LANES], v: [0.0; LANES], front: 0, hit };
        if hit != 0 {
            let low = Lines::new(simd, tile, vector, 0).meet(simd, &corners, 0);
            let high = Lines::new(simd, tile, vector, 1).meet(simd, &corners, 1);
            low.t.narrow(high.t).store_array(&mut resolved.t);
            low.u.narrow(high.u).store_array(&mut resolved.u);
            low.v.narrow(high.v).store_array(&mut resolved.v);
            resolved.front = low.front | high.front << (LANES / 2);
        }
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

    /// Lanes that have a triangle.
    pub(super) fn lanes(&self) -> u32 {
        self.hit
    }
}

impl<S: Simd> Lines<S> {
    #[inline(always)]
    fn new(simd: S, tile: &Tile, vector: usize, half: usize) -> Self {
        let [kx, ky, kz] = tile.axes;
        let direction_z = widen(simd, &tile.direction[kz][vector], half);
        Self {
            origin: [
                widen(simd, &tile.origin[kx][vector], half),
                widen(simd, &tile.origin[ky][vector], half),
                widen(simd, &tile.origin[kz][vector], half),
            ],
            direction_z,
            shear: [
                widen(simd, &tile.direction[kx][vector], half) / direction_z,
                widen(simd, &tile.direction[ky][vector], half) / direction_z,
            ],
        }
    }

    #[inline(always)]
    fn meet(&self, simd: S, corners: &Corners, half: usize) -> Met<S> {
        let a = self.sheared(simd, &corners[0], half);
        let b = self.sheared(simd, &corners[1], half);
        let c = self.sheared(simd, &corners[2], half);
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let det = u + v + w;
        Met {
            t: (u * a[2] + v * b[2] + w * c[2]) / (det * self.direction_z),
            u: v / det,
            v: w / det,
            front: det.simd_gt(0.0).to_bitmask() as u32,
        }
    }

    #[inline(always)]
    fn sheared(&self, simd: S, corner: &[[f32; LANES]; 3], half: usize) -> [f64x8<S>; 3] {
        let x = widen(simd, &corner[0], half) - self.origin[0];
        let y = widen(simd, &corner[1], half) - self.origin[1];
        let z = widen(simd, &corner[2], half) - self.origin[2];
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

#[inline(always)]
fn widen<S: Simd>(simd: S, row: &[f32; LANES], half: usize) -> f64x8<S> {
    let (low, high) = f32x16::load_array_ref(simd, row).widen();
    if half == 0 { low } else { high }
}
