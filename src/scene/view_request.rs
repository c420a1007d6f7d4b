//! Requested placement and lens of the camera, on top of the selected one.

use glam::Vec3;

use super::{AnimationIndex, NodeIndex};

/// Requested placement and lens. Axes are those of glTF: +Y is up, and an asset's front faces +Z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewRequest {
    /// Direction from which the framed bounds are seen.
    pub orbit: Option<Orbit>,
    /// Position of the camera, metres.
    pub position: Option<Vec3>,
    /// Point that appears in the centre of the image.
    pub target: Option<Target>,
    /// Direction that points up in the image; need not be a unit vector.
    pub up: Option<Vec3>,
    /// Rotation about the viewing axis, degrees: counter-clockwise as seen from behind the camera.
    pub roll_degrees: f32,
    /// Projection that replaces the camera's own.
    pub lens: Option<LensRequest>,
    /// Node that is framed instead of the whole scene.
    pub node: Option<NodeIndex>,
    /// Clips over each of which, played alone, bounds are measured; empty for the selected ones together.
    pub measured_clips: Vec<AnimationIndex>,
    /// Turntable.
    pub turntable: Option<TurntableRequest>,
    /// Whether the selected camera of the file is kept where the request places a camera: its lens, and its position on a turntable.
    pub keeps_camera: bool,
}

/// Direction of view in angles around the framed bounds, and distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Degrees about the vertical axis: 0 is in front (+Z), 90 is on the side of +X.
    pub azimuth_degrees: f32,
    /// Degrees above the horizontal plane, from −90 to 90.
    pub elevation_degrees: f32,
    /// Multiple of the distance at which the bounds fit the image.
    pub distance: f32,
}

/// Point at which the camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Target {
    /// A point in world space, metres.
    Point(Vec3),
    /// Centre of a node's bounds over the whole animation.
    Node(NodeIndex),
}

/// Requested projection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LensRequest {
    /// Vertical field of view, degrees.
    FieldOfView(f32),
    /// Parallel projection, as high as the perspective view is at the centre of the bounds.
    Orthographic,
}

/// One turn of the camera around the framed bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurntableRequest {
    /// Elevation in degrees, where no orbit gives it.
    pub elevation_degrees: Option<f32>,
    /// Seconds of one turn.
    pub turn_seconds: f64,
}

impl Orbit {
    /// Seen from the right, slightly above: the default view.
    pub const THREE_QUARTER: Self = Self { azimuth_degrees: 30.0, elevation_degrees: 20.0, distance: 1.0 };
}

impl ViewRequest {
    /// Whether the request places a camera of its own.
    pub fn places_camera(&self) -> bool {
        self.orbit.is_some() || self.position.is_some() || self.node.is_some() || self.turntable.is_some()
    }

    /// Whether a camera of its own depends on what the scene shows. One from a position to a point does not.
    pub fn follows_subject(&self) -> bool {
        self.position.is_none() || !matches!(self.target, Some(Target::Point(_)))
    }

    /// Whether nothing of the camera of the file is used.
    pub fn replaces_camera(&self) -> bool {
        self.places_camera() && !self.keeps_camera
    }
}
