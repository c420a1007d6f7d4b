//! Preparing a frame for an integrator.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::IntegratorContext;
use super::context::{follows_frosted_glass, follows_rough_reflection};
use super::environment_directions::EnvironmentDirections;
use super::environment_shares::{EnvironmentShares, SharesOfTime};
use super::interiors::Interiors;
use super::interreflections::Interreflections;
use super::lights::{self, PreparedLight};
use super::lookup_environment::LookupEnvironment;
use super::occluders::OccluderBox;
use super::opaque_materials::{OpaqueAlbedos, is_opaque};
use super::path::{EmissiveTriangles, PathGuide, VisibleEnvironment};
use super::random::hash;
use super::settings::{EnvSamples, Integrator, IntegratorSettings, LightSize, PathSettings};
use super::zsobol::ZSobol;
use crate::color::luminance;
use crate::frame::Frame;
use crate::interaction::is_constant;
use crate::scene::{AlphaMode, Material};
use crate::scene_view::SceneView;

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
        let shares = traced_shares(view, &settings);
        let EnvironmentShares { occluded: occluded_share, bounced: bounce_share, .. } = shares;
        let lookups = LookupEnvironment::new(view.environment, &shares);
        let traces_environment = !is_path && occluded_share > 0.0;
        let mean_radiance = if traces_environment { lookups.mean_radiance() } else { Vec3::ZERO };
        let follows_rough_lobes = !is_path
            && (follows_rough_reflection(view, &settings)
                || follows_frosted_glass(view, &settings)
                    && view.frame.materials.iter().any(Material::transmits));
        // Shadow rays find the rest of the light of the environment on the ground.
        let ground_irradiance = ground_irradiance(view, &settings) * (1.0 - occluded_share);
        let has_receivers = has_receivers(view.frame, &settings);
        let shades_receivers = has_receivers && occluded_share > 0.0 && view.environment.is_lit();
        let directions = environment_directions(view, &settings, traces_environment, shades_receivers);
        let opaque_materials = view.frame.materials.iter().map(is_opaque).collect();
        let opaque_albedos = OpaqueAlbedos::of(&view.frame.materials);
        let mut context = Self {
            view,
            lights,
            interiors,
            opaque_materials,
            opaque_albedos,
            may_dim_light: view.frame.materials.iter().any(may_dim_light),
            constant_materials: view.frame.materials.iter().map(is_constant).collect(),
            volume_bounds,
            camera_media,
            lamp_volumes,
            emissive_triangles: is_path.then(|| EmissiveTriangles::new(view)),
            occluders: has_receivers.then(|| OccluderBox::of(view.frame)),
            interreflections: interreflections(view, directions.as_ref(), bounce_share),
            environment_directions: directions,
            receiver_peaks: if is_path && shades_receivers {
                lights::peak_lights(view.environment, &settings)
            } else {
                Vec::new()
            },
            samples_environment: is_path && view.environment.sample(Vec2::splat(0.5)).is_some(),
            visible_environment: if is_path { VisibleEnvironment::new(view).map(Arc::new) } else { None },
            path_guide: None,
            occluded_share,
            lookups,
            traced_samples: traced_samples(occluded_share, &settings),
            bounce_share,
            sample_points: (is_path || traces_environment || follows_rough_lobes)
                .then(|| sample_points(view.frame, &settings)),
            uses_seeds: uses_seeds(view.frame, &settings),
            peaks: view.environment.peaks(),
            mean_radiance,
            ground_irradiance,
            has_receivers,
            settings,
        };
        if is_path {
            context.path_guide = PathGuide::new(&context).map(Arc::new);
        }
        context
    }
}

/// Luminance of the environment's irradiance on the ground, if there is one.
fn ground_irradiance(view: SceneView<'_>, settings: &IntegratorSettings) -> f32 {
    settings.ground.map_or(0.0, |ground| luminance(view.environment.irradiance(ground.up)))
}

/// Directions of shadow rays to the environment, if any surface sends them. Receivers are most often horizontal.
fn environment_directions(
    view: SceneView<'_>,
    settings: &IntegratorSettings,
    traces_environment: bool,
    shades_receivers: bool,
) -> Option<EnvironmentDirections> {
    let up = settings.ground.map_or(Vec3::Y, |ground| ground.up);
    (traces_environment || shades_receivers).then(|| {
        let directions = EnvironmentDirections::new(view.environment);
        if shades_receivers { directions.with_receivers(up) } else { directions }
    })
}

/// The light of occluders in the dark, if a share of them is lit.
fn interreflections(
    view: SceneView<'_>,
    directions: Option<&EnvironmentDirections>,
    bounce_share: f32,
) -> Option<Interreflections> {
    directions.filter(|_| bounce_share > 0.0).and_then(|directions| Interreflections::new(view, directions))
}

fn traced_shares(view: SceneView<'_>, settings: &IntegratorSettings) -> EnvironmentShares {
    if settings.integrator == Integrator::Path {
        return EnvironmentShares { bounced: 0.0, ..EnvironmentShares::ALL };
    }
    match settings.env_samples {
        _ if !view.environment.is_lit() => EnvironmentShares::NONE,
        EnvSamples::Fixed(0) => EnvironmentShares::NONE,
        EnvSamples::Fixed(_) => EnvironmentShares::ALL,
        EnvSamples::Auto => {
            let Some(shares) = &settings.environment_shares else {
                let position = view.frame.camera.world_from_camera.w_axis.truncate();
                return EnvironmentShares::of_times(&[SharesOfTime::seen_from(view, position)]);
            };
            shares.at_intensity(view.frame.image_light.map_or(1.0, |pose| pose.intensity))
        }
    }
}

/// The share of the samples that trace shadow rays to the environment where these decide about a share of its light: 1/4, 1/2 or all. They are as few only
/// where each pixel takes its part of them, and no pixel takes more samples where they differ.
pub(super) fn traced_samples(occluded_share: f32, settings: &IntegratorSettings) -> f32 {
    let IntegratorSettings { samples, max_samples, .. } = *settings;
    let divisors = [4, 2].into_iter().filter(|divisor| samples == max_samples && samples % divisor == 0);
    let mut shares = divisors.map(|divisor: u32| 1.0 / divisor as f32);
    shares.find(|share| occluded_share <= *share).unwrap_or(1.0)
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
    let frame_time = settings.noise_time.unwrap_or(frame.time_seconds);
    let time = if seed_per_frame { frame_time.to_bits() } else { 0 };
    ZSobol::new(settings.max_samples, seed ^ hash(hash(time as u32) ^ (time >> 32) as u32))
}

/// Whether light that passes surfaces of a material, or the volume that they bound, may be dimmed. That of shadow catchers never is.
fn may_dim_light(material: &Material) -> bool {
    let fades = material.alpha_mode == AlphaMode::Blend && !material.is_shadow_catcher;
    fades || material.transmits() || material.is_volume()
}
