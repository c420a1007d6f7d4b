//! Triangles: bounds, degeneracy and intersection.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::{DVec3, Vec3};

use super::hit::TriangleHit;
use super::watertight::ShearedRay;
use super::{Aabb, Ray};

/// Rounding error of a component of the normal, relative to its products: three roundings of 2⁻²⁴ each contribute to one.
const RELATIVE: f32 = 1.0 / (1 << 20) as f32;
/// Products below this are not rounded relatively.
const ABSOLUTE: f32 = 1.0e-36;

/// A triangle in world space; the front face is the one whose vertices run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Triangle {
    /// The corners.
    pub vertices: [Vec3; 3],
}

impl Triangle {
    /// Bounding box of the corners.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(&self.vertices)
    }

    /// Twice the area times the front face's unit normal.
    pub fn scaled_normal(&self) -> Vec3 {
        let [a, b, c] = self.vertices;
        (b - a).cross(c - a)
    }

    /// The solid angle around `point` that the triangle covers, steradians; positive where its front is seen. Errs by some 1e-7.
    ///
    /// Source: Van Oosterom, Strackee, "The Solid Angle of a Plane Triangle", IEEE Transactions on Biomedical Engineering 30(2), 1983.
    pub fn signed_solid_angle(&self, point: Vec3) -> f32 {
        let [a, b, c] = self.vertices.map(|vertex| (vertex - point).normalize_or_zero());
        2.0 * libm::atan2f(-a.dot(b.cross(c)), 1.0 + a.dot(b) + a.dot(c) + b.dot(c))
    }

    /// The hit of `ray` on either side. `t` is positive and lies inside the ray's open interval. Degenerate triangles are never
    /// hit.
    pub fn intersect(&self, ray: &Ray) -> Option<TriangleHit> {
        if self.is_degenerate() {
            return None;
        }
        ShearedRay::new(ray).intersect(&self.vertices)
    }

    /// Whether no ray can hit the triangle: its area is zero (repeated or collinear corners) or a coordinate is not finite.
    #[inline]
    pub fn is_degenerate(&self) -> bool {
        !self.is_clearly_regular() && self.is_exactly_degenerate()
    }

    /// Conservative quick test: ordinary triangles pass, degenerate ones never do. It requires a finite component of the normal
    /// that is far larger than the rounding error of zero in `f32`.
    #[inline]
    fn is_clearly_regular(&self) -> bool {
        let [a, b, c] = self.vertices;
        let (ab, ac) = (b - a, c - a);
        let plus = Vec3::new(ab.y * ac.z, ab.z * ac.x, ab.x * ac.y);
        let minus = Vec3::new(ab.z * ac.y, ab.x * ac.z, ab.y * ac.x);
        let normal = (plus - minus).abs();
        let rounding = (plus.abs() + minus.abs()) * RELATIVE + Vec3::splat(ABSOLUTE);
        // Infinite and NaN coordinates propagate to the sum.
        normal.cmpgt(rounding).any() && normal.element_sum() < f32::INFINITY
    }

    fn is_exactly_degenerate(&self) -> bool {
        let [a, b, c] = self.vertices.map(as_f64);
        let (ab, ac) = (b - a, c - a);
        // Rounded products of exactly collinear edges are equal, so their difference is exactly zero.
        let normal = [ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x];
        !normal.iter().any(|component| *component != 0.0)
            || !normal.iter().all(|component| component.is_finite())
    }

    /// Largest absolute coordinate of the corners, metres.
    pub fn magnitude(&self) -> f32 {
        let [a, b, c] = self.vertices.map(Vec3::abs);
        a.max(b).max(c).max_element()
    }
}

/// Whether eight triangles, given by the coordinates of their corners, all pass [`Triangle::is_clearly_regular`].
#[inline(always)]
pub(crate) fn are_clearly_regular<S: Simd>(simd: S, [a, b, c]: &[[f32x8<S>; 3]; 3]) -> bool {
    let ab = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let ac = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    let zero = f32x8::splat(simd, 0.0);
    let (mut is_clear, mut sum) = (zero.simd_lt(zero), zero);
    for (u, v) in [(1, 2), (2, 0), (0, 1)] {
        let (plus, minus) = (ab[u] * ac[v], ab[v] * ac[u]);
        let normal = (plus - minus).abs();
        is_clear |= normal.simd_gt((plus.abs() + minus.abs()) * RELATIVE + ABSOLUTE);
        sum += normal;
    }
    (is_clear & sum.simd_lt(f32x8::splat(simd, f32::INFINITY))).all_true()
}

fn as_f64(point: Vec3) -> DVec3 {
    point.as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_test_rejects_all_degenerate_triangles() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut regular = 0;
        for i in 0..20_000 {
            let scale = [1.0, 1.0e-20, 1.0e-38, 1.0e19, 3.0e38][i % 5];
            let [a, b] = [0; 2].map(|_| Vec3::new(random(), random(), random()));
            // A third corner collinear with the others up to rounding, or anywhere, or not finite.
            let c = match i % 4 {
                0 => a + (b - a) * 0.5,
                1 => b + (b - a) * random(),
                2 => Vec3::new(random(), random(), random()),
                _ => Vec3::new(random(), [f32::NAN, f32::INFINITY][i % 2], random()),
            };
            let triangle = Triangle { vertices: [a, b, c].map(|p| p * scale) };
            if triangle.is_clearly_regular() {
                regular += 1;
                assert!(!triangle.is_exactly_degenerate(), "{triangle:?}");
            }
        }
        assert!(regular > 2000, "{regular}");
    }

    #[test]
    fn triangles_without_area_or_with_infinite_corners_are_degenerate() {
        let corner = Vec3::new(0.1, 0.2, 0.3);
        let regular = [corner, corner + Vec3::X * 1.0e-6, corner + Vec3::Y * 1.0e-6];
        assert!(!Triangle { vertices: regular }.is_degenerate());
        for scale in [1.0, 1.0e30, 1.0e-30] {
            let vertices = [Vec3::ONE, Vec3::splat(2.0), Vec3::splat(5.0)].map(|p| p * scale);
            assert!(!Triangle { vertices: [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale] }.is_degenerate());
            assert!(Triangle { vertices: [vertices[0], vertices[0], vertices[1]] }.is_degenerate());
        }
        assert!(Triangle { vertices: [Vec3::ONE, Vec3::splat(2.0), Vec3::splat(5.0)] }.is_degenerate());
        assert!(Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::new(0.0, f32::NAN, 0.0)] }.is_degenerate());
        assert!(
            Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::new(0.0, f32::INFINITY, 0.0)] }.is_degenerate()
        );
    }
}
