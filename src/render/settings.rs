//! Settings of a render.

use super::adaptive::Adaptive;
use super::filter::PixelFilter;
use super::lens::Lens;
use crate::film::{AovFlags, PixelWindow};
use crate::integrator::{
    EnvSamples, EnvironmentShares, GlassShadows, Integrator, LightSize, PathSettings, SampleRange,
};
use crate::scene::Ground;

/// What decides an image besides the frame itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Size of the whole image, pixels.
    pub resolution: (u32, u32),
    /// The part of the image that is rendered.
    pub window: PixelWindow,
    /// Samples per pixel.
    pub samples: u32,
    /// Additional samples for pixels on edges.
    pub adaptive: Option<Adaptive>,
    /// Reconstruction filter.
    pub filter: PixelFilter,
    /// Lens of the camera. Without one everything is in focus.
    pub lens: Option<Lens>,
    /// Light transport algorithm.
    pub integrator: Integrator,
    /// Settings of [`Integrator::Path`].
    pub path: PathSettings,
    /// Deepest reflection or refraction; 0 shows only what the camera sees directly.
    pub max_depth: u32,
    /// Shadows of glass.
    pub glass_shadows: GlassShadows,
    /// Multiplies punctual lights.
    pub light_scale: f32,
    /// Size of the lights.
    pub light_size: LightSize,
    /// Rays that follow a rough lobe of the first surface; 0 looks up the prefiltered environment instead.
    pub glossy_samples: u32,
    /// Shadow rays of [`Integrator::Whitted`] to the environment.
    pub env_samples: EnvSamples,
    /// What [`EnvSamples::Auto`] traces of the environment's light; `None` decides by what the camera of the frame sees.
    pub environment_shares: Option<EnvironmentShares>,
    /// Whether camera rays that leave the scene see the environment; otherwise they are transparent.
    pub show_background: bool,
    /// The plane that shows shadows below the scene.
    pub ground: Option<Ground>,
    /// The time whose noise the frame has, seconds; `None` for that of its pose. All shutter samples of a frame share one, so that their samples are
    /// spread as those of one set.
    pub noise_time: Option<f64>,
    /// The exposure at which images are looked at, stops: that of the display values by which pixels take more samples or none.
    pub exposure_ev: f32,
    /// AOVs besides colour and coverage. They change neither of these.
    pub aovs: AovFlags,
}

impl RenderSettings {
    /// Whether display values decide about the number of samples of a pixel.
    pub fn decides_by_display_values(&self) -> bool {
        match self.integrator {
            Integrator::Whitted => self.adaptive.is_some(),
            Integrator::Path => self.path.noise.is_some(),
        }
    }

    /// The rendered samples and the number of all, such as `0-63/256`; `None` where all are rendered.
    pub fn sample_range_text(&self) -> Option<String> {
        let SampleRange { first, last } = self.path.sample_range?;
        Some(format!("{first}-{last}/{}", self.samples))
    }
}

impl Default for RenderSettings {
    /// The defaults of `rayframe render`.
    fn default() -> Self {
        Self {
            resolution: (1280, 720),
            window: PixelWindow::full(1280, 720),
            samples: 4,
            adaptive: None,
            filter: PixelFilter::Box,
            lens: None,
            integrator: Integrator::Whitted,
            path: PathSettings::default(),
            max_depth: 8,
            glass_shadows: GlassShadows::Straight,
            light_scale: 1.0,
            light_size: LightSize::default(),
            glossy_samples: 0,
            env_samples: EnvSamples::Auto,
            environment_shares: None,
            show_background: true,
            ground: None,
            noise_time: None,
            exposure_ev: 0.0,
            aovs: AovFlags::NONE,
        }
    }
}
