//! The exact hits of a tile, once their triangles are settled: the definition of a hit, many rays at once.
//!
//! [`crate::geometry::ShearedRay::meet`] in `f64` lanes, the same operations in the same order, for rays whose own depth axis is the
//! tile's and whose triangles they surely meet. Both give the same bits.

use fearless_simd::{Simd, f32x16, f64x8, prelude::*};

use super::tile::{LANES, Tile};
use crate::bvh::Hit;
use crate::bvh::wide::WideTree;
use crate::geometry::Facing;

/// Lanes of a vector of `f64`.
const HALF: usize = LANES / 2;

/// Three corners by axis, one number a ray.
type Corners = [[[f32; LANES]; 3]; 3];

/// Hits of a vector of rays.
pub(super) struct Resolved {
    t: [f64; LANES],
    u: [f64; LANES],
    v: [f64; LANES],
    det: [f64; LANES],
    primitive: [u32; LANES],
}

impl Resolved {
    /// Computes the hits of one vector of rays with their triangles; lanes without a triangle hold anything.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, tree: &WideTree, tile: &Tile, vector: usize) -> Self {
        let mut corners: Corners = [[[1.0; LANES]; 3]; 3];
        let mut primitive = [0; LANES];
        for (i, primitive) in primitive.iter_mut().enumerate() {
            let Some(place) = tile.place(vector, i) else { continue };
            let triangles = tree.triangles(place.leaf);
            *primitive = triangles.tag(place.lane as usize).primitive();
            let triangle = triangles.corners(place.lane as usize);
            for (rows, corner) in corners.iter_mut().zip(&triangle) {
                for (row, axis) in rows.iter_mut().zip(tile.axes) {
                    row[i] = corner[axis];
                }
            }
        }
        let [t, u, v, det] = [[0.0; LANES]; 4];
        let mut resolved = Self { t, u, v, det, primitive };
        for half in 0..2 {
            resolved.compute(simd, tile, vector, half, &corners);
        }
        resolved
    }

    /// The hit of a lane that has a triangle.
    #[inline(always)]
    pub(super) fn hit(&self, lane: usize) -> Hit {
        Hit {
            t: self.t[lane] as f32,
            primitive: self.primitive[lane],
            u: self.u[lane] as f32,
            v: self.v[lane] as f32,
            facing: if self.det[lane] > 0.0 { Facing::Front } else { Facing::Back },
        }
    }

    #[inline(always)]
    fn compute<S: Simd>(&mut self, simd: S, tile: &Tile, vector: usize, half: usize, corners: &Corners) {
        let [kx, ky, kz] = tile.axes;
        let origin = [
            widen(simd, &tile.origin[kx][vector], half),
            widen(simd, &tile.origin[ky][vector], half),
            widen(simd, &tile.origin[kz][vector], half),
        ];
        let direction_z = widen(simd, &tile.direction[kz][vector], half);
        let shear = [
            widen(simd, &tile.direction[kx][vector], half) / direction_z,
            widen(simd, &tile.direction[ky][vector], half) / direction_z,
        ];
        let a = sheared(simd, &corners[0], half, origin, shear);
        let b = sheared(simd, &corners[1], half, origin, shear);
        let c = sheared(simd, &corners[2], half, origin, shear);
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let det = u + v + w;
        let t = (u * a[2] + v * b[2] + w * c[2]) / (det * direction_z);
        let lanes = half * HALF..(half + 1) * HALF;
        t.store_slice(&mut self.t[lanes.clone()]);
        (v / det).store_slice(&mut self.u[lanes.clone()]);
        (w / det).store_slice(&mut self.v[lanes.clone()]);
        det.store_slice(&mut self.det[lanes]);
    }
}

#[inline(always)]
fn widen<S: Simd>(simd: S, row: &[f32; LANES], half: usize) -> f64x8<S> {
    let (low, high) = f32x16::load_array_ref(simd, row).widen();
    if half == 0 { low } else { high }
}

#[inline(always)]
fn sheared<S: Simd>(
    simd: S,
    corner: &[[f32; LANES]; 3],
    half: usize,
    origin: [f64x8<S>; 3],
    shear: [f64x8<S>; 2],
) -> [f64x8<S>; 3] {
    let x = widen(simd, &corner[0], half) - origin[0];
    let y = widen(simd, &corner[1], half) - origin[1];
    let z = widen(simd, &corner[2], half) - origin[2];
    [x - shear[0] * z, y - shear[1] * z, z]
}
