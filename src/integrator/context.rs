//! One frame prepared for an integrator: the view, its lights and its volumes.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::environment_directions::EnvironmentDirections;
use super::glass_passage::GlassPassage;
use super::interiors::Interiors;
use super::lights::{self, PreparedLight};
use super::media::{MediaStack, Medium, VolumeId};
use super::occluders::OccluderSphere;
use super::opaque_materials::{OpaqueAlbedos, is_opaque};
use super::path::{EmissiveTriangles, PathGuide, VisibleEntry, VisibleEnvironment};
use super::random::hash;
use super::settings::{EnvSamples, Integrator, IntegratorSettings, LightSize, PathSettings};
use super::walls::is_wall;
use super::zsobol::ZSobol;
use crate::bvh::{Hit, TraversalCounters};
use crate::color::luminance;
use crate::frame::{Frame, transmits};
use crate::geometry::{Aabb, Ray, spiral_direction};
use crate::interaction::is_constant;
use crate::scene::{Environment, KeyLight, Projection};
use crate::scene_view::SceneView;

/// Automatic shadows of the environment begin where a camera sees it in this share of all directions, and are full at the second share.
const OPEN_SHARES: [f32; 2] = [0.05, 0.15];
/// Their occluders reflect light from the first of these shares on, and all of it at the second.
const BOUNCE_SHARES: [f32; 2] = [0.15, 0.25];
/// Rays that find how much of the environment a camera sees.
const OPENNESS_RAYS: u32 = 2048;
/// Normals whose irradiances tell the mean radiance of the environment.
const MEAN_NORMALS: u32 = 64;

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
    /// The volumes that lamps are in, by light; none for distant lights.
    lamp_volumes: Vec<Option<VolumeId>>,
    /// For [`Integrator::Path`].
    pub(super) emissive_triangles: Option<EmissiveTriangles>,
    /// Directions of the shadow rays to the environment from the surfaces of [`Integrator::Whitted`], and from shadow catchers and the ground; `None` where its
    /// light is not occluded.
    pub(super) environment_directions: Option<EnvironmentDirections>,
    /// What can hide the environment from shadow catchers and the ground, where shadow rays decide about it.
    pub(super) occluders: Option<OccluderSphere>,
    /// The environment's peaks as lights of shadow catchers and the ground, where they are not among all lights.
    receiver_peaks: Vec<PreparedLight>,
    /// Whether shadow rays of paths sample the environment by its radiance.
    samples_environment: bool,
    /// For [`Integrator::Path`], where walls hide most of the environment.
    pub(super) visible_environment: Option<Arc<VisibleEnvironment<'a>>>,
    /// For [`Integrator::Path`], where smooth surfaces focus the light of emissive triangles.
    pub(super) path_guide: Option<Arc<PathGuide>>,
    /// Share of the environment's light that shadow rays decide about.
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
    /// Mean radiance of the environment without its peaks, where shadow rays decide about its light.
    pub(super) mean_radiance: Vec3,
    /// Luminance of the environment's irradiance on the ground that no shadow rays decide about.
    pub(super) ground_irradiance: f32,
    /// Whether anything only receives shadows: shadow catchers and the ground.
    pub(super) has_receivers: bool,
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
        let is_path = settings.integrator == Integrator::Path;
        let lights = lights::gather(view.frame, view.environment, &settings);
        let volume_around =
            |position| Some(interiors.media_around(view, &volume_bounds, position).pop()?.volume);
        let lamp_volume =
            |light: &PreparedLight| light.position().filter(|_| !is_path).and_then(volume_around);
        let lamp_volumes = lights.iter().map(lamp_volume).collect();
        let [occluded_share, bounce_share] = match settings.integrator {
            Integrator::Path => [1.0, 0.0],
            Integrator::Whitted if view.environment.is_lit() => traced_shares(view, settings.env_samples),
            Integrator::Whitted => [0.0; 2],
        };
        let traces_environment = !is_path && occluded_share > 0.0;
        let follows_rough_lobes = !is_path
            && (follows_rough_reflection(view, &settings)
                || follows_frosted_glass(view, &settings) && view.frame.materials.iter().any(transmits));
        // Shadow rays find the rest of the light of the environment on the ground.
        let on_ground =
            settings.ground.map_or(0.0, |ground| luminance(view.environment.irradiance(ground.up)));
        let ground_irradiance = on_ground * (1.0 - occluded_share);
        let has_receivers = has_receivers(view.frame, &settings);
        let shades_receivers = has_receivers && occluded_share > 0.0 && view.environment.is_lit();
        let opaque_materials = view.frame.materials.iter().map(is_opaque).collect();
        let opaque_albedos = OpaqueAlbedos::of(&view.frame.materials);
        let mut context = Self {
            view,
            lights,
            interiors,
            opaque_materials,
            opaque_albedos,
            constant_materials: view.frame.materials.iter().map(is_constant).collect(),
            volume_bounds,
            camera_media,
            lamp_volumes,
            emissive_triangles: is_path.then(|| EmissiveTriangles::new(view)),
            occluders: shades_receivers.then(|| OccluderSphere::of(view.frame)),
            environment_directions: (traces_environment || shades_receivers)
                .then(|| EnvironmentDirections::new(view.environment)),
            receiver_peaks: if is_path && shades_receivers {
                lights::peak_lights(view.environment, &settings)
            } else {
                Vec::new()
            },
            samples_environment: is_path && view.environment.sample(Vec2::splat(0.5)).is_some(),
            visible_environment: if is_path { VisibleEnvironment::new(view).map(Arc::new) } else { None },
            path_guide: None,
            occluded_share,
            traced_samples: traced_samples(occluded_share, &settings),
            bounce_share,
            sample_points: (is_path || traces_environment || follows_rough_lobes)
                .then(|| sample_points(view.frame, &settings)),
            uses_seeds: uses_seeds(view.frame, &settings),
            peaks: view.environment.peaks(),
            mean_radiance: if traces_environment { mean_radiance(view.environment) } else { Vec3::ZERO },
            ground_irradiance,
            has_receivers,
            settings,
        };
        if is_path {
            context.path_guide = PathGuide::new(&context).map(Arc::new);
        }
        context
    }

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

    /// Samples a direction to the environment for shadow rays of a path, where `entry` says what is seen of it: a unit vector and its density
    /// by solid angle.
    pub(super) fn sample_environment(&self, entry: Option<VisibleEntry>, u: Vec2) -> Option<(Vec3, f32)> {
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

/// Share of the environment's light that shadow rays decide about, and of what their occluders reflect that is traced. Automatic ones fade out as the
/// camera enters a closed space: by the share of directions in which nothing is between camera and environment.
fn traced_shares(view: SceneView<'_>, env_samples: EnvSamples) -> [f32; 2] {
    match env_samples {
        EnvSamples::Fixed(rays) => [f32::from(rays > 0); 2],
        EnvSamples::Auto => {
            let open_share = open_share(view);
            [OPEN_SHARES, BOUNCE_SHARES].map(|[closed, open]| {
                let share = ((open_share - closed) / (open - closed)).clamp(0.0, 1.0);
                share * share * (3.0 - 2.0 * share)
            })
        }
    }
}

/// See [`IntegratorContext::follows_rough_reflection`].
fn follows_rough_reflection(view: SceneView<'_>, settings: &IntegratorSettings) -> bool {
    !view.environment.is_lit() && settings.glossy_samples == 0
}

/// See [`IntegratorContext::follows_frosted_glass`].
fn follows_frosted_glass(view: SceneView<'_>, settings: &IntegratorSettings) -> bool {
    let is_looked_up = view.environment.is_lit() && settings.env_samples == EnvSamples::Fixed(0);
    settings.glossy_samples == 0 && !is_looked_up
}

/// The share of the samples that trace shadow rays to the environment where these decide about a share of its light: 1/4, 1/2 or all. They are as few only
/// where each pixel takes its part of them, and no pixel takes more samples where they differ.
pub(super) fn traced_samples(occluded_share: f32, settings: &IntegratorSettings) -> f32 {
    let IntegratorSettings { samples, max_samples, .. } = *settings;
    let divisors = [4, 2].into_iter().filter(|divisor| samples == max_samples && samples % divisor == 0);
    let mut shares = divisors.map(|divisor: u32| 1.0 / divisor as f32);
    shares.find(|share| occluded_share <= *share).unwrap_or(1.0)
}

/// Share of all directions in which the camera sees the environment, past glass and surfaces that are more than half transparent.
fn open_share(view: SceneView<'_>) -> f32 {
    let origin = view.frame.camera.world_from_camera.w_axis.truncate();
    let mut counters = TraversalCounters::default();
    let directions = (0..OPENNESS_RAYS).map(|index| spiral_direction(index, OPENNESS_RAYS));
    let hides = |hit: &Hit| is_wall(view, hit, |_| true);
    let is_open = |direction| !view.bvh.occluded(&Ray::new(origin, direction), hides, &mut counters);
    directions.map(is_open).filter(|is_open| *is_open).count() as f32 / OPENNESS_RAYS as f32
}

/// Mean radiance of the environment without its peaks.
fn mean_radiance(environment: &Environment) -> Vec3 {
    // The mean irradiance over all normals is π times the mean radiance.
    let normals = (0..MEAN_NORMALS).map(|index| spiral_direction(index, MEAN_NORMALS));
    let sum: Vec3 = normals.map(|normal| environment.irradiance(normal)).sum();
    sum * (FRAC_1_PI / MEAN_NORMALS as f32)
}

/// Whether anything only receives shadows.
fn has_receivers(frame: &Frame, settings: &IntegratorSettings) -> bool {
    settings.ground.is_some() || frame.materials.iter().any(|material| material.is_shadow_catcher)
}

/// Whether shadow rays to sized lights, glossy rays, shadow catchers or the ground use the seeds of ray states.
fn uses_seeds(frame: &Frame, settings: &IntegratorSettings) -> bool {
    settings.light_size != LightSize::default()
        || settings.glossy_samples > 0
        || has_receivers(frame, settings)
}

/// The sample points of a frame.
fn sample_points(frame: &Frame, settings: &IntegratorSettings) -> ZSobol {
    // Whitted's tree has no seed.
    let is_path = settings.integrator == Integrator::Path;
    let PathSettings { seed, seed_per_frame, .. } =
        if is_path { settings.path } else { PathSettings::default() };
    let time = if seed_per_frame { frame.time_seconds.to_bits() } else { 0 };
    ZSobol::new(settings.max_samples, seed ^ hash(hash(time as u32) ^ (time >> 32) as u32))
}
