//! Selected camera: a node's, a fixed one, or one on a turntable or a path.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DQuat, Mat4, Vec3};

use super::camera_placement::{look_along, rolled};
use super::{CameraPath, NodeIndex, Projection};

/// Selected camera.
#[derive(Clone, Debug, PartialEq)]
pub enum SelectedCamera {
    /// Automatic camera, until [`crate::framing::resolve_camera`] replaces it. Posed, it stands in the origin.
    Auto,
    /// The camera of this node.
    Node(NodeIndex),
    /// Static camera, such as a resolved automatic one.
    Fixed {
        /// Rotation and translation; columns are right, up, backward, position.
        world_from_camera: Mat4,
        /// The projection.
        projection: Projection,
    },
    /// Camera that turns about an axis.
    Turntable(Turntable),
    /// Camera that moves along a path.
    Path(Arc<CameraPath>),
}

/// Camera that turns about an axis at constant speed. Whole turns give the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turntable {
    /// The camera at time 0, as in [`SelectedCamera::Fixed`].
    pub start: Mat4,
    /// The projection.
    pub projection: Projection,
    /// A point on the axis, metres.
    pub center: Vec3,
    /// Unit vector. The camera turns counter-clockwise as seen from its tip.
    pub axis: Vec3,
    /// Seconds of one turn.
    pub turn_seconds: f64,
}

/// Changes to the camera of a node or a path. `None` keeps what that has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraChanges {
    /// Position, metres.
    pub position: Option<Vec3>,
    /// Point in the centre of the image.
    pub target: Option<Vec3>,
    /// Direction that points up in the image.
    pub up: Option<Vec3>,
    /// Rotation about the viewing axis, radians.
    pub roll_radians: f32,
    /// Projection, but for its near and far plane, which stay those of the camera.
    pub projection: Option<Projection>,
}

impl Turntable {
    /// The camera at `time_seconds`.
    pub fn at(&self, time_seconds: f64) -> Mat4 {
        // Steps of 2⁻³² of a turn make the rounding of times vanish: the frame after the last is the first.
        const STEPS: f64 = 4_294_967_296.0;
        let turns = time_seconds / self.turn_seconds;
        let step = ((turns - turns.floor()) * STEPS).round() % STEPS;
        if step == 0.0 {
            return self.start;
        }
        let (sine, cosine) = libm::sincos(step / STEPS * TAU * 0.5);
        let [x, y, z] = (self.axis.as_dvec3() * sine).to_array();
        let rotation = DQuat::from_xyzw(x, y, z, cosine);
        let rotated = |vector: Vec3| (rotation * vector.as_dvec3()).as_vec3();
        let position = self.center + rotated(self.start.w_axis.truncate() - self.center);
        Mat4::from_cols(
            rotated(self.start.x_axis.truncate()).extend(0.0),
            rotated(self.start.y_axis.truncate()).extend(0.0),
            rotated(self.start.z_axis.truncate()).extend(0.0),
            position.extend(1.0),
        )
    }
}

impl CameraChanges {
    /// The camera with the changes: a rotation and translation.
    pub fn apply(&self, world_from_camera: Mat4) -> Mat4 {
        let position = self.position.unwrap_or_else(|| world_from_camera.w_axis.truncate());
        let changed = match (self.target, self.up) {
            (None, None) => Mat4::from_cols(
                world_from_camera.x_axis,
                world_from_camera.y_axis,
                world_from_camera.z_axis,
                position.extend(1.0),
            ),
            (target, up) => {
                let backward = target.map_or(world_from_camera.z_axis.truncate(), |target| position - target);
                look_along(position, backward, up.unwrap_or(Vec3::Y))
            }
        };
        rolled(changed, self.roll_radians)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turntable() -> Turntable {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect_ratio: None, z_near: 0.0, z_far: None };
        let start = look_along(Vec3::new(1.0, 0.5, 4.0), Vec3::Z, Vec3::Y);
        Turntable { start, projection, center: Vec3::new(1.0, 0.0, 1.0), axis: Vec3::Y, turn_seconds: 2.0 }
    }

    #[test]
    fn a_turntable_goes_from_the_front_over_the_side_of_x_to_the_back() {
        let at = |seconds| turntable().at(seconds);
        assert!(at(0.5).w_axis.truncate().abs_diff_eq(Vec3::new(4.0, 0.5, 1.0), 1e-6));
        assert!(at(0.5).z_axis.truncate().abs_diff_eq(Vec3::X, 1e-6));
        assert!(at(1.0).w_axis.truncate().abs_diff_eq(Vec3::new(1.0, 0.5, -2.0), 1e-6));
    }

    #[test]
    fn whole_turns_have_the_same_bits() {
        for frames in [7_i64, 48, 1000] {
            let turntable = Turntable { turn_seconds: frames as f64 / 24.0, ..turntable() };
            for frame in 0..frames {
                let at = |frame: i64| turntable.at(frame as f64 / 24.0);
                assert_eq!(at(frame), at(frame + frames), "{frame} of {frames}");
                assert_eq!(at(frame), at(frame - 3 * frames), "{frame} of {frames}");
            }
        }
    }

    #[test]
    fn cameras_look_at_their_targets() {
        let changes = CameraChanges { target: Some(Vec3::ZERO), ..CameraChanges::default() };
        let camera = changes.apply(Mat4::from_translation(Vec3::new(5.0, 0.0, 0.0)));
        assert_eq!(camera.z_axis.truncate(), Vec3::X);
        assert_eq!(camera.x_axis.truncate(), Vec3::NEG_Z);
        // From above, the top of the image is the far side.
        let camera = changes.apply(Mat4::from_translation(Vec3::new(0.0, 5.0, 0.0)));
        assert_eq!((camera.x_axis.truncate(), camera.y_axis.truncate()), (Vec3::X, Vec3::NEG_Z));
        let camera = changes.apply(Mat4::from_translation(Vec3::new(0.0, -5.0, 0.0)));
        assert_eq!((camera.x_axis.truncate(), camera.y_axis.truncate()), (Vec3::X, Vec3::Z));
    }
}
