//! Lens settings of a camera: aperture and focus.

use glam::Vec2;

use crate::bvh::TraversalCounters;
use crate::frame::PosedCamera;
use crate::integrator::{CameraRays, Seed, ThinLens};
use crate::interaction::alpha_at;
use crate::scene::{NodeIndex, Projection};
use crate::scene_view::SceneView;

/// Half the image height on 35 mm film, metres. F-numbers refer to this format.
const HALF_FILM_HEIGHT: f32 = 0.012;

/// A lens with a finite depth of field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Size of the lens.
    pub aperture: Aperture,
    /// Focus distance.
    pub focus: Focus,
}

/// Size of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Radius, metres.
    Radius(f32),
    /// Focal length over diameter, where the height of the image is 24 mm on film. Orthographic cameras ignore it and have everything in focus.
    FNumber(f32),
}

/// The focus distance of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// A fixed distance along the camera's axis, metres.
    Metres(f32),
    /// The distance of the middle of what this node and those below it show at each time, or of its origin; infinity where that is not in front
    /// of the camera.
    Node(NodeIndex),
    /// The distance of the surface in the image centre at each time; infinity where there is none.
    Center,
}

impl Lens {
    /// The lens at the frame's time; `None` where its radius is 0.
    pub(super) fn at(&self, view: &SceneView<'_>, resolution: (u32, u32)) -> Option<ThinLens> {
        let camera = &view.frame.camera;
        let radius = self.aperture.radius(camera, resolution.0 as f32 / resolution.1 as f32);
        (radius > 0.0).then(|| ThinLens { radius, focus_distance: self.focus.distance(view, resolution) })
    }
}

impl Aperture {
    fn radius(self, camera: &PosedCamera, aspect_ratio: f32) -> f32 {
        match (self, camera.projection) {
            (Self::Radius(radius), _) => radius,
            (Self::FNumber(number), projection @ Projection::Perspective { .. }) => {
                let focal_length = HALF_FILM_HEIGHT / projection.half_size(aspect_ratio).y;
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
            Self::Node(node) => view.frame.node_center(view.scene, node),
            Self::Center => {
                let center = Vec2::new(resolution.0 as f32, resolution.1 as f32) * 0.5;
                let ray = CameraRays::new(camera, resolution, 0.0, None).ray(center, Seed::default());
                let is_visible = |hit: &_| alpha_at(*view, hit) > 0.0;
                let hit = view.bvh.closest_hit(&ray, None, is_visible, &mut TraversalCounters::default());
                hit.map(|hit| ray.at(hit.t))
            }
        };
        let depth = point.map(|point| -camera.world_from_camera.inverse().transform_point3(point).z);
        depth.filter(|&depth| depth > 0.0).unwrap_or(f32::INFINITY)
    }
}
