//! How many rays a frame will trace, before it is traced: what a better hierarchy is worth depends on it.

use crate::integrator::{EnvSamples, Integrator};
use crate::render::RenderSettings;

/// Bounces of a sample in a typical scene: of Whitted's tree one reflection or refraction, of paths as many as Russian roulette leaves.
const TYPICAL_BOUNCES: u32 = 1;
const TYPICAL_PATH_BOUNCES: u32 = 3;

/// What shines on the surfaces of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSources {
    /// Lights that rays cannot hit.
    pub(super) lights: usize,
    /// Whether the environment emits light.
    pub(super) has_environment: bool,
}

/// Estimated rays of one shutter sample, which need be right but for a small factor: for each pixel sample a camera ray, its bounces, and
/// shadow rays. Whitted's tree sends these to each light and to the environment from one surface, a path from each of its surfaces
/// one to the lights and one to the environment.
pub(super) fn expected_rays(render: &RenderSettings, time_samples: u32, sources: LightSources) -> u64 {
    let LightSources { lights, has_environment } = sources;
    let rays_a_sample = match render.integrator {
        Integrator::Whitted => {
            let bounces = render.max_depth.min(TYPICAL_BOUNCES);
            let to_environment = match render.env_samples {
                EnvSamples::Auto => 1,
                EnvSamples::Fixed(rays) => rays,
            };
            let to_environment = if has_environment { to_environment } else { 0 };
            1 + u64::from(bounces) + lights as u64 + u64::from(to_environment)
        }
        Integrator::Path => {
            let surfaces = 1 + u64::from(render.max_depth.min(TYPICAL_PATH_BOUNCES));
            surfaces * (1 + u64::from(lights > 0) + u64::from(has_environment))
        }
    };
    let pixels = u64::from(render.window.width()) * u64::from(render.window.height());
    let samples = u64::from(render.samples.div_ceil(time_samples));
    pixels.saturating_mul(samples).saturating_mul(rays_a_sample)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PixelWindow;

    const LAMPS: LightSources = LightSources { lights: 3, has_environment: false };
    const LAMPS_AND_SKY: LightSources = LightSources { lights: 3, has_environment: true };

    /// 20 x 10 pixels of 4 samples.
    fn render() -> RenderSettings {
        RenderSettings {
            resolution: (100, 50),
            window: PixelWindow { x0: 10, y0: 0, x1: 30, y1: 10 },
            samples: 4,
            max_depth: 8,
            ..RenderSettings::default()
        }
    }

    #[test]
    fn whitted_sends_a_camera_ray_shadow_rays_and_one_bounce() {
        assert_eq!(expected_rays(&render(), 1, LAMPS), 800 * 5);
        assert_eq!(expected_rays(&RenderSettings { max_depth: 0, ..render() }, 1, LAMPS), 800 * 4);
        // Two shutter samples share the samples of a pixel.
        assert_eq!(expected_rays(&render(), 2, LAMPS), 400 * 5);
    }

    #[test]
    fn whitted_sends_shadow_rays_to_an_environment_that_shines() {
        let with = |env_samples| RenderSettings { env_samples, ..render() };
        assert_eq!(expected_rays(&render(), 1, LAMPS_AND_SKY), 800 * 6);
        assert_eq!(expected_rays(&with(EnvSamples::Fixed(4)), 1, LAMPS_AND_SKY), 800 * 9);
        assert_eq!(expected_rays(&with(EnvSamples::Fixed(0)), 1, LAMPS_AND_SKY), 800 * 5);
        assert_eq!(expected_rays(&with(EnvSamples::Fixed(4)), 1, LAMPS), 800 * 5);
    }

    #[test]
    fn each_surface_of_a_path_sends_a_ray_to_each_kind_of_light() {
        let path = RenderSettings { integrator: Integrator::Path, ..render() };
        assert_eq!(expected_rays(&path, 1, LAMPS), 800 * 4 * 2);
        assert_eq!(expected_rays(&path, 1, LAMPS_AND_SKY), 800 * 4 * 3);
        assert_eq!(expected_rays(&RenderSettings { max_depth: 1, ..path }, 1, LAMPS_AND_SKY), 800 * 2 * 3);
    }
}
