//! How many rays a frame will trace, before it is traced: what a better hierarchy is worth depends on it.

use glam::{Vec2, Vec3};

use super::settings::RenderSettings;
use crate::frame::Frame;
use crate::integrator::{EnvSamples, Integrator};
use crate::scene::Environment;

/// Bounces of a sample in a typical scene: of Whitted's tree one reflection or refraction, of paths as many as Russian roulette leaves.
const TYPICAL_BOUNCES: u32 = 1;
const TYPICAL_PATH_BOUNCES: u32 = 3;

/// Estimated rays of a frame, or of one of its `shutter_samples`, which need be right but for a small factor.
///
/// All pixels count as if they saw a surface, and all surfaces as if they faced all lights; samples that `--noise` saves or
/// [`RenderSettings::adaptive`] adds do not count. For [`crate::bvh::BuildSettings::expected_rays`].
pub fn expected_rays(
    settings: &RenderSettings,
    shutter_samples: u32,
    frame: &Frame,
    environment: &Environment,
) -> u64 {
    let pixels = u64::from(settings.window.width()) * u64::from(settings.window.height());
    let samples = u64::from(samples(settings).div_ceil(shutter_samples.max(1)));
    let rays_a_sample = match settings.integrator {
        Integrator::Whitted => rays_of_tree(settings, frame, environment),
        Integrator::Path => rays_of_path(settings, frame, environment),
    };
    pixels.saturating_mul(samples).saturating_mul(rays_a_sample)
}

/// Samples of a pixel that are rendered.
fn samples(settings: &RenderSettings) -> u32 {
    let of_range =
        settings.path.sample_range.map(|range| range.last.saturating_sub(range.first).saturating_add(1));
    of_range.map_or(settings.samples, |of_range| of_range.min(settings.samples))
}

/// A camera ray, its reflections or refractions, and shadow rays from one surface.
fn rays_of_tree(settings: &RenderSettings, frame: &Frame, environment: &Environment) -> u64 {
    let lights = lights(frame, environment) + environment.peaks().len();
    let to_environment = match settings.env_samples {
        _ if !environment.is_lit() => 0,
        EnvSamples::Auto => 1,
        EnvSamples::Fixed(rays) => rays,
    };
    let bounces = settings.max_depth.min(TYPICAL_BOUNCES.max(settings.glossy_samples));
    1 + u64::from(bounces) + lights as u64 + u64::from(to_environment)
}

/// A ray to each surface, and from there one to the lights, one to the environment, and one to emissive triangles.
fn rays_of_path(settings: &RenderSettings, frame: &Frame, environment: &Environment) -> u64 {
    let to_lights = lights(frame, environment) > 0;
    let to_environment = environment.sample(Vec2::splat(0.5)).is_some();
    let to_emitters = frame.materials.iter().any(|material| material.emissive != Vec3::ZERO);
    let shadow_rays = [to_lights, to_environment, to_emitters].into_iter().filter(|sends| *sends).count();
    let surfaces = 1 + u64::from(settings.max_depth.min(TYPICAL_PATH_BOUNCES));
    surfaces * (1 + shadow_rays as u64)
}

/// Lights that rays cannot hit, but for the environment's peaks.
fn lights(frame: &Frame, environment: &Environment) -> usize {
    frame.lights.len() + usize::from(environment.key_light().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PixelWindow;
    use crate::integrator::{PathSettings, SampleRange};
    use crate::scene::{BuiltInLight, Material};

    /// 20 x 10 pixels of 4 samples.
    fn settings() -> RenderSettings {
        RenderSettings {
            resolution: (100, 50),
            window: PixelWindow { x0: 10, y0: 0, x1: 30, y1: 10 },
            samples: 4,
            max_depth: 8,
            ..RenderSettings::default()
        }
    }

    fn rays(settings: &RenderSettings, environment: &Environment) -> u64 {
        expected_rays(settings, 1, &Frame::default(), environment)
    }

    const SKY: Environment = Environment::Constant(Vec3::ONE);
    const STUDIO: Environment = Environment::BuiltIn(BuiltInLight::Studio);

    #[test]
    fn whitted_sends_a_camera_ray_shadow_rays_and_one_bounce() {
        assert_eq!(rays(&settings(), &Environment::None), 800 * 2);
        assert_eq!(rays(&RenderSettings { max_depth: 0, ..settings() }, &Environment::None), 800);
        // The studio brings a key light, and shadow rays go to both.
        assert_eq!(rays(&settings(), &STUDIO), 800 * 4);
        let with = |env_samples| RenderSettings { env_samples, ..settings() };
        assert_eq!(rays(&settings(), &SKY), 800 * 3);
        assert_eq!(rays(&with(EnvSamples::Fixed(4)), &SKY), 800 * 6);
        assert_eq!(rays(&with(EnvSamples::Fixed(0)), &SKY), 800 * 2);
        assert_eq!(rays(&with(EnvSamples::Fixed(4)), &Environment::None), 800 * 2);
    }

    #[test]
    fn glossy_samples_are_bounces() {
        let glossy = RenderSettings { glossy_samples: 6, ..settings() };
        assert_eq!(rays(&glossy, &Environment::None), 800 * 7);
        assert_eq!(rays(&RenderSettings { max_depth: 0, ..glossy }, &Environment::None), 800);
    }

    #[test]
    fn each_surface_of_a_path_sends_a_ray_to_each_kind_of_light() {
        let path = RenderSettings { integrator: Integrator::Path, ..settings() };
        assert_eq!(rays(&path, &Environment::None), 800 * 4);
        assert_eq!(rays(&path, &STUDIO), 800 * 4 * 3);
        assert_eq!(rays(&RenderSettings { max_depth: 1, ..path.clone() }, &STUDIO), 800 * 2 * 3);
        let mut lamp = Frame::default();
        lamp.materials.push(Material { emissive: Vec3::ONE, ..Material::default() });
        assert_eq!(expected_rays(&path, 1, &lamp, &Environment::None), 800 * 4 * 2);
    }

    #[test]
    fn shutter_samples_and_sample_ranges_share_the_samples() {
        assert_eq!(expected_rays(&settings(), 2, &Frame::default(), &Environment::None), 400 * 2);
        let of_range = |first, last| RenderSettings {
            integrator: Integrator::Path,
            path: PathSettings { sample_range: Some(SampleRange { first, last }), ..PathSettings::default() },
            ..settings()
        };
        assert_eq!(rays(&of_range(1, 2), &Environment::None), 400 * 4);
        assert_eq!(rays(&of_range(0, u32::MAX), &Environment::None), 800 * 4);
    }
}
