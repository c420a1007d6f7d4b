//! Parts of triangles: halving all edges again and again divides a triangle into four, sixteen, … triangles of one shape.

use glam::{Vec2, Vec3};

/// How often edges are halved at most.
pub(super) const MOST_HALVINGS: u32 = 6;

/// Barycentric coordinates of the corners of a whole triangle: the weights of its second and third corner.
const WHOLE: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// A part of a triangle, or all of it. Parts are ordered by triangle, then by code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TrianglePart {
    pub(super) triangle: u32,
    /// The quarter in which the part lies, then the quarter of that, and so on: two bits each, the highest of `2 * MOST_HALVINGS` first.
    code: u16,
    /// How often the edges are halved.
    halvings: u8,
}

impl TrianglePart {
    /// All of a triangle.
    pub(super) fn whole(triangle: u32) -> Self {
        Self { triangle, code: 0, halvings: 0 }
    }

    /// The four parts of half the size: at each corner and in the middle.
    pub(super) fn quarters(self) -> [Self; 4] {
        debug_assert!(u32::from(self.halvings) < MOST_HALVINGS);
        let halvings = self.halvings + 1;
        let step = 1 << unused_bits(halvings);
        [0, 1, 2, 3].map(|quarter| Self { code: self.code + quarter * step, halvings, ..self })
    }

    /// Share of the area of the triangle.
    pub(super) fn area_share(self) -> f32 {
        1.0 / (1_u32 << (2 * self.halvings)) as f32
    }

    /// Barycentric coordinates of the corners, in the order of those of the triangle.
    pub(super) fn barycentrics(self) -> [Vec2; 3] {
        let mut corners = WHOLE;
        for halving in 1..=self.halvings {
            let [a, b, c] = corners;
            let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            corners = match self.code >> unused_bits(halving) & 3 {
                0 => [a, ab, ca],
                1 => [ab, b, bc],
                2 => [ca, bc, c],
                _ => [bc, ca, ab],
            };
        }
        corners
    }

    /// The corners in space, from those of the triangle.
    pub(super) fn corners(self, [a, b, c]: [Vec3; 3]) -> [Vec3; 3] {
        self.barycentrics().map(|at| a * (1.0 - at.x - at.y) + b * at.x + c * at.y)
    }

    /// Barycentric coordinates in the triangle of a point with the coordinates `at` in the part.
    pub(super) fn in_triangle(self, at: Vec2) -> Vec2 {
        let [a, b, c] = self.barycentrics();
        a * (1.0 - at.x - at.y) + b * at.x + c * at.y
    }

    /// The index of the part of `parts`, ascending and disjoint, in which a point of a triangle lies.
    pub(super) fn find(parts: &[Self], triangle: u32, at: Vec2) -> Option<usize> {
        let code = code_at(at);
        let index =
            parts.partition_point(|part| (part.triangle, part.code) <= (triangle, code)).checked_sub(1)?;
        let part = parts[index];
        let unused = unused_bits(part.halvings);
        (part.triangle == triangle && part.code >> unused == code >> unused).then_some(index)
    }
}

/// Low bits of the code of a part that tell its own parts apart.
fn unused_bits(halvings: u8) -> u32 {
    2 * (MOST_HALVINGS - u32::from(halvings))
}

/// The code of the smallest part in which a point lies.
fn code_at(at: Vec2) -> u16 {
    let mut weights = Vec3::new(1.0 - at.x - at.y, at.x, at.y);
    let mut code = 0;
    for _ in 0..MOST_HALVINGS {
        let quarter = weights.to_array().iter().position(|&weight| weight >= 0.5).unwrap_or(3);
        weights = match quarter {
            3 => Vec3::ONE - 2.0 * weights,
            corner => 2.0 * weights - Vec3::AXES[corner],
        };
        code = code << 2 | quarter as u16;
    }
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All parts of so many halvings.
    fn parts_of(triangle: u32, halvings: u32) -> Vec<TrianglePart> {
        let whole = vec![TrianglePart::whole(triangle)];
        (0..halvings).fold(whole, |parts, _| parts.into_iter().flat_map(TrianglePart::quarters).collect())
    }

    #[test]
    fn every_part_is_found_by_its_middle() {
        for halvings in 0..=MOST_HALVINGS {
            let mut parts = parts_of(3, halvings);
            assert!(parts.is_sorted(), "{halvings}");
            let area: f32 = parts.iter().map(|part| part.area_share()).sum();
            assert!((area - 1.0).abs() < 1e-6);
            parts.extend(parts_of(5, 0));
            for (index, part) in parts.iter().enumerate() {
                let middle = part.in_triangle(Vec2::splat(1.0 / 3.0));
                assert_eq!(TrianglePart::find(&parts, part.triangle, middle), Some(index), "{halvings}");
                assert_eq!(TrianglePart::find(&parts, 4, middle), None);
            }
        }
    }

    #[test]
    fn parts_keep_the_orientation_and_the_shape() {
        for part in parts_of(0, 3) {
            let [a, b, c] = part.barycentrics();
            let area = 0.5 * (b - a).perp_dot(c - a);
            assert!((area - 0.5 * part.area_share()).abs() < 1e-6, "{part:?}");
        }
    }

    #[test]
    fn points_of_missing_parts_are_not_found() {
        let [first, _, third, middle] = TrianglePart::whole(1).quarters();
        let parts = [&[first], &third.quarters()[1..], &[middle]].concat();
        let at = |part: TrianglePart| part.in_triangle(Vec2::splat(1.0 / 3.0));
        assert_eq!(TrianglePart::find(&parts, 1, Vec2::new(0.8, 0.1)), None);
        assert_eq!(TrianglePart::find(&parts, 1, at(third.quarters()[0])), None);
        assert_eq!(TrianglePart::find(&parts, 1, at(third.quarters()[3])), Some(3));
        assert_eq!(TrianglePart::find(&parts, 1, at(middle)), Some(4));
    }

    #[test]
    fn the_whole_is_exactly_its_triangle() {
        let corners = [Vec3::new(0.1, 0.7, 3.3), Vec3::new(-5.7, 0.3, 1e6), Vec3::new(7e-5, 0.0, 11.1)];
        let whole = TrianglePart::whole(0);
        assert_eq!(whole.corners(corners), corners);
        let at = Vec2::new(0.123_456_7, 0.765_432_1);
        assert_eq!(whole.in_triangle(at), at);
    }
}
