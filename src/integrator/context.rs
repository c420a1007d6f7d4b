//! One frame prepared for an integrator: the view, its lights and its volumes.

use super::glass_passage::GlassPassage;
use super::interiors::Interiors;
use super::lights::{self, PreparedLight};
use super::media::{MediaStack, Medium};
use super::opaque_materials::{OpaqueAlbedos, is_opaque};
use super::path::HittableLights;
use super::random::hash;
use super::settings::{Integrator, IntegratorSettings, PathSettings};
use super::zsobol::ZSobol;
use crate::color::luminance;
use crate::frame::Frame;
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
    pub(super) opaque_albedos: OpaqueAlbedos,
    /// Whether a material has the same values at all points without vertex colours, by its index.
    pub(super) constant_materials: Vec<bool>,
    /// Bounds of the surfaces of all volumes.
    volume_bounds: Aabb,
    /// The volumes that contain the camera, outermost first.
    camera_media: Vec<Medium>,
    /// Lights that rays can hit, for [`Integrator::Path`].
    pub(super) hittable_lights: Option<HittableLights>,
    /// Sample points of paths.
    pub(super) path_points: Option<ZSobol>,
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
        let is_path = settings.integrator == Integrator::Path;
        // Paths find the light of the environment on the ground by shadow rays.
        let on_ground =
            settings.ground.filter(|_| !is_path).map(|ground| view.environment.irradiance(ground.up));
        let ground_irradiance = on_ground.map_or(0.0, luminance);
        let opaque_materials = view.frame.materials.iter().map(is_opaque).collect();
        let opaque_albedos = OpaqueAlbedos::of(&view.frame.materials);
        Self {
            view,
            lights,
            interiors,
            opaque_materials,
            opaque_albedos,
            constant_materials: view.frame.materials.iter().map(is_constant).collect(),
            volume_bounds,
            camera_media,
            hittable_lights: is_path.then(|| HittableLights::new(view)),
            path_points: is_path.then(|| path_points(view.frame, &settings)),
            ground_irradiance,
            settings,
        }
    }

    /// Kinds of shadow rays, by how light passes glass: one kind for each light, then for paths one to the environment and one to emissive
    /// triangles.
    pub(super) fn shadow_passages(&self) -> Vec<GlassPassage> {
        let mut passages = vec![GlassPassage::Straight; self.lights.len()];
        if self.hittable_lights.is_some() {
            passages.extend([GlassPassage::ThinWalls; 2]);
        }
        passages
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

/// The sample points of a frame's paths.
fn path_points(frame: &Frame, settings: &IntegratorSettings) -> ZSobol {
    let PathSettings { seed, seed_per_frame, .. } = settings.path;
    let time = if seed_per_frame { frame.time_seconds.to_bits() } else { 0 };
    ZSobol::new(settings.max_samples, seed ^ hash(hash(time as u32) ^ (time >> 32) as u32))
}
