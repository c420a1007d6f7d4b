//! Radiance and coverage of camera samples.
//!
//! An integrator takes the camera rays of a batch of samples and returns each sample's radiance and coverage. A sample is a
//! pure function of (frame, settings, pixel, sample): it does not depend on the batch that holds it. [`tracing`] follows
//! the rays, and [`whitted`] and [`path`], the integrators, shade what these hit. Pixels, films and files are not known here.

mod albedo_slices;
mod ambient_cubes;
mod camera;
mod camera_samples;
mod clamp;
mod closed_space;
mod color_channels;
mod context;
mod context_build;
mod environment_directions;
mod environment_shares;
mod glass_passage;
mod guide_sample;
mod interiors;
mod interreflections;
mod last_scatter;
mod least_weights;
mod light_pass;
mod light_sampling;
mod light_set;
mod lights;
mod local_frame;
mod lookup_environment;
mod media;
mod occluders;
mod opaque_materials;
pub mod path;
mod prefiltered_lobe;
mod radiosity;
mod random;
mod ray_state;
mod sample_aovs;
mod settings;
mod shadow;
mod statistics;
mod surface_hit;
pub mod tracing;
mod transmission_side;
mod transparent_hits;
mod unit_interval;
mod walls;
mod wavefront;
pub mod whitted;
mod zsobol;

pub use camera::{CameraRays, ThinLens};
pub use camera_samples::CameraSamples;
pub use closed_space::EnclosedLight;
pub use color_channels::ColorChannels;
pub use context::IntegratorContext;
pub use environment_shares::{EnvironmentShares, SharesOfTime};
pub use guide_sample::GuideSample;
pub use light_pass::{LightPass, LightPasses};
pub use media::{MediaStack, Medium, VolumeId};
pub use random::{R2, Seed};
pub use ray_state::{RayKind, RayState};
pub use sample_aovs::{InstanceCoverage, SampleAovFlags};
pub use settings::{
    EnvSamples, GlassShadows, Integrator, IntegratorSettings, LightSize, PathSettings, SampleRange,
};
pub use statistics::IntegratorStatistics;
pub use transparent_hits::TRANSPARENCY_LIMIT;
pub(crate) use unit_interval::unit_interval;
