//! Up to 64 rays side by side, number by number, with what the kernels need of each.

use fearless_simd::{Simd, f32x16, prelude::*};

use super::frustum::Frustum;
use crate::bvh::query::{Place, positive_lower};
use crate::bvh::wide::Leaf;
use crate::geometry::{Ray, dominant_axes};

/// Lanes of a vector.
pub(super) const LANES: usize = 16;
/// Vectors of a tile.
pub(super) const VECTORS: usize = 4;
/// Rays of a tile.
pub(super) const TILE: usize = LANES * VECTORS;

/// Smallest direction component, in units of the one along the depth.
const SMALLEST_COMPONENT: f32 = 1.0 / (1 << 30) as f32;
/// Origin coordinates are below this.
const LARGEST_ORIGIN: f32 = 1.0e30;
/// The direction component along the depth lies between these.
const ORDINARY: std::ops::Range<f32> = 1.0e-10..1.0e10;

/// One number a ray.
pub(super) type Row = [[f32; LANES]; VECTORS];

/// Rays of one depth axis, which run the same way along it.
#[repr(align(64))]
pub(super) struct Tile {
    /// Origins, by axis.
    pub(super) origin: [Row; 3],
    /// Directions, by axis.
    pub(super) direction: [Row; 3],
    /// One over the direction's components, none of which counts as zero.
    pub(super) reciprocal: [Row; 3],
    /// The two lateral components over the one along the depth.
    pub(super) shear: [Row; 2],
    /// Hits at or before this do not count.
    pub(super) lower: Row,
    /// The first hit so far is not nearer than this; before there is one, the ray's end. Spare lanes have −∞.
    pub(super) near: Row,
    /// The first hit so far is not farther than this.
    pub(super) far: Row,
    /// The triangles of the first hits so far: their leaf, zero if there is none, and their lane there.
    pub(super) leaf: [[u32; LANES]; VECTORS],
    /// See `leaf`.
    pub(super) lane: [[u32; LANES]; VECTORS],
    /// Two lateral axes and the depth, in the order that keeps windings.
    pub(super) axes: [usize; 3],
    /// Bounds all rays.
    pub(super) frustum: Frustum,
    /// How many rays there are.
    pub(super) count: usize,
}

impl Tile {
    /// No rays.
    pub(super) const EMPTY: Self = Self {
        origin: [[[0.0; LANES]; VECTORS]; 3],
        direction: [[[0.0; LANES]; VECTORS]; 3],
        reciprocal: [[[0.0; LANES]; VECTORS]; 3],
        shear: [[[0.0; LANES]; VECTORS]; 2],
        lower: [[0.0; LANES]; VECTORS],
        near: [[0.0; LANES]; VECTORS],
        far: [[0.0; LANES]; VECTORS],
        leaf: [[0; LANES]; VECTORS],
        lane: [[0; LANES]; VECTORS],
        axes: [0, 1, 2],
        frustum: Frustum::EMPTY,
        count: 0,
    };

    /// Takes up to [`TILE`] rays; false if they have not one depth axis.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(&mut self, simd: S, rays: &[Ray]) -> bool {
        let Some(first) = rays.first() else { return false };
        self.count = rays.len();
        self.axes = dominant_axes(first.direction);
        self.transpose(rays);
        self.prepare(simd, first.direction[self.axes[2]]) && {
            self.frustum = Frustum::around(simd, self);
            true
        }
    }

    /// How many vectors hold rays.
    #[inline(always)]
    pub(super) fn vectors(&self) -> usize {
        self.count.div_ceil(LANES).min(VECTORS)
    }

    /// Copies the rays lane by lane. Spare lanes repeat the last ray, but end before they start.
    #[inline(always)]
    fn transpose(&mut self, rays: &[Ray]) {
        let last = &rays[rays.len() - 1];
        for v in 0..self.vectors() {
            let first = v * LANES;
            if let Some(rays) = rays.get(first..).and_then(<[Ray]>::first_chunk::<LANES>) {
                for (i, ray) in rays.iter().enumerate() {
                    self.put(v, i, ray, ray.t_max);
                }
            } else {
                for i in 0..LANES {
                    match rays.get(first + i) {
                        Some(ray) => self.put(v, i, ray, ray.t_max),
                        None => self.put(v, i, last, f32::NEG_INFINITY),
                    }
                }
            }
        }
        self.leaf = [[0; LANES]; VECTORS];
    }

    #[inline(always)]
    fn put(&mut self, v: usize, i: usize, ray: &Ray, end: f32) {
        let [x, y, z] = ray.origin.to_array();
        (self.origin[0][v][i], self.origin[1][v][i], self.origin[2][v][i]) = (x, y, z);
        let [x, y, z] = ray.direction.to_array();
        (self.direction[0][v][i], self.direction[1][v][i], self.direction[2][v][i]) = (x, y, z);
        self.lower[v][i] = positive_lower(ray.t_min);
        self.near[v][i] = end;
        self.far[v][i] = end;
    }

    /// The triangle of a ray's first hit so far.
    #[inline(always)]
    pub(super) fn place(&self, vector: usize, lane: usize) -> Option<Place> {
        let leaf = Leaf::of(self.leaf[vector][lane])?;
        Some(Place { leaf, lane: self.lane[vector][lane] })
    }

    /// Computes shears and reciprocals; false if a ray has another depth axis than the one with the component `depth`.
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, simd: S, depth: f32) -> bool {
        let [kx, ky, kz] = self.axes;
        let mut fits = true;
        for v in 0..self.vectors() {
            let z = f32x16::load_array_ref(simd, &self.direction[kz][v]);
            let along = z * 1.0_f32.copysign(depth);
            (f32x16::splat(simd, 1.0) / z).store_array(&mut self.reciprocal[kz][v]);
            let mut fit = along.simd_ge(ORDINARY.start) & along.simd_lt(ORDINARY.end);
            for origin in &self.origin {
                fit &= f32x16::load_array_ref(simd, &origin[v]).abs().simd_lt(LARGEST_ORIGIN);
            }
            for (lateral, axis) in [kx, ky].into_iter().enumerate() {
                let component = f32x16::load_array_ref(simd, &self.direction[axis][v]);
                (component / z).store_array(&mut self.shear[lateral][v]);
                let size = component.abs();
                fit &= if axis < kz { size.simd_le(along) } else { size.simd_lt(along) };
                let clamped = size.max(along * SMALLEST_COMPONENT).copysign(component);
                (f32x16::splat(simd, 1.0) / clamped).store_array(&mut self.reciprocal[axis][v]);
            }
            fits &= fit.all_true();
        }
        fits
    }
}
