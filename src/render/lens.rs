//! The lens of a picture: how large it is and what is in focus.

use glam::Vec2;

use crate::bvh::TraversalCounters;
use crate::frame::PosedCamera;
use crate::integrator::{CameraRays, Seed, ThinLens};
use crate::interaction::alpha_at;
use crate::scene::{NodeIndex, Projection};
use crate::scene_view::SceneView;

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
    Center,
}

impl Lens {
    /// The lens at the frame's time; `None` where it has no size.
    pub(super) fn at(&self, view: &SceneView<'_>, resolution: (u32, u32)) -> Option<ThinLens> {
        let camera = &view.frame.camera;
        let radius = self.aperture.radius(camera);
        (radius > 0.0).then(|| ThinLens { radius, focus_distance: self.focus.distance(view, resolution) })
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
    fn distance(self, view: &SceneView<'_>, resolution: (u32, u32)) -> f32 {
        let camera = &view.frame.camera;
        let point = match self {
            Self::Metres(distance) => return distance,
            Self::Node(node) => view.frame.node_position(node),
            Self::Center => {
                let middle = Vec2::new(resolution.0 as f32, resolution.1 as f32) * 0.5;
                let ray = CameraRays::new(camera, resolution, 0.0, None).ray(middle, Seed::default());
                let seen = |hit: &_| alpha_at(*view, hit) > 0.0;
                let hit = view.bvh.closest_hit(&ray, None, seen, &mut TraversalCounters::default());
                hit.map(|hit| ray.at(hit.t))
            }
        };
        let depth = point.map(|point| -camera.world_from_camera.inverse().transform_point3(point).z);
        depth.filter(|&depth| depth > 0.0).unwrap_or(f32::INFINITY)
    }
}
