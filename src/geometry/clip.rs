//! Triangle clipping by axis-aligned planes, for the parts of split triangles that refitting follows. Early split clipping itself needs only the
//! boxes of parts; this is the reference implementation of these.
//!
//! Source: Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, computed in `f64`. The box of a part is
//! rounded outward to `f32`. Each cut moves corners by about 2⁻⁵³ of the triangle's largest coordinate, far less than
//! [`super::BOX_PADDING`].

use super::{Aabb, Triangle};

/// Limit of a part's corners. A triangle clipped by the six planes of a box has at most nine. Rounding may bend a side and add
/// coincident ones.
const MAX_CORNERS: usize = 16;

/// Part of a triangle that remains after cuts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClippedTriangle {
    polygon: Polygon,
    bounds: Aabb,
}

#[derive(Clone, Copy, Debug)]
struct Polygon {
    corners: [[f64; 3]; MAX_CORNERS],
    len: usize,
}

impl ClippedTriangle {
    /// The whole triangle.
    pub(crate) fn whole(triangle: &Triangle) -> Self {
        let mut polygon = Polygon::EMPTY;
        for vertex in &triangle.vertices {
            polygon.push(vertex.to_array().map(f64::from));
        }
        Self { polygon, bounds: triangle.bounds() }
    }

    /// Bounding box of the part.
    pub(crate) fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Corners of the part in order.
    pub(crate) fn corners(&self) -> &[[f64; 3]] {
        &self.polygon.corners[..self.polygon.len]
    }

    /// Splits at the coordinate `plane` of `axis`, which lies inside the bounds. Returns the parts below and above it; each lies
    /// inside its half of the bounds.
    pub(crate) fn cut(&self, axis: usize, plane: f32) -> [Option<Self>; 2] {
        let (mut low, mut high) = (self.bounds, self.bounds);
        low.max[axis] = plane;
        high.min[axis] = plane;
        let [below, above] = self.polygon.cut(axis, f64::from(plane));
        [below.within(&low), above.within(&high)]
    }
}

impl Polygon {
    const EMPTY: Self = Self { corners: [[0.0; 3]; MAX_CORNERS], len: 0 };

    /// Splits at a plane. Corners on the plane belong to both parts.
    fn cut(&self, axis: usize, plane: f64) -> [Self; 2] {
        let [mut below, mut above] = [Self::EMPTY; 2];
        for i in 0..self.len {
            let from = &self.corners[i];
            let to = &self.corners[if i + 1 == self.len { 0 } else { i + 1 }];
            let from_height = from[axis] - plane;
            let to_height = to[axis] - plane;
            if from_height <= 0.0 {
                below.push(*from);
            }
            if from_height >= 0.0 {
                above.push(*from);
            }
            if (from_height > 0.0 && to_height < 0.0) || (from_height < 0.0 && to_height > 0.0) {
                let s = from_height / (from_height - to_height);
                let mut corner = [0.0; 3];
                for k in 0..3 {
                    corner[k] = from[k] + (to[k] - from[k]) * s;
                }
                corner[axis] = plane;
                below.push(corner);
                above.push(corner);
            }
        }
        [below, above]
    }

    fn push(&mut self, corner: [f64; 3]) {
        debug_assert!(self.len < MAX_CORNERS);
        if self.len < MAX_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The part with its box, rounded outward but clamped to `region`; `None` for an empty part.
    fn within(self, region: &Aabb) -> Option<ClippedTriangle> {
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
        (!bounds.is_empty()).then_some(ClippedTriangle { polygon: self, bounds })
    }
}

/// The largest `f32` at or below `value`.
pub(crate) fn rounded_down(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) > value { nearest.next_down() } else { nearest }
}

/// The smallest `f32` at or above `value`.
pub(crate) fn rounded_up(value: f64) -> f32 {
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
        let [left, right] = ClippedTriangle::whole(&triangle).cut(0, 1.0).map(Option::unwrap);
        assert_eq!(left.bounds().min, Vec3::ZERO);
        assert_eq!(left.bounds().max, Vec3::new(1.0, 4.0, 0.0));
        assert_eq!(right.bounds().min, Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(right.bounds().max, Vec3::new(4.0, 3.0, 0.0));
        // The lower right quarter is a triangle again: (1,0) (4,0) (3,1) (1,1).
        let [low, high] = right.cut(1, 1.0).map(Option::unwrap);
        assert_eq!(low.bounds().max, Vec3::new(4.0, 1.0, 0.0));
        assert_eq!(high.bounds().max, Vec3::new(3.0, 3.0, 0.0));
    }

    #[test]
    fn parts_cover_random_triangles() {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for i in 0..3000 {
            let scale = [1.0, 1.0e30, 1.0e-30][i % 3];
            let vertices = [0; 3].map(|_| Vec3::new(random(), random(), random()) * scale);
            let triangle = Triangle { vertices };
            // Cut all parts four times, at the centre and off it.
            let mut parts = vec![ClippedTriangle::whole(&triangle)];
            for round in 0..4 {
                let axis = (i + round) % 3;
                let s = if round == 1 { 0.9 } else { 0.5 };
                parts = parts
                    .iter()
                    .flat_map(|part| {
                        let b = part.bounds();
                        part.cut(axis, b.min[axis] * s + b.max[axis] * (1.0 - s))
                    })
                    .flatten()
                    .collect();
            }
            let all = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(*part.bounds()));
            assert_eq!(all, triangle.bounds());
            assert!(parts.len() > 3 && parts.iter().all(|part| part.polygon.len <= 9));
            // A point of the triangle lies in one of the parts, up to its own rounding.
            let (u, v) = (0.5 + 0.5 * random(), 0.5 + 0.5 * random());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = vertices[0] * (1.0 - u - v) + vertices[1] * u + vertices[2] * v;
            let slack = 1.0e-6 * scale;
            assert!(
                parts.iter().any(|part| part.bounds().grown(slack).contains(&Aabb::from_points(&[point])))
            );
        }
    }
}
