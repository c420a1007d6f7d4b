//! Rotations of nodes, instances and image-based lights: quaternions of any length but zero.

use glam::{DQuat, Quat};

/// Lengths up to this one count as zero.
pub(super) const ZERO_LENGTH: f32 = 1e-12;

/// The finite quaternion `rotation` at unit length, and the length that it had. `None` for one of length zero.
pub(super) fn unit_rotation(rotation: [f32; 4]) -> Option<(Quat, f64)> {
    // Squares of floats neither overflow nor vanish as doubles.
    let quaternion = DQuat::from_array(rotation.map(f64::from));
    let length = quaternion.length();
    if length <= f64::from(ZERO_LENGTH) {
        return None;
    }
    // Ordinary ones as floats, as always.
    let unit =
        if length > 1e15 { quaternion.normalize().as_quat() } else { quaternion.as_quat().normalize() };
    Some((unit, length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternions_of_all_lengths_but_zero_are_rotations() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for length in [1e-11, 1e-3, 1.0, 1e20, f32::MAX] {
            let (unit, found) = unit_rotation([0.0, length, 0.0, length]).unwrap();
            assert!(unit.abs_diff_eq(Quat::from_xyzw(0.0, half, 0.0, half), 1e-6), "{length}: {unit}");
            assert!(
                (found / (f64::from(length) * std::f64::consts::SQRT_2) - 1.0).abs() < 1e-6,
                "{length}: {found}"
            );
        }
        assert_eq!(unit_rotation([0.0; 4]), None);
        assert_eq!(unit_rotation([1e-13, 0.0, 0.0, 0.0]), None);
    }
}
