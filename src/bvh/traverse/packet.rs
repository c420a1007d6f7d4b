//! Packet of up to 64 coherent rays as structure of arrays.

use fearless_simd::{Simd, f32x16, prelude::*};

use super::lane_ray::MIN_COMPONENT;
use super::visitor::{TriangleSlot, lower_or_zero};
use crate::bvh::wide_tree::Leaf;
use crate::geometry::{Ray, dominant_axes};

/// Lanes of a vector.
pub(super) const LANES: usize = 16;
/// Vectors of a packet.
pub(super) const VECTORS: usize = 4;
/// Rays of a packet.
pub(super) const PACKET_SIZE: usize = LANES * VECTORS;

/// Fewer rays than this are traced one by one.
pub(super) const MIN_PACKET: usize = 8;

/// Upper limit of origin coordinates. Their products with reciprocals are finite.
const MAX_ORIGIN: f32 = 1.0e18;
/// Limits of the direction component along the depth axis.
const DEPTH_COMPONENTS: std::ops::Range<f32> = 1.0e-10..1.0e10;

/// One number per ray.
pub(super) type Row = [[f32; LANES]; VECTORS];

/// Rays with one depth axis and the same sense along it.
#[repr(align(64))]
pub(super) struct Packet {
    /// Origins, by axis.
    pub(super) origin: [Row; 3],
    /// Directions, by axis.
    pub(super) direction: [Row; 3],
    /// Reciprocals of the direction's components, of which none counts as zero.
    pub(super) reciprocal: [Row; 3],
    /// Origins times the reciprocals, by axis.
    pub(super) origin_over_direction: [Row; 3],
    /// The two lateral components over the one along the depth axis.
    pub(super) shear: [Row; 2],
    /// Exclusive lower limit of `t`; zero stands for [`LEAST_LOWER`](super::visitor::LEAST_LOWER).
    pub(super) lower: Row,
    /// Lower bound of the closest hit so far; the end of the ray while there is none. Unused lanes have −∞.
    pub(super) near: Row,
    /// Upper bound of the closest hit so far.
    pub(super) far: Row,
    /// Leaf words of the closest hits so far, zero if there is none.
    pub(super) leaf: [[u32; LANES]; VECTORS],
    /// Lanes of the closest hits so far in their leaves.
    pub(super) lane: [[u32; LANES]; VECTORS],
    /// Two lateral axes and the depth axis, in the order that keeps the winding.
    pub(super) axes: [usize; 3],
    /// Number of rays.
    pub(super) count: usize,
}

impl Packet {
    /// No rays.
    pub(super) const EMPTY: Self = Self {
        origin: [[[0.0; LANES]; VECTORS]; 3],
        direction: [[[0.0; LANES]; VECTORS]; 3],
        reciprocal: [[[0.0; LANES]; VECTORS]; 3],
        origin_over_direction: [[[0.0; LANES]; VECTORS]; 3],
        shear: [[[0.0; LANES]; VECTORS]; 2],
        lower: [[0.0; LANES]; VECTORS],
        near: [[0.0; LANES]; VECTORS],
        far: [[0.0; LANES]; VECTORS],
        leaf: [[0; LANES]; VECTORS],
        lane: [[0; LANES]; VECTORS],
        axes: [0, 1, 2],
        count: 0,
    };

    /// Replaces the rays with up to [`PACKET_SIZE`] others; false if they do not share one depth axis and its sense.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(&mut self, simd: S, rays: &[Ray]) -> bool {
        let Some(first) = rays.first() else { return false };
        self.count = rays.len();
        self.axes = dominant_axes(first.direction);
        self.transpose(rays);
        self.prepare(simd, first.direction[self.axes[2]])
    }

    /// Number of vectors that hold rays.
    #[inline(always)]
    pub(super) fn vectors(&self) -> usize {
        self.count.div_ceil(LANES).min(VECTORS)
    }

    /// Copies the rays lane by lane. Unused lanes repeat the last ray, but end before they start.
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
        self.lower[v][i] = lower_or_zero(ray.t_min);
        self.near[v][i] = end;
        self.far[v][i] = end;
    }

    /// Slot of the closest triangle so far of one ray.
    #[inline(always)]
    pub(super) fn slot(&self, vector: usize, lane: usize) -> Option<TriangleSlot> {
        let leaf = Leaf::of(self.leaf[vector][lane])?;
        Some(TriangleSlot { leaf, lane: self.lane[vector][lane] })
    }

    /// Computes shears, reciprocals and their products with the origins. False if the depth axis or sense of a ray differs from
    /// those of the ray whose component along the depth axis is `depth`.
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, simd: S, depth: f32) -> bool {
        let [kx, ky, kz] = self.axes;
        let mut fits = true;
        for v in 0..self.vectors() {
            let z = f32x16::load_array_ref(simd, &self.direction[kz][v]);
            let along = z * 1.0_f32.copysign(depth);
            (f32x16::splat(simd, 1.0) / z).store_array(&mut self.reciprocal[kz][v]);
            let mut fit = along.simd_ge(DEPTH_COMPONENTS.start) & along.simd_lt(DEPTH_COMPONENTS.end);
            for origin in &self.origin {
                fit &= f32x16::load_array_ref(simd, &origin[v]).abs().simd_lt(MAX_ORIGIN);
            }
            for (lateral, axis) in [kx, ky].into_iter().enumerate() {
                let component = f32x16::load_array_ref(simd, &self.direction[axis][v]);
                (component / z).store_array(&mut self.shear[lateral][v]);
                let size = component.abs();
                // Ties go to the higher axis, as in `dominant_axes`.
                fit &= if axis < kz { size.simd_le(along) } else { size.simd_lt(along) };
                let clamped = size.max(along * MIN_COMPONENT).copysign(component);
                (f32x16::splat(simd, 1.0) / clamped).store_array(&mut self.reciprocal[axis][v]);
            }
            fits &= fit.all_true();
            for axis in 0..3 {
                let origin = f32x16::load_array_ref(simd, &self.origin[axis][v]);
                let reciprocal = f32x16::load_array_ref(simd, &self.reciprocal[axis][v]);
                (origin * reciprocal).store_array(&mut self.origin_over_direction[axis][v]);
            }
        }
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::SimdLevel;
    use crate::bvh::simd::dispatch_lanes;
    use glam::Vec3;

    /// Depth axis of a packet of two rays, if they share one and its sense.
    fn depth_axis(directions: [Vec3; 2], level: SimdLevel) -> Option<usize> {
        let rays = directions.map(|direction| Ray::new(Vec3::ONE, direction));
        let mut packet = Packet::EMPTY;
        let level = level.level();
        let fits = dispatch_lanes!(level, simd => packet.fill(simd, &rays));
        fits.then_some(packet.axes[2])
    }

    #[test]
    fn ties_of_components_go_to_the_higher_axis() {
        let along = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * 2.0 + Vec3::splat(0.5));
        let ties = [([1.0, 1.0, 0.0], 1), ([0.0, 1.0, 1.0], 2), ([1.0, 0.0, 1.0], 2), ([1.0, 1.0, 1.0], 2)];
        for level in SimdLevel::ALL.into_iter().filter(|level| level.is_supported()) {
            for (tie, axis) in ties.map(|(tie, axis)| (Vec3::from_array(tie), axis)) {
                assert_eq!(dominant_axes(tie)[2], axis);
                for (other, ordinary) in along.into_iter().enumerate() {
                    let expected = (axis == other).then_some(axis);
                    assert_eq!(depth_axis([tie, ordinary], level), expected, "{tie} {other} {level:?}");
                    assert_eq!(depth_axis([ordinary, tie], level), expected, "{tie} {other} {level:?}");
                }
                assert_eq!(depth_axis([tie, -along[axis]], level), None);
            }
        }
    }
}
