//! Watertight ray-triangle intersection: the one definition of a hit.
//!
//! Source: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The vertices are translated to
//! the ray's origin and sheared so that the ray runs along an axis. Three 2D edge functions then tell inside from outside.
//!
//! Departures: only the translated and sheared vertices are `f32`; all later values are `f64`. A ray through an edge hits one
//! of the two adjacent triangles, not both.
//!
//! # Watertight, and each surface once
//!
//! A vertex is sheared by the same operations for every triangle that shares it, so adjacent triangles have the same 2D
//! points. An edge function is a difference of two products of `f32` numbers. `f64` holds these products exactly, so the sign is
//! exact. Zero means that the ray intersects the edge. Such a ray is treated as if it were moved by (ε, ε²) with an
//! infinitesimal ε (Edelsbrunner and Mücke, "Simulation of Simplicity", 1990). Every ray therefore hits what a ray next to it hits
//! in exact arithmetic: a closed surface has no gap, and a blended or refracting surface is not hit twice along its edges.
//! Edge functions computed in `f32` have the exact sign as well, except at zero, because rounding is monotone:
//! the larger of two products never rounds to the smaller number.
//!
//! # Any hierarchy finds the same hits
//!
//! Let `X = |origin|∞ + |vertices|∞`. Relative to the origin, a vertex `v` has the rounded depth `z'` and the sheared coordinates
//! `x'`. The weights `w = (U, V, W) / (U + V + W)` have one sign, so `P = Σ wᵢ·vᵢ` is a point of the triangle, and `Σ wᵢ·x'ᵢ = 0`
//! up to roundings of `f64`. With a shear of at most one, `x'` has errors of `2⁻²⁴` of the difference to the origin, of the shear, of
//! its product with `z'` and, twice as large, of the last difference: at most `5·2⁻²⁴·X`. The ray passes the plane of `P`'s
//! depth at a distance of at most the weighted mean of these errors, and the error of `z'` is `2⁻²⁴·X`. So `P` lies within `0.63·2⁻²¹·X` of the
//! point `origin + t·direction` in each coordinate, with `t` before it is rounded to `f32`, for any thin triangle and any grazing
//! angle. `P` lies in every box that contains its part of the triangle. Boxes are grown by [`BOX_PADDING`] times the triangle's
//! largest coordinate and [`BOX_PADDING`] times the largest coordinate of the origin, `2⁻²¹·X` together. What is left,
//! `2.9·2⁻²⁴·X`, covers two roundings of each: of the grown box and its product, and of the moved origin and its product. Packets do not
//! move the origin and grow boxes twice as far for it. The slab test therefore finds the ray inside all of these boxes at `t`, up to
//! the relative error of its own arithmetic and of the last rounding of `t`, which it allows for. No box that contains the hit is missed or entered after the hit, for every split of the
//! triangles and every nesting of the boxes.

use glam::Vec3;

use super::hit::{Facing, TriangleHit};
use super::ray::{Ray, is_within};

/// Growth of bounding boxes that makes the slab test conservative, relative to the largest coordinate.
pub(crate) const BOX_PADDING: f32 = 1.0 / (1 << 21) as f32;

/// Ray prepared for triangle tests. Coordinates are in the order of `axes`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    direction_z: f32,
    t_min: f32,
    t_max: f32,
}

/// Axis order with the largest component of the direction last that keeps the winding of triangles.
#[inline(always)]
pub(crate) fn dominant_axes(direction: Vec3) -> [usize; 3] {
    // A table: branches on directions are mispredicted.
    const ORDERS: [[usize; 3]; 8] =
        [[1, 2, 0], [2, 1, 0], [2, 0, 1], [0, 2, 1], [0, 1, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2]];
    let [x, y, z] = direction.abs().to_array();
    let is_x = x > y;
    let is_lateral = if is_x { x } else { y } > z;
    let depth = 2 - usize::from(is_lateral) * (1 + usize::from(is_x));
    let is_backward = direction.to_array()[depth] < 0.0;
    ORDERS[2 * depth + usize::from(is_backward)]
}

impl ShearedRay {
    /// Prepares `ray`.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let axes = dominant_axes(ray.direction);
        let [kx, ky, kz] = axes;
        let direction_z = ray.direction[kz];
        Self {
            axes,
            origin: [ray.origin[kx], ray.origin[ky], ray.origin[kz]],
            shear: [ray.direction[kx] / direction_z, ray.direction[ky] / direction_z],
            direction_z,
            t_min: ray.t_min,
            t_max: ray.t_max,
        }
    }

    /// Tests the triangle of these corners, which must not be degenerate.
    #[inline]
    pub(crate) fn intersect(&self, corners: &[Vec3; 3]) -> Option<TriangleHit> {
        let [kx, ky, kz] = self.axes;
        let [a, b, c] = *corners;
        let [a, b, c] = [
            self.sheared([a[kx], a[ky], a[kz]]),
            self.sheared([b[kx], b[ky], b[kz]]),
            self.sheared([c[kx], c[ky], c[kz]]),
        ];

        // Edge functions: mixed signs are outside
        let [u, v, w] = edge_functions([a, b, c]);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let left = [is_left_of(c, b, u), is_left_of(a, c, v), is_left_of(b, a, w)];
            if left[0] != left[1] || left[1] != left[2] {
                return None;
            }
        }

        // Reject edge-on and overflowing triangles
        let det = u + v + w;
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let hit = self.hit([a, b, c], [u, v, w]);
        is_within(hit.t, self.t_min, self.t_max).then_some(hit)
    }

    /// Axis order of the corners for [`ShearedRay::intersect_known`]: two lateral axes and the depth.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.axes
    }

    /// The hit with a triangle that [`ShearedRay::intersect`] is known to accept, with the same bits. The coordinates of the
    /// corners are in the order of [`ShearedRay::axes`].
    #[inline(always)]
    pub(crate) fn intersect_known(&self, [a, b, c]: [[f32; 3]; 3]) -> TriangleHit {
        let corners = [self.sheared(a), self.sheared(b), self.sheared(c)];
        self.hit(corners, edge_functions(corners))
    }

    /// The hit for given sheared corners and edge functions. The distance is rounded once.
    #[inline(always)]
    fn hit(&self, [a, b, c]: [[f64; 3]; 3], [u, v, w]: [f64; 3]) -> TriangleHit {
        let det = u + v + w;
        TriangleHit {
            t: ((u * a[2] + v * b[2] + w * c[2]) / (det * f64::from(self.direction_z))) as f32,
            u: (v / det) as f32,
            v: (w / det) as f32,
            facing: if det > 0.0 { Facing::Front } else { Facing::Back },
        }
    }

    /// Translates a point to the origin and shears it in `f32`, so that the ray runs along z.
    #[inline(always)]
    fn sheared(&self, point: [f32; 3]) -> [f64; 3] {
        let x = point[0] - self.origin[0];
        let y = point[1] - self.origin[1];
        let z = point[2] - self.origin[2];
        [f64::from(x - self.shear[0] * z), f64::from(y - self.shear[1] * z), f64::from(z)]
    }
}

/// Edge functions of sheared corners. The corners are `f32` numbers, so the signs are exact.
#[inline(always)]
fn edge_functions([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}

/// Whether the edge function p₀ q₁ − p₁ q₀ is positive. At zero the ray is moved by (ε, ε²), which adds ε (p₁ − q₁) − ε² (p₀ − q₀).
fn is_left_of(p: [f64; 3], q: [f64; 3], edge_function: f64) -> bool {
    if edge_function != 0.0 {
        edge_function > 0.0
    } else if p[1] == q[1] {
        p[0] < q[0]
    } else {
        p[1] > q[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Facing, Triangle};

    #[test]
    fn winding_is_kept_for_every_dominant_axis() {
        for axis in 0..3 {
            for sign in [1.0_f32, -1.0] {
                // Counter-clockwise seen from the origin of the ray: the normal points against the direction.
                let mut direction = Vec3::splat(0.125);
                direction[axis] = sign;
                let normal = -Vec3::AXES[axis] * sign;
                let e1 = Vec3::AXES[(axis + 1) % 3];
                let e2 = normal.cross(e1);
                let front = Triangle { vertices: [-e1 - e2, e1 - e2, e2] };
                assert!(front.scaled_normal().dot(direction) < 0.0);
                let ray = Ray::new(-direction * 3.0, direction);
                let hit = front.intersect(&ray).unwrap();
                assert_eq!((hit.facing, hit.t), (Facing::Front, 3.0));
                let [a, b, c] = front.vertices;
                let back = Triangle { vertices: [a, c, b] };
                assert_eq!(back.intersect(&ray).unwrap().facing, Facing::Back);
            }
        }
    }

    #[test]
    fn barycentrics_weigh_the_second_and_third_corner() {
        let triangle = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        let hit = triangle.intersect(&Ray::new(Vec3::new(0.25, 0.5, 2.0), Vec3::NEG_Z)).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (2.0, 0.25, 0.5));
        assert_eq!(hit.facing, Facing::Front);
    }

    #[test]
    fn the_interval_is_open() {
        let triangle = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        let mut ray = Ray::new(Vec3::new(0.25, 0.25, 2.0), Vec3::NEG_Z);
        ray.t_max = 2.0;
        assert!(triangle.intersect(&ray).is_none());
        ray.t_max = 2.0_f32.next_up();
        assert!(triangle.intersect(&ray).is_some());
        ray.t_min = 2.0;
        assert!(triangle.intersect(&ray).is_none());
        // The triangle lies behind the origin.
        assert!(triangle.intersect(&Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::Z)).is_none());
    }

    #[test]
    fn a_ray_through_an_edge_or_a_vertex_hits_one_triangle_of_a_plane() {
        // A plane of a fan around the origin and an outer ring. Perpendicular and slanted rays cross all edges and vertices.
        let around = |i: usize, radius: f32| {
            let angle = (i % 7) as f32 * 0.9;
            Vec3::new(libm::cosf(angle) * radius, libm::sinf(angle) * radius, 0.25)
        };
        let mut triangles = Vec::new();
        for i in 0..7 {
            triangles.push([Vec3::new(0.0, 0.0, 0.25), around(i, 1.0), around(i + 1, 1.0)]);
            triangles.push([around(i, 1.0), around(i, 9.0), around(i + 1, 9.0)]);
            triangles.push([around(i, 1.0), around(i + 1, 9.0), around(i + 1, 1.0)]);
        }
        for direction in [Vec3::NEG_Z, Vec3::new(0.3, -0.7, -1.0), Vec3::new(1.0, 0.5, -0.25)] {
            for i in 0..7 {
                for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                    for target in [around(i, share), around(i, 1.0).lerp(around(i + 1, 1.0), share)] {
                        let ray = Ray::new(target - direction * 4.0, direction);
                        let hits = triangles
                            .iter()
                            .filter(|&&vertices| Triangle { vertices }.intersect(&ray).is_some());
                        assert_eq!(hits.count(), 1, "{ray:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ray_at_a_silhouette_edge_hits_both_adjacent_triangles_or_none() {
        // A roof seen from the side: its front and back share the ridge.
        let (a, b) = (Vec3::new(0.0, 1.0, -1.0), Vec3::new(0.0, 1.0, 1.0));
        let front = Triangle { vertices: [a, Vec3::new(1.0, 0.0, 0.0), b] };
        let back = Triangle { vertices: [b, Vec3::new(-1.0, 0.0, 0.0), a] };
        for z in [-0.5, 0.0, 0.25] {
            let ray = Ray::new(Vec3::new(5.0, 1.0, z), Vec3::NEG_X);
            assert_eq!(front.intersect(&ray).is_some(), back.intersect(&ray).is_some());
        }
    }

    #[test]
    fn edge_on_and_degenerate_triangles_are_never_hit() {
        let flat = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        assert!(flat.intersect(&Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X)).is_none());
        // Collinear and repeated corners, with rays from many directions.
        let line = Triangle { vertices: [Vec3::ONE, Vec3::splat(3.0), Vec3::splat(2.0)] };
        let point = Triangle { vertices: [Vec3::ONE, Vec3::ONE, Vec3::splat(2.0)] };
        for i in 0..1000 {
            let origin = Vec3::new((i % 10) as f32 - 5.1, (i / 10 % 10) as f32 + 0.3, (i / 100) as f32 * 7.7);
            let ray = Ray::new(origin, Vec3::splat(2.0) - origin);
            assert!(line.intersect(&ray).is_none());
            assert!(point.intersect(&ray).is_none());
        }
    }

    /// Asserts the error bound that bounding boxes rely on.
    fn assert_is_near(triangle: &Triangle, ray: &Ray, hit: &TriangleHit) {
        let weights = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
        let scale = f64::from(ray.origin.abs().max_element()) + f64::from(triangle.magnitude());
        for axis in 0..3 {
            let on_triangle: f64 = (0..3).map(|k| weights[k] * f64::from(triangle.vertices[k][axis])).sum();
            let on_ray = f64::from(ray.origin[axis]) + f64::from(hit.t) * f64::from(ray.direction[axis]);
            // The bound is 0.63 of this; the rest allows for rounding t, u and v to f32.
            assert!((on_triangle - on_ray).abs() <= 2.0_f64.powi(-21) * scale, "{triangle:?} {ray:?}");
        }
    }

    #[test]
    fn hits_of_coplanar_rays_obey_the_error_bound() {
        // Integers with x = 3 y: all points lie exactly in one plane. One third is not exact in the shear, so the edge
        // functions are rounding noise and often have one sign. Such hits obey the bound.
        let mut state = 5_u32;
        let mut integer = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 25) as f32 - 64.0
        };
        let mut point = || {
            let y = integer();
            Vec3::new(3.0 * y, y, integer())
        };
        for _ in 0..100_000 {
            let [a, b, c] = [point(), point(), point()];
            let origin = point();
            let triangle = Triangle { vertices: [a, b, c] };
            for target in [a, b, c, point()] {
                let ray = Ray::new(origin, target - origin);
                if let Some(hit) = triangle.intersect(&ray) {
                    assert_is_near(&triangle, &ray, &hit);
                }
            }
        }
    }

    #[test]
    fn hits_of_slivers_obey_the_error_bound() {
        // Slivers of increasing aspect ratio, seen from random directions.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut hits = 0;
        for i in 0..200_000 {
            let along = Vec3::new(random(), random(), random());
            let across = Vec3::new(random(), random(), random()) * libm::powf(10.0, -((i % 9) as f32));
            let a = Vec3::new(random(), random(), random());
            let triangle = Triangle { vertices: [a, a + along, a + along * 0.5 + across] };
            // Every second ray starts in line with the long edge and sees the sliver edge-on up to rounding.
            let origin =
                if i % 2 == 0 { Vec3::new(random(), random(), random()) * 2.0 } else { a - along * 0.7 };
            let ray = Ray::new(origin, a + along * 0.4 + across * 0.3 - origin);
            let Some(hit) = triangle.intersect(&ray) else {
                continue;
            };
            hits += 1;
            assert_is_near(&triangle, &ray, &hit);
        }
        assert!(hits > 40_000, "{hits}");
    }
}
