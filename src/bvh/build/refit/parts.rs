//! Parts of split triangles in the leaves of a tree, which move with their triangles.
//!
//! A leaf of a split triangle covers a part of it: the part in the leaf's box when the tree was built. The part is kept as ranges of
//! the three barycentric coordinates, rounded outward. Every point of the triangle then is in the ranges of one of its leaves,
//! wherever its corners move, and the box of a part follows from the moved corners.

use glam::DVec3;

use crate::geometry::{Aabb, ClippedTriangle, Triangle, rounded_down, rounded_up};

/// Steps of a barycentric coordinate.
const STEPS: f64 = 65_535.0;
/// Margin of barycentric coordinates, above their rounding errors.
const MARGIN: f64 = 1.0e-4;
/// Triangles of less area, in units of the square of their longest edge, count as whole: their coordinates are inaccurate.
const MIN_AREA: f64 = 1.0e-10;

/// Part of a triangle: least and largest barycentric coordinates of the three corners, in [`STEPS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    low: [u16; 3],
    high: [u16; 3],
}

impl Part {
    /// The whole triangle.
    pub(super) const WHOLE: Self = Self { low: [0; 3], high: [u16::MAX; 3] };

    /// Part of `triangle` in a box.
    pub(super) fn inside(triangle: &Triangle, bounds: &Aabb) -> Self {
        if bounds.contains(&triangle.bounds()) {
            return Self::WHOLE;
        }
        clipped(triangle, bounds).and_then(|part| Self::around(triangle, &part)).unwrap_or(Self::WHOLE)
    }

    /// Ranges of the coordinates of a part's corners.
    fn around(triangle: &Triangle, part: &ClippedTriangle) -> Option<Self> {
        let [a, b, c] = triangle.vertices.map(glam::Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let square = normal.length_squared();
        // NaN fails, too.
        let is_accurate = square > (longest * MIN_AREA).powi(2) && square < f64::INFINITY;
        if !is_accurate {
            return None;
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &corner in part.corners() {
            let p = DVec3::from_array(corner);
            let coordinates = DVec3::new(
                (b - p).cross(c - p).dot(normal),
                (c - p).cross(a - p).dot(normal),
                (a - p).cross(b - p).dot(normal),
            ) / square;
            (low, high) = (low.min(coordinates), high.max(coordinates));
        }
        let step = |x: f64| (x * STEPS).clamp(0.0, STEPS);
        Some(Self {
            low: low.to_array().map(|x| step(x - MARGIN).floor() as u16),
            high: high.to_array().map(|x| step(x + MARGIN).ceil() as u16),
        })
    }

    /// Box of the part of a moved triangle.
    pub(super) fn bounds(&self, triangle: &Triangle) -> Aabb {
        let whole = triangle.bounds();
        if *self == Self::WHOLE {
            return whole;
        }
        let mut bounds = whole;
        for axis in 0..3 {
            let corners = triangle.vertices.map(|vertex| f64::from(vertex[axis]));
            bounds.min[axis] = rounded_down(self.least(corners)).max(whole.min[axis]);
            bounds.max[axis] = rounded_up(-self.least(corners.map(|x| -x))).min(whole.max[axis]);
        }
        bounds
    }

    /// Least mean of three values weighted by coordinates in the ranges, which sum to one: what the lower limits leave goes to
    /// the lowest values first.
    fn least(&self, values: [f64; 3]) -> f64 {
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut left = STEPS - self.low.iter().map(|&low| f64::from(low)).sum::<f64>();
        let mut sum = 0.0;
        for corner in order {
            let low = f64::from(self.low[corner]);
            let more = left.min(f64::from(self.high[corner]) - low).max(0.0);
            left -= more;
            sum += (low + more) * values[corner];
        }
        sum / STEPS
    }
}

/// Part of a triangle inside a box.
fn clipped(triangle: &Triangle, bounds: &Aabb) -> Option<ClippedTriangle> {
    let mut part = ClippedTriangle::whole(triangle);
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if part.bounds().min[axis] < low && low < part.bounds().max[axis] {
            let [_, above] = part.cut(axis, low);
            part = above?;
        }
        if part.bounds().min[axis] < high && high < part.bounds().max[axis] {
            let [below, _] = part.cut(axis, high);
            part = below?;
        }
    }
    Some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn triangle() -> Triangle {
        Triangle { vertices: [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 1.0)] }
    }

    #[test]
    fn a_part_that_does_not_move_keeps_its_box() {
        let bounds = Aabb { min: Vec3::new(1.0, -1.0, -1.0), max: Vec3::new(2.0, 5.0, 5.0) };
        let part = Part::inside(&triangle(), &bounds).bounds(&triangle());
        // Between x of 1 and 2 the triangle reaches y of 3, where z is three quarters.
        let expected = Aabb { min: Vec3::new(1.0, 0.0, 0.0), max: Vec3::new(2.0, 3.0, 0.75) };
        assert!(part.contains(&expected), "{part:?}");
        assert!(expected.grown(0.01).contains(&part), "{part:?}");
        let around = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(5.0) };
        assert_eq!(Part::inside(&triangle(), &around), Part::WHOLE);
    }

    #[test]
    fn moved_parts_cover_their_points() {
        let bounds = Aabb { min: Vec3::new(0.5, 0.25, -1.0), max: Vec3::new(1.5, 2.0, 0.4) };
        let part = Part::inside(&triangle(), &bounds);
        let moved = Triangle {
            vertices: [Vec3::new(3.0, 1.0, 9.0), Vec3::new(-2.0, 7.0, 1.0), Vec3::new(0.5, 0.1, -8.0)],
        };
        let box_of_part = part.bounds(&moved);
        let mut inside = 0;
        for i in 0..=100 {
            for j in 0..=100 - i {
                let (u, v) = (i as f32 / 100.0, j as f32 / 100.0);
                let point = |t: &Triangle| {
                    let [a, b, c] = t.vertices;
                    a * (1.0 - u - v) + b * u + c * v
                };
                if bounds.contains(&Aabb::from_points(&[point(&triangle())])) {
                    inside += 1;
                    assert!(box_of_part.grown(1.0e-5).contains(&Aabb::from_points(&[point(&moved)])));
                }
            }
        }
        assert!(inside > 100);
        assert!(box_of_part.area() < 0.8 * moved.bounds().area());
    }
}
