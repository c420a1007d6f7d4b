//! Points on an emissive triangle, as seen from a point.
//!
//! Triangles that are large for their distance are sampled uniformly by solid angle (Arvo, "Stratified Sampling of Spherical
//! Triangles", 1995; without angles, after Peters, "BRDF Importance Sampling for Polygonal Lights", 2021). All others are sampled
//! uniformly by area (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019): the contributions of their points differ
//! little, slivers included. All is computed in f64.

use glam::{DVec3, Vec2, Vec3};

/// Triangles whose edges are all shorter than this share of the distance to the nearest corner are sampled by area. The cubes of
/// the distances of their points, and with them the densities by solid angle, differ by a third at most.
const LONGEST_EDGE: f64 = 0.1;

/// A sampled point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TriangleSample {
    /// Weights of the second and third corner.
    pub(crate) barycentrics: [f32; 2],
    /// Unit direction towards the point.
    pub(crate) direction: Vec3,
    /// Distance of the point.
    pub(crate) distance: f32,
    /// Density by solid angle.
    pub(crate) pdf: f32,
}

/// A sample of the triangle for the light at `point`, `u` in [0, 1)². `None` where the triangle is seen edge-on or is degenerate,
/// so that it sends no light there.
pub(crate) fn sample_triangle(corners: [Vec3; 3], point: Vec3, u: Vec2) -> Option<TriangleSample> {
    let view = TriangleView::new(corners, point)?;
    let u = u.as_dvec2().to_array();
    let spherical = view.spherical();
    let [b1, b2] =
        spherical.as_ref().map_or_else(|| area_sample(u), |triangle| view.barycentrics(triangle.sample(u)));
    let to_point = view.corners[0] * (1.0 - b1 - b2) + view.corners[1] * b1 + view.corners[2] * b2;
    let distance = to_point.length();
    let direction = to_point / distance;
    let pdf =
        spherical.map_or_else(|| view.area_pdf(direction), |triangle| 1.0 / triangle.solid_angle) as f32;
    let is_usable = distance > 0.0 && pdf > 0.0 && pdf < f32::INFINITY;
    is_usable.then(|| TriangleSample {
        barycentrics: [b1 as f32, b2 as f32],
        direction: direction.as_vec3(),
        distance: distance as f32,
        pdf,
    })
}

/// The density by solid angle with which [`sample_triangle`] samples the unit direction of a ray from `point` that hits the triangle.
pub(crate) fn triangle_pdf(corners: [Vec3; 3], point: Vec3, direction: Vec3) -> f32 {
    let Some(view) = TriangleView::new(corners, point) else { return 0.0 };
    let by_area = || view.area_pdf(direction.as_dvec3());
    let pdf = view.spherical().map_or_else(by_area, |triangle| 1.0 / triangle.solid_angle) as f32;
    if pdf < f32::INFINITY { pdf } else { 0.0 }
}

/// A triangle seen from a point.
struct TriangleView {
    /// The corners relative to the point.
    corners: [DVec3; 3],
    /// A normal twice as long as the area.
    normal: DVec3,
    /// The triple product of the corners: six times the volume of the tetrahedron.
    volume: f64,
}

impl TriangleView {
    /// `None` if the point lies in the triangle's plane, or the triangle is degenerate.
    fn new(corners: [Vec3; 3], point: Vec3) -> Option<Self> {
        let corners = corners.map(|corner| corner.as_dvec3() - point.as_dvec3());
        // The edges are exact where the corners are far: their product keeps the digits that one of the corners would lose.
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let volume = corners[0].dot(normal);
        let is_seen = volume != 0.0 && volume.is_finite();
        is_seen.then_some(Self { corners, normal, volume })
    }

    /// Whether the triangle is small for its distance.
    fn is_sampled_by_area(&self) -> bool {
        let [c0, c1, c2] = self.corners;
        let longest = c0.distance_squared(c1).max(c1.distance_squared(c2)).max(c2.distance_squared(c0));
        let nearest = c0.length_squared().min(c1.length_squared()).min(c2.length_squared());
        longest < LONGEST_EDGE * LONGEST_EDGE * nearest
    }

    /// The triangle on the unit sphere; `None` if it is sampled by area.
    fn spherical(&self) -> Option<SphericalTriangle> {
        if self.is_sampled_by_area() {
            return None;
        }
        let lengths = self.corners.map(DVec3::length);
        let [v0, v1, v2]: [DVec3; 3] = std::array::from_fn(|i| self.corners[i] / lengths[i]);
        let g0 = self.volume.abs() / (lengths[0] * lengths[1] * lengths[2]);
        let (g1, g2) = (v2.dot(v0) + v2.dot(v1), 1.0 + v0.dot(v1));
        // Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983.
        Some(SphericalTriangle {
            corners: [v0, v1, v2],
            g0,
            g1,
            g2,
            solid_angle: 2.0 * libm::atan2(g0, g1 + g2),
        })
    }

    /// The density by solid angle of a unit direction that hits the triangle, sampled by area: distance² / (area × cosine).
    fn area_pdf(&self, direction: DVec3) -> f64 {
        let projected = direction.dot(self.normal);
        let distance = self.volume / projected;
        2.0 * distance * distance / projected.abs()
    }

    /// Where a direction hits the triangle: the weights of the second and third corner.
    fn barycentrics(&self, direction: DVec3) -> [f64; 2] {
        let [c0, c1, c2] = self.corners;
        let sign = self.volume.signum();
        let weights = [c1.cross(c2), c2.cross(c0), c0.cross(c1)].map(|n| (sign * direction.dot(n)).max(0.0));
        let sum = weights[0] + weights[1] + weights[2];
        // Only rounding makes all weights zero or not finite: at the first corner.
        if sum > 0.0 { [weights[1] / sum, weights[2] / sum] } else { [0.0, 0.0] }
    }
}

/// A triangle on the unit sphere, with the terms of its solid angle Ω: tan(Ω / 2) = G0 / (G1 + G2).
struct SphericalTriangle {
    corners: [DVec3; 3],
    /// The triple product of the corners, without sign.
    g0: f64,
    /// v0·v2 + v1·v2.
    g1: f64,
    /// 1 + v0·v1.
    g2: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    /// A direction, uniform by solid angle.
    fn sample(&self, [u0, u1]: [f64; 2]) -> DVec3 {
        let [v0, v1, v2] = self.corners;
        // Find the point of the edge from v0 to v2 that cuts off the share u0 of the solid angle. With the vector
        // h = α v0 + β v2 halfway between v0 and that point, tan(u0 Ω / 2) = β G0 / (α G2 + β G1).
        let (sin, cos) = libm::sincos(0.5 * self.solid_angle * u0);
        let half = v0 * (self.g0 * cos - self.g1 * sin) + v2 * (self.g2 * sin);
        let on_edge = half * (2.0 * v0.dot(half) / half.dot(half)) - v0;
        // Choose a point of the arc from v1 to it, uniform in the cosine. One minus the cosine is half the squared chord.
        let below_one = u1 * 0.5 * v1.distance_squared(on_edge);
        let sine = (below_one * (2.0 - below_one)).max(0.0).sqrt();
        let across = on_edge - v1 * v1.dot(on_edge);
        v1 * (1.0 - below_one) + across * (sine / across.length())
    }
}

/// Weights of the second and third corner of a point, uniform by area.
fn area_sample([x, y]: [f64; 2]) -> [f64; 2] {
    if y > x { [0.5 * x, y - 0.5 * x] } else { [x - 0.5 * y, 0.5 * y] }
}

#[cfg(test)]
mod tests;
