//! The lens of a picture: how large it is and what is in focus.

use glam::Vec2;

use super::RenderInput;
use crate::bvh::TraversalCounters;
use crate::frame::PosedCamera;
use crate::integrator::{CameraRays, Seed, ThinLens};
use crate::interaction::{PosedScene, alpha_at};
use crate::scene::{NodeIndex, Projection};

/// Half the height of the picture on 35 mm film, metres; f-numbers are of lenses for it.
const HALF_FILM_HEIGHT: f32 = 0.012;

/// A lens that does not show everything sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Its size.
    pub aperture: Aperture,
    /// What is sharp.
    pub focus: Focus,
}

/// How large a lens is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Its radius, metres.
    Radius(f32),
    /// The focal length over the diameter, for a picture 24 mm high. Perspective cameras only; others show everything sharp.
    FNumber(f32),
}

/// What is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// What lies so far in front of the camera, along its axis, metres.
    Metres(f32),
    /// What lies as far as the origin of this node at each time; at infinity where it is not in front of the camera.
    Node(NodeIndex),
    /// What is seen in the middle of the picture, at each time; at infinity where nothing is.
    Middle,
}

impl Lens {
    /// The lens at the frame's time; `None` where it has no size.
    pub(super) fn at(&self, input: &RenderInput<'_>, resolution: (u32, u32)) -> Option<ThinLens> {
        let camera = &input.frame.camera;
        let radius = self.aperture.radius(camera);
        (radius > 0.0).then(|| ThinLens { radius, focus_distance: self.focus.distance(input, resolution) })
    }
}

impl Aperture {
    fn radius(self, camera: &PosedCamera) -> f32 {
        match (self, camera.projection) {
            (Self::Radius(radius), _) => radius,
            (Self::FNumber(number), Projection::Perspective { fov_y_radians, .. }) => {
                let focal_length = HALF_FILM_HEIGHT / libm::tanf(fov_y_radians * 0.5);
                focal_length / (2.0 * number)
            }
            (Self::FNumber(_), Projection::Orthographic { .. }) => 0.0,
        }
    }
}

impl Focus {
    fn distance(self, input: &RenderInput<'_>, resolution: (u32, u32)) -> f32 {
        let camera = &input.frame.camera;
        let point = match self {
            Self::Metres(distance) => return distance,
            Self::Node(node) => input.frame.node_position(node),
            Self::Middle => {
                let middle = Vec2::new(resolution.0 as f32, resolution.1 as f32) * 0.5;
                let ray = CameraRays::new(camera, resolution, 0.0, None).ray(middle, Seed::default());
                let posed = PosedScene { scene: input.scene, frame: input.frame };
                let seen = |hit: &_| alpha_at(posed, hit) > 0.0;
                let hit = input.bvh.closest_hit(&ray, None, seen, &mut TraversalCounters::default());
                hit.map(|hit| ray.at(hit.t))
            }
        };
        let depth = point.map(|point| -camera.world_from_camera.inverse().transform_point3(point).z);
        depth.filter(|&depth| depth > 0.0).unwrap_or(f32::INFINITY)
    }
}
