//! Octahedral images: radiance on a square grid of directions, for lookups without trigonometry.
//!
//! Source: Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors" (JCGT 2014), section 3.1. The
//! upper half of the sphere fills the inner diamond. Texels lie on the nodes of the grid, its border included, so that directions
//! on both sides of a fold have the same value and need no border texels.

use std::ops::{Add, Mul, Sub};

use glam::{Vec2, Vec3, Vec4};

use crate::geometry::{LANES, Vec2Lanes, Vec3Lanes};

/// Values on a square grid of directions: radiance and a zero, so that a node is one load, or one number a node.
#[derive(Debug)]
pub(super) struct OctahedralImage<T = Vec4> {
    /// Cells an edge, one less than nodes.
    cells: usize,
    nodes: Vec<T>,
}

impl OctahedralImage {
    /// An image of `value` in each node's direction. `cells` must be even and positive.
    pub(super) fn new(cells: usize, value: impl Fn(Vec3) -> Vec3) -> Self {
        Self { cells, nodes: node_directions(cells).map(|direction| value(direction).extend(0.0)).collect() }
    }

    /// Bilinear interpolation between the nodes around a direction.
    #[inline]
    pub(super) fn bilinear(&self, direction: Vec3) -> Vec3 {
        self.at(uv_from_direction(direction))
    }

    /// Bilinear interpolation between the nodes around a position in the unit square.
    #[inline(always)]
    pub(super) fn at(&self, uv: Vec2) -> Vec3 {
        self.interpolated(uv).truncate()
    }
}

impl OctahedralImage<f32> {
    /// An image of the numbers in the [`node_directions`]. `cells` must be even and positive.
    pub(super) fn of_numbers(cells: usize, nodes: Vec<f32>) -> Self {
        debug_assert_eq!(nodes.len(), (cells + 1) * (cells + 1));
        Self { cells, nodes }
    }

    /// Bilinear interpolation between the nodes around a position in the unit square.
    #[inline(always)]
    pub(super) fn number_at(&self, uv: Vec2) -> f32 {
        self.interpolated(uv)
    }

    /// The largest number.
    pub(super) fn largest(&self) -> f32 {
        self.nodes.iter().copied().fold(0.0, f32::max)
    }
}

impl<T> OctahedralImage<T>
where
    T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    #[inline(always)]
    fn interpolated(&self, uv: Vec2) -> T {
        let position = uv * self.cells as f32;
        let inside = |position: f32| (position as i32 as usize).min(self.cells - 1);
        let (column, row) = (inside(position.x), inside(position.y));
        let (right_share, bottom_share) = (position.x - column as f32, position.y - row as f32);
        let side = self.cells + 1;
        let node = row * side + column;
        let (Some([a, b]), Some([c, d])) =
            (self.nodes.get(node..node + 2), self.nodes.get(node + side..node + side + 2))
        else {
            return T::default();
        };
        let top = *a + (*b - *a) * right_share;
        let bottom = *c + (*d - *c) * right_share;
        top + (bottom - top) * bottom_share
    }
}

/// The directions of all nodes, row by row.
pub(super) fn node_directions(cells: usize) -> impl Iterator<Item = Vec3> {
    let side = cells + 1;
    let position = move |index: usize| index as f32 / cells as f32 * 2.0 - 1.0;
    (0..side * side).map(move |node| direction_of(position(node % side), position(node / side)))
}

/// Positions of directions in the unit square, as [`OctahedralImage::at`] takes them.
#[inline(always)]
pub(super) fn uvs_from_directions(directions: &Vec3Lanes, uvs: &mut Vec2Lanes) {
    for lane in 0..LANES {
        uvs.set(lane, uv_from_direction(directions.get(lane)));
    }
}

/// Position in the unit square of a direction.
#[inline(always)]
pub(super) fn uv_from_direction(direction: Vec3) -> Vec2 {
    let (right, down) = position_of(direction);
    Vec2::new((right + 1.0) * 0.5, (down + 1.0) * 0.5)
}

/// Position in the square from −1 to 1 of a direction.
#[inline(always)]
fn position_of(direction: Vec3) -> (f32, f32) {
    let Vec3 { x, y, z } = direction;
    let sum = x.abs() + y.abs() + z.abs();
    let (right, down) = (x / sum, z / sum);
    let below = folded(right, down);
    if y >= 0.0 { (right, down) } else { below }
}

/// Unit vector of a position in the square from −1 to 1.
#[inline(always)]
fn direction_of(right: f32, down: f32) -> Vec3 {
    let height = 1.0 - right.abs() - down.abs();
    let (x, z) = if height >= 0.0 { (right, down) } else { folded(right, down) };
    Vec3::new(x, height, z).normalize()
}

/// Unit vector of a position in the unit square.
#[inline(always)]
pub(super) fn direction_from_uv(uv: Vec2) -> Vec3 {
    direction_of(uv.x * 2.0 - 1.0, uv.y * 2.0 - 1.0)
}

/// Reflects a position at the side of the diamond nearest to it.
#[inline(always)]
fn folded(right: f32, down: f32) -> (f32, f32) {
    let sign = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    ((1.0 - down.abs()) * sign(right), (1.0 - right.abs()) * sign(down))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..500).map(|index| {
            let height = 1.0 - 2.0 * (index as f32 + 0.5) / 500.0;
            let (sin_azimuth, cos_azimuth) = libm::sincosf(index as f32 * 2.4);
            let sine = (1.0 - height * height).sqrt();
            Vec3::new(sine * cos_azimuth, height, sine * sin_azimuth)
        })
    }

    #[test]
    fn positions_and_directions_are_inverse() {
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for direction in directions().chain(axes) {
            let (right, down) = position_of(direction);
            assert!(right.abs() <= 1.0 && down.abs() <= 1.0);
            assert!((direction_of(right, down) - direction).length() < 1e-6, "{direction}");
        }
    }

    #[test]
    fn lookups_interpolate_without_seams() {
        let image = OctahedralImage::new(32, |d| Vec3::ONE + d);
        for direction in directions() {
            let found = image.bilinear(direction);
            assert!((found - Vec3::ONE - direction).abs().max_element() < 0.02, "{direction}: {found}");
        }
        // Both sides of each fold of the lower half.
        for (x, z) in [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)] {
            for side in [1e-5, -1e-5] {
                let beside = Vec3::new(x + z * side, -0.5, z - x * side).normalize();
                let on = Vec3::new(x, -0.5, z).normalize();
                assert!((image.bilinear(beside) - image.bilinear(on)).length() < 1e-3, "{beside}");
            }
        }
    }
}
