//! Directions of view: angles around the vertical axis, and their names.

use glam::{Mat3, Mat4, Quat, Vec3};

use crate::scene::{Orbit, rolled};

/// Views with a name. The front of a glTF asset faces +Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NamedView {
    /// From +Z.
    Front,
    /// From −Z.
    Back,
    /// From −X.
    Left,
    /// From +X.
    Right,
    /// From above; the front is at the bottom of the image.
    Top,
    /// From below; the front is at the top of the image.
    Bottom,
    /// From the right, slightly above.
    ThreeQuarter,
    /// The same from the other side.
    ThreeQuarterBack,
}

impl NamedView {
    /// Its angles.
    pub fn orbit(self) -> Orbit {
        let (azimuth_degrees, elevation_degrees) = match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Left => (-90.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
            Self::ThreeQuarter => return Orbit::THREE_QUARTER,
            Self::ThreeQuarterBack => {
                let azimuth_degrees = Orbit::THREE_QUARTER.azimuth_degrees + 180.0;
                return Orbit { azimuth_degrees, ..Orbit::THREE_QUARTER };
            }
        };
        Orbit { azimuth_degrees, elevation_degrees, distance: 1.0 }
    }
}

/// A direction of view, and how the image is turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    pub(super) orbit: Orbit,
    /// The vertical axis, a unit vector.
    pub(super) up: Vec3,
    /// Rotation about the camera's axis.
    pub(super) roll_radians: f32,
}

impl Direction {
    /// Right, up and backward of a camera that looks from here.
    pub(super) fn axes(&self) -> Mat3 {
        let unrolled = Mat4::from_mat3(axes(&self.orbit, self.up));
        Mat3::from_mat4(rolled(unrolled, self.roll_radians))
    }

    /// The direction after a turn around the vertical axis.
    pub(super) fn turned(&self, degrees: f32) -> Self {
        let azimuth_degrees = self.orbit.azimuth_degrees + degrees;
        Self { orbit: Orbit { azimuth_degrees, ..self.orbit }, ..*self }
    }
}

/// Right, up and backward of a camera that looks from the direction of `orbit`, where `up` is the vertical axis.
fn axes(orbit: &Orbit, up: Vec3) -> Mat3 {
    let (sin_azimuth, cos_azimuth) = sine_and_cosine(orbit.azimuth_degrees);
    let (sin_elevation, cos_elevation) = sine_and_cosine(orbit.elevation_degrees);
    let right = Vec3::new(cos_azimuth, 0.0, -sin_azimuth);
    let backward = Vec3::new(sin_azimuth * cos_elevation, sin_elevation, cos_azimuth * cos_elevation);
    let axes = Mat3::from_cols(right, backward.cross(right), backward);
    if up == Vec3::Y { axes } else { Mat3::from_quat(Quat::from_rotation_arc(Vec3::Y, up)) * axes }
}

/// Exact at multiples of 90 degrees.
fn sine_and_cosine(degrees: f32) -> (f32, f32) {
    let turned = f64::from(degrees).rem_euclid(360.0);
    let (sine, cosine) = match turned {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => libm::sincos(turned.to_radians()),
    };
    (sine as f32, cosine as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_views_have_the_axes_of_their_side() {
        let axes = |view: NamedView| axes(&view.orbit(), Vec3::Y);
        let is = |view, right: Vec3, up: Vec3| {
            let found = axes(view);
            assert_eq!((found.x_axis, found.y_axis), (right, up), "{view:?}");
        };
        is(NamedView::Front, Vec3::X, Vec3::Y);
        is(NamedView::Back, Vec3::NEG_X, Vec3::Y);
        is(NamedView::Right, Vec3::NEG_Z, Vec3::Y);
        is(NamedView::Left, Vec3::Z, Vec3::Y);
        is(NamedView::Top, Vec3::X, Vec3::NEG_Z);
        is(NamedView::Bottom, Vec3::X, Vec3::Z);
    }

    #[test]
    fn an_orbit_is_a_direction_on_the_sphere() {
        let orbit = Orbit { azimuth_degrees: 30.0, elevation_degrees: 60.0, distance: 1.0 };
        // sin 30° cos 60°, sin 60°, cos 30° cos 60°.
        let expected = Vec3::new(0.25, 0.866_025, 0.433_013);
        assert!(axes(&orbit, Vec3::Y).z_axis.abs_diff_eq(expected, 1e-6));
        assert!((axes(&orbit, Vec3::Y).determinant() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn with_z_up_the_front_faces_negative_y() {
        let found = axes(&NamedView::Front.orbit(), Vec3::Z);
        assert!(found.z_axis.abs_diff_eq(Vec3::NEG_Y, 1e-6) && found.y_axis.abs_diff_eq(Vec3::Z, 1e-6));
    }
}
