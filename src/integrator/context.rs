//! One frame prepared for an integrator: the view, its lights and its volumes.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::environment_directions::EnvironmentDirections;
use super::glass_passage::GlassPassage;
use super::interiors::Interiors;
use super::interreflections::Interreflections;
use super::lights::PreparedLight;
use super::lookup_environment::LookupEnvironment;
use super::media::{MediaStack, Medium, VolumeId};
use super::occluders::OccluderBox;
use super::opaque_materials::OpaqueAlbedos;
use super::path::{EmissiveTriangles, PathGuide, VisibleEntry, VisibleEnvironment};
use super::settings::{EnvSamples, IntegratorSettings};
use super::zsobol::ZSobol;
use crate::geometry::{Aabb, DirectionSample, Ray};
use crate::scene::{KeyLight, Projection};
use crate::scene_view::SceneView;

/// Everything that light interacts with in one frame.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each says what shading may leave out")]
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
    /// Whether a surface may let a part of the light pass.
    pub(super) may_dim_light: bool,
    /// Whether a material has the same values at all points without vertex colours, by its index.
    pub(super) constant_materials: Vec<bool>,
    /// Bounds of the surfaces of all volumes.
    pub(super) volume_bounds: Aabb,
    /// The volumes that contain the camera, outermost first.
    pub(super) camera_media: Vec<Medium>,
    /// The volumes that lamps are in, by light; none for distant lights.
    pub(super) lamp_volumes: Vec<Option<VolumeId>>,
    /// For [`Integrator::Path`].
    pub(super) emissive_triangles: Option<EmissiveTriangles>,
    /// Directions of the shadow rays to the environment from the surfaces of [`Integrator::Whitted`], and from shadow catchers and the ground; `None` where its
    /// light is not occluded.
    pub(super) environment_directions: Option<EnvironmentDirections>,
    /// What can cast shadows on shadow catchers and the ground, where there are any.
    pub(super) occluders: Option<OccluderBox>,
    /// The environment's peaks as lights of shadow catchers and the ground, where they are not among all lights.
    pub(super) receiver_peaks: Vec<PreparedLight>,
    /// Whether shadow rays of paths sample the environment by its radiance.
    pub(super) samples_environment: bool,
    /// For [`Integrator::Path`], where walls hide most of the environment.
    pub(super) visible_environment: Option<Arc<VisibleEnvironment<'a>>>,
    /// For [`Integrator::Path`], where smooth surfaces focus the light of emissive triangles.
    pub(super) path_guide: Option<Arc<PathGuide>>,
    /// The environment that the surfaces of [`Integrator::Whitted`] look up.
    pub(super) lookups: LookupEnvironment<'a>,
    /// Share of the light of `lookups` that shadow rays decide about.
    pub(super) occluded_share: f32,
    /// Share of the samples whose lookups send these rays.
    pub(super) traced_samples: f32,
    /// Share of what the occluders of those rays reflect for which the occluders are found; the rest is estimated without.
    pub(super) bounce_share: f32,
    /// Sample points of paths, of shadow rays to the environment and of rays that follow rough lobes.
    pub(super) sample_points: Option<ZSobol>,
    /// Whether the seed of any ray state decides about its light.
    pub(super) uses_seeds: bool,
    /// The environment's peaks, which lookups of Whitted's tree do not contain.
    pub(super) peaks: Vec<KeyLight>,
    /// Mean radiance of `lookups`, where shadow rays decide about their light.
    pub(super) mean_radiance: Vec3,
    /// Light of occluders whose shadow rays are stopped, where these are lit.
    pub(super) interreflections: Option<Interreflections>,
    /// Luminance of the environment's irradiance on the ground that no shadow rays decide about.
    pub(super) ground_irradiance: f32,
    /// Whether anything only receives shadows: shadow catchers and the ground.
    pub(super) has_receivers: bool,
    /// Settings.
    pub settings: IntegratorSettings,
}

impl IntegratorContext<'_> {
    /// Kinds of shadow rays, by how light passes glass: one kind for each light, then one to the environment, then for paths one to
    /// emissive triangles.
    pub(super) fn shadow_passages(&self) -> Vec<GlassPassage> {
        let mut passages = vec![GlassPassage::Straight; self.lights.len()];
        if self.emissive_triangles.is_some() {
            passages.extend([GlassPassage::ThinWalls; 2]);
        } else if self.environment_directions.is_some() {
            passages.push(GlassPassage::Straight);
        }
        passages
    }

    /// The lights of shadow catchers and the ground.
    pub(super) fn receiver_lights(&self) -> impl Iterator<Item = &PreparedLight> {
        self.lights.iter().chain(&self.receiver_peaks)
    }

    /// The environment's own lights, which its lookups do not contain.
    pub(super) fn environment_lights(&self) -> &[PreparedLight] {
        &self.lights[self.view.frame.lights.len()..]
    }

    /// Factor on light of the environment, by that of an occlusion map, which stands for what shadow rays do not decide about.
    #[inline]
    pub(super) fn untraced_occlusion(&self, occlusion: f32) -> f32 {
        1.0 + (occlusion - 1.0) * (1.0 - self.occluded_share)
    }

    /// Whether a sampled ray of Whitted's tree follows what frosted glass transmits. Glossy samples do so on their own, and an environment without shadow
    /// rays is looked up by the user's choice.
    pub(super) fn follows_frosted_glass(&self) -> bool {
        follows_frosted_glass(self.view, &self.settings)
    }

    /// Whether a sampled ray of Whitted's tree follows bright rough reflection: where there is no environment to look up, and no glossy
    /// samples do so on their own.
    pub(super) fn follows_rough_reflection(&self) -> bool {
        follows_rough_reflection(self.view, &self.settings)
    }

    /// Whether [`IntegratorContext::sample_environment`] samples a direction.
    pub(super) fn samples_environment(&self, entry: Option<VisibleEntry>) -> bool {
        self.samples_environment || entry.is_some()
    }

    /// Samples a direction to the environment for shadow rays of a path, where `entry` says what is seen of it.
    pub(super) fn sample_environment(&self, entry: Option<VisibleEntry>, u: Vec2) -> Option<DirectionSample> {
        match (&self.visible_environment, entry) {
            (Some(visible), Some(entry)) => Some(visible.sample(entry, u)),
            _ if self.samples_environment => self.view.environment.sample(u),
            _ => None,
        }
    }

    /// The density with which [`IntegratorContext::sample_environment`] samples a direction.
    pub(super) fn environment_pdf(&self, entry: Option<VisibleEntry>, direction: Vec3) -> f32 {
        match (&self.visible_environment, entry) {
            (Some(visible), Some(entry)) => visible.pdf(entry, direction),
            _ => self.view.environment.pdf(direction),
        }
    }

    /// Whether a light is in the volume that fills a space.
    pub(super) fn is_lamp_within(&self, light: usize, space: &MediaStack) -> bool {
        let volume = self.lamp_volumes[light];
        volume.is_some() && volume == space.current().map(|medium| medium.volume)
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
            Projection::Orthographic { .. } => self.media_at(ray.at(ray.t_min)),
        }
    }

    /// The volumes around a point.
    pub(super) fn media_at(&self, position: Vec3) -> MediaStack {
        MediaStack::new(&self.interiors.media_around(self.view, &self.volume_bounds, position))
    }
}

/// See [`IntegratorContext::follows_rough_reflection`].
pub(super) fn follows_rough_reflection(view: SceneView<'_>, settings: &IntegratorSettings) -> bool {
    !view.environment.is_lit() && settings.glossy_samples == 0
}

/// See [`IntegratorContext::follows_frosted_glass`].
pub(super) fn follows_frosted_glass(view: SceneView<'_>, settings: &IntegratorSettings) -> bool {
    let is_looked_up = view.environment.is_lit() && settings.env_samples == EnvSamples::Fixed(0);
    settings.glossy_samples == 0 && !is_looked_up
}
