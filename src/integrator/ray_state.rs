//! State of a traced ray besides its segment.

use glam::Vec3;

use super::color_channels::ColorChannels;
use super::light_pass::LightPass;
use super::lights::LightSet;
use super::media::MediaStack;
use super::random::Seed;
use super::whitted::PrefilteredLobe;
use crate::bvh::Hit;
use crate::interaction::RayDifferential;

/// State of one ray of Whitted's tree. The direction of the ray has unit length, so that its `t` is in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RayState {
    /// Differences to the rays of neighbouring samples.
    pub differential: RayDifferential,
    /// The closed volumes in which the ray starts.
    pub media: MediaStack,
    /// A surface that touches the one that the ray passes: it is hit first, at `t` = 0. Few rays have one.
    pub touching: Option<Box<Hit>>,
    /// Multiplies the radiance that the ray finds.
    pub weight: Vec3,
    /// The kind of the ray.
    pub kind: RayKind,
    /// The colour channels that the ray carries.
    pub channels: ColorChannels,
    /// The light pass that receives whatever the ray finds; `None` for camera rays, whose first surface decides.
    pub light_pass: Option<LightPass>,
    /// Share of a path whose guide the ray finds; 0 where an earlier surface scattered light.
    pub guide_share: f32,
    /// The weight that the ray would have without guiding over its weight; 1 where it has more by guiding. Russian roulette follows that one.
    pub unguided_ratio: f32,
    /// Whether a ray of Whitted's tree sees the peaks of the environment: not where its last surface shows them as highlights.
    pub sees_peaks: bool,
    /// The lamps that an earlier surface of a ray of Whitted's tree showed. Their light passes glass straight, so frosted glass that the ray finds does not show them
    /// once more.
    pub(crate) shown_lamps: LightSet,
    /// Sum of α² of the rough lobes that the ray stands for in Whitted's tree: they blur the environment that it sees.
    pub blur: f32,
    /// The prefiltered lobe that a ray of Whitted's tree finds where it reaches the environment, instead of its direction.
    pub(crate) environment_lobe: Option<PrefilteredLobe>,
    /// Number of reflections and refractions before the ray.
    pub depth: u32,
    /// Index of the sample in its batch.
    pub sample: u32,
    /// Seed of the ray's random numbers.
    pub seed: Seed,
}

/// The interaction that made a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// A camera ray.
    Camera,
    /// A ray that its last surface reflected.
    Reflection,
    /// A ray that its last surface transmitted.
    Refraction,
    /// A mirror ray of the ground, which sees surfaces and no environment.
    GroundReflection,
}
