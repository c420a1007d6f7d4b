//! Where the part of a triangle that lies inside a box reaches.
//!
//! Source: the clipping is Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, against the planes
//! of a box, computed in `f64`; it serves early split clipping (see [`crate::bvh`]).

use super::{Aabb, Triangle};

/// A triangle cut by six planes has at most nine corners; rounding may bend a side and so add a few at the same place.
const MOST_CORNERS: usize = 16;

#[derive(Clone, Copy)]
struct Polygon {
    corners: [[f64; 3]; MOST_CORNERS],
    len: usize,
}

impl Triangle {
    /// The bounds of the part of this triangle that lies inside `region`, itself inside `region`, rounded outward;
    /// `None` if there is no such part.
    pub fn clipped_bounds(&self, region: &Aabb) -> Option<Aabb> {
        let whole = self.bounds();
        let mut polygon = Polygon { corners: [[0.0; 3]; MOST_CORNERS], len: 3 };
        for (corner, vertex) in polygon.corners.iter_mut().zip(&self.vertices) {
            *corner = vertex.to_array().map(f64::from);
        }

        // Only planes that cut the triangle's bounds matter.
        for axis in 0..3 {
            if region.min[axis] > whole.min[axis] {
                polygon = polygon.cut(axis, f64::from(region.min[axis]), 1.0);
            }
            if region.max[axis] < whole.max[axis] {
                polygon = polygon.cut(axis, f64::from(region.max[axis]), -1.0);
            }
        }
        polygon.bounds_within(region)
    }
}

impl Polygon {
    /// The part at or beyond `plane` in the direction `side` (1 or −1) along `axis`.
    fn cut(&self, axis: usize, plane: f64, side: f64) -> Self {
        let mut result = Self { corners: [[0.0; 3]; MOST_CORNERS], len: 0 };
        for i in 0..self.len {
            let from = &self.corners[i];
            let to = &self.corners[(i + 1) % self.len];
            let from_height = (from[axis] - plane) * side;
            let to_height = (to[axis] - plane) * side;
            if from_height >= 0.0 {
                result.push(*from);
            }
            if (from_height > 0.0 && to_height < 0.0) || (from_height < 0.0 && to_height > 0.0) {
                let s = from_height / (from_height - to_height);
                let mut crossing = [0.0; 3];
                for k in 0..3 {
                    crossing[k] = from[k] + (to[k] - from[k]) * s;
                }
                crossing[axis] = plane;
                result.push(crossing);
            }
        }
        result
    }

    fn push(&mut self, corner: [f64; 3]) {
        debug_assert!(self.len < MOST_CORNERS);
        if self.len < MOST_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    fn bounds_within(&self, region: &Aabb) -> Option<Aabb> {
        let (first, rest) = self.corners[..self.len].split_first()?;
        let (mut min, mut max) = (*first, *first);
        for corner in rest {
            for axis in 0..3 {
                min[axis] = min[axis].min(corner[axis]);
                max[axis] = max[axis].max(corner[axis]);
            }
        }
        let mut bounds = *region;
        for axis in 0..3 {
            bounds.min[axis] = bounds.min[axis].max(rounded_down(min[axis]));
            bounds.max[axis] = bounds.max[axis].min(rounded_up(max[axis]));
        }
        (!bounds.is_empty()).then_some(bounds)
    }
}

/// The largest `f32` at or below `value`.
fn rounded_down(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) > value { nearest.next_down() } else { nearest }
}

/// The smallest `f32` at or above `value`.
fn rounded_up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn half_of_a_right_triangle() {
        // The hypotenuse of (0,0) (4,0) (0,4) is at height 3 where x = 1.
        let triangle = Triangle { vertices: [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0] };
        let mut region = triangle.bounds();
        region.min.x = 1.0;
        let right = triangle.clipped_bounds(&region).unwrap();
        assert_eq!(right.min, Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(right.max, Vec3::new(4.0, 3.0, 0.0));
    }

    #[test]
    fn nothing_is_left_outside() {
        let triangle = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        // Inside the triangle's box but beyond its hypotenuse.
        let corner = Aabb { min: Vec3::new(0.75, 0.75, 0.0), max: Vec3::new(1.0, 1.0, 0.0) };
        assert!(triangle.clipped_bounds(&corner).is_none());
    }

    #[test]
    fn halves_cover_random_triangles() {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for i in 0..10_000 {
            let scale = [1.0, 1.0e30, 1.0e-30][i % 3];
            let vertices = [0; 3].map(|_| Vec3::new(random(), random(), random()) * scale);
            let triangle = Triangle { vertices };
            let whole = triangle.bounds();
            let axis = i % 3;
            let plane = whole.center()[axis];
            let (mut low, mut high) = (whole, whole);
            low.max[axis] = plane;
            high.min[axis] = plane;
            let low = triangle.clipped_bounds(&low).unwrap();
            let high = triangle.clipped_bounds(&high).unwrap();
            assert_eq!(low.union(high), whole);
            // A point of the triangle lies in one of them, up to its own rounding.
            let (u, v) = (0.5 + 0.5 * random(), 0.5 + 0.5 * random());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = vertices[0] * (1.0 - u - v) + vertices[1] * u + vertices[2] * v;
            let slack = Vec3::splat(1.0e-6 * scale);
            let around = |b: &Aabb| (b.min - slack).cmple(point).all() && (b.max + slack).cmpge(point).all();
            assert!(around(&low) || around(&high));
        }
    }
}
