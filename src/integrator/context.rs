//! One frame prepared for an integrator: the view, its lights and its volumes.

use super::interiors::Interiors;
use super::lights::{self, PreparedLight};
use super::media::{MediaStack, Medium};
use super::opaque_materials::is_opaque;
use super::settings::IntegratorSettings;
use crate::color::luminance;
use crate::geometry::{Aabb, Ray};
use crate::interaction::is_constant;
use crate::scene::Projection;
use crate::scene_view::SceneView;

/// Everything that light interacts with in one frame.
#[derive(Clone, Debug)]
pub struct IntegratorContext<'a> {
    /// Surfaces, hierarchy and environment.
    pub view: SceneView<'a>,
    /// The frame's lights, scaled, then the environment's key light.
    pub(super) lights: Vec<PreparedLight>,
    /// Interiors of the frame's volumes.
    pub(super) interiors: Interiors,
    /// Whether blocks can shade a material, by its index.
    pub(super) opaque_materials: Vec<bool>,
    /// Whether a material has the same values at all points without vertex colours, by its index.
    pub(super) constant_materials: Vec<bool>,
    /// Bounds of the surfaces of all volumes.
    volume_bounds: Aabb,
    /// The volumes that contain the camera, outermost first.
    camera_media: Vec<Medium>,
    /// Luminance of the environment's irradiance on the ground.
    pub(super) ground_irradiance: f32,
    /// Settings.
    pub settings: IntegratorSettings,
}

impl<'a> IntegratorContext<'a> {
    /// Prepares lights and volumes, and finds the volumes that contain the camera.
    pub fn new(view: SceneView<'a>, settings: IntegratorSettings) -> Self {
        let camera_position = view.frame.camera.world_from_camera.w_axis.truncate();
        let interiors = Interiors::of(&view.frame.materials);
        let volume_bounds = interiors.bounds(view.frame);
        let camera_media = interiors.media_around(view, &volume_bounds, camera_position);
        let lights = lights::gather(view.frame, view.environment, &settings);
        let on_ground = settings.ground.map(|ground| view.environment.irradiance(ground.up));
        let ground_irradiance = on_ground.map_or(0.0, luminance);
        let opaque_materials = view.frame.materials.iter().map(is_opaque).collect();
        Self {
            view,
            lights,
            interiors,
            opaque_materials,
            constant_materials: view.frame.materials.iter().map(is_constant).collect(),
            volume_bounds,
            camera_media,
            ground_irradiance,
            settings,
        }
    }

    /// The volumes in which all camera rays start; `None` where they are found for each ray.
    pub(super) fn camera_media(&self) -> Option<MediaStack> {
        match self.view.frame.camera.projection {
            Projection::Perspective { .. } => Some(MediaStack::new(&self.camera_media)),
            Projection::Orthographic { .. } => self.volume_bounds.is_empty().then(MediaStack::default),
        }
    }

    /// The volumes in which a camera ray starts. Perspective rays start in those around the camera; for orthographic rays they
    /// are found for each start.
    pub(super) fn media_around_start(&self, ray: &Ray) -> MediaStack {
        match self.view.frame.camera.projection {
            Projection::Perspective { .. } => MediaStack::new(&self.camera_media),
            Projection::Orthographic { .. } => {
                let start = ray.at(ray.t_min);
                MediaStack::new(&self.interiors.media_around(self.view, &self.volume_bounds, start))
            }
        }
    }
}
