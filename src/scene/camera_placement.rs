//! Rotation and translation of cameras.

use glam::{Mat4, Vec3};

/// Camera at `position` with the axis `backward` and `up` in the image's upper half, or the nearest to it. Where both are
/// parallel, −Z is up from above, and +Z from below.
pub fn look_along(position: Vec3, backward: Vec3, up: Vec3) -> Mat4 {
    let unit = |vector: Vec3| vector.as_dvec3().try_normalize().map(glam::DVec3::as_vec3);
    let backward = unit(backward).unwrap_or(Vec3::Z);
    let right = unit(up)
        .and_then(|up| Some(up.cross(backward)).filter(|right| right.length_squared() > 1e-10))
        .unwrap_or_else(|| {
            let other = if up.dot(backward) > 0.0 { Vec3::NEG_Z } else { Vec3::Z };
            Some(other.cross(backward))
                .filter(|right| right.length_squared() > 1e-10)
                .unwrap_or_else(|| backward.any_orthonormal_vector())
        });
    let right = unit(right).unwrap_or(Vec3::X);
    let up = backward.cross(right);
    Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), position.extend(1.0))
}

/// The camera rotated about its axis.
pub fn rolled(camera: Mat4, radians: f32) -> Mat4 {
    if radians == 0.0 {
        return camera;
    }
    let (sine, cosine) = libm::sincosf(radians);
    let (right, up) = (camera.x_axis, camera.y_axis);
    Mat4::from_cols(right * cosine + up * sine, up * cosine - right * sine, camera.z_axis, camera.w_axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roll_turns_the_camera_counter_clockwise_from_behind() {
        let camera = rolled(Mat4::IDENTITY, std::f32::consts::FRAC_PI_2);
        assert!(camera.y_axis.truncate().abs_diff_eq(Vec3::NEG_X, 1e-6));
        assert!(camera.x_axis.truncate().abs_diff_eq(Vec3::Y, 1e-6));
    }
}
