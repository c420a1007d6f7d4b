//! Settings of an integrator.

use super::environment_shares::EnvironmentShares;
use crate::scene::Ground;

/// Light transport algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Integrator {
    /// Whitted's recursive ray tracing: [`super::whitted`].
    #[default]
    Whitted,
    /// Path tracing: [`super::path`].
    Path,
}

/// Settings of path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Seed of the sample points.
    pub seed: u32,
    /// Whether every frame has sample points of its own.
    pub seed_per_frame: bool,
    /// Noise, as the standard error of display values from 0 to 1, at which a pixel takes no more samples.
    pub noise: Option<f32>,
    /// Largest radiance that a path brings from beyond its first surface, in the largest channel; infinite for no limit. A limit
    /// removes fireflies and some light.
    pub clamp_indirect: f32,
    /// Whether paths find smooth surfaces rougher that they reach after a rough one.
    pub regularize: bool,
    /// The samples that are rendered; `None` for all.
    pub sample_range: Option<SampleRange>,
    /// Time after which a frame takes no more samples; the image depends on the machine's speed.
    pub time_limit_seconds: Option<f32>,
}

/// Some of the samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    /// Index of the first one.
    pub first: u32,
    /// Index of the last one.
    pub last: u32,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            seed: 0,
            seed_per_frame: false,
            noise: None,
            clamp_indirect: f32::INFINITY,
            regularize: false,
            sample_range: None,
            time_limit_seconds: None,
        }
    }
}

/// How volumes and thin glass darken the surfaces in their shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GlassShadows {
    /// Light passes straight through, coloured by the glass.
    #[default]
    Straight,
    /// Glass casts full shadows.
    Opaque,
}

/// What decides the radiance of a ray besides the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Light transport algorithm.
    pub integrator: Integrator,
    /// Settings of [`Integrator::Path`].
    pub path: PathSettings,
    /// The time whose noise the frame has, seconds; `None` for that of its pose.
    pub noise_time: Option<f64>,
    /// Samples that every pixel takes.
    pub samples: u32,
    /// Samples that a pixel takes at most.
    pub max_samples: u32,
    /// Deepest reflection or refraction; 0 shows only what the camera sees.
    pub max_depth: u32,
    /// Shadows of glass.
    pub glass_shadows: GlassShadows,
    /// Whether camera rays that leave the scene see the environment; otherwise they are transparent.
    pub show_background: bool,
    /// The plane that shows shadows below the scene.
    pub ground: Option<Ground>,
    /// Multiplies the frame's own lights.
    pub light_scale: f32,
    /// Size of the lights; decides how soft their shadows are.
    pub light_size: LightSize,
    /// Rays that follow a rough lobe of the first surface; 0 looks up the prefiltered environment instead.
    pub glossy_samples: u32,
    /// Shadow rays of [`Integrator::Whitted`] to the environment.
    pub env_samples: EnvSamples,
    /// What [`EnvSamples::Auto`] traces of the environment's light; `None` decides by what the camera of the frame sees.
    pub environment_shares: Option<EnvironmentShares>,
}

impl Default for IntegratorSettings {
    /// The defaults of `rayframe render`.
    fn default() -> Self {
        Self {
            integrator: Integrator::Whitted,
            path: PathSettings::default(),
            noise_time: None,
            samples: 4,
            max_samples: 4,
            max_depth: 8,
            glass_shadows: GlassShadows::Straight,
            show_background: true,
            ground: None,
            light_scale: 1.0,
            light_size: LightSize::default(),
            glossy_samples: 0,
            env_samples: EnvSamples::Auto,
            environment_shares: None,
        }
    }
}

/// Shadow rays for each lookup of the environment at the first surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EnvSamples {
    /// One, and up to three more where an occluder is found and lit; four on shadow catchers and the ground, except where what casts shadows fills a small part of the sky. Shadows fade out where the camera is inside a closed space, which is lit by what comes in on average instead.
    #[default]
    Auto,
    /// So many; 0 leaves the light of the environment unoccluded, and without a bounce.
    Fixed(u32),
}

/// Size of the lights. Lights of size 0 cast hard shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSize {
    /// Radius of point and spot lights, metres.
    pub radius: f32,
    /// Angular diameter of directional lights and of the environment's key light, radians.
    pub sun_angle_radians: f32,
}
