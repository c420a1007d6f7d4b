//! The axes by which cells tell normals apart.

use glam::Vec3;

/// Two for each dimension.
pub(super) const AXES: usize = 6;

/// The number of the axis that is nearest to a normal.
pub(super) fn nearest_axis(normal: Vec3) -> usize {
    let dimension = normal.abs().max_position();
    2 * dimension + usize::from(normal[dimension] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_has_its_number() {
        let axes = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
        for (number, axis) in axes.enumerate() {
            assert_eq!(nearest_axis(axis), number);
            assert_eq!(nearest_axis(axis + Vec3::new(0.3, -0.2, 0.1)), number);
        }
        // The first of equal ones
        assert_eq!(nearest_axis(Vec3::splat(-1.0)), 1);
    }
}
