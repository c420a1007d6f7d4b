//! State of a traced ray besides its segment.

use std::ops::Deref;

use glam::Vec3;

use super::color_channels::ColorChannels;
use super::light_pass::LightPass;
use super::light_set::LightSet;
use super::media::MediaStack;
use super::prefiltered_lobe::PrefilteredLobe;
use super::random::Seed;
use crate::bvh::Hit;
use crate::geometry::Facing;
use crate::interaction::RayDifferential;

/// State of one ray of Whitted's tree, of a path, or of a photon. The direction of the ray has unit length, so that its `t` is in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RayState {
    /// Differences to the rays of neighbouring samples.
    pub differential: RayDifferential,
    /// The closed volumes in which the ray starts.
    pub media: MediaStack,
    /// A surface that touches the one that the ray passed. Few rays have one.
    pub touching: Option<Box<Touching>>,
    /// Multiplies the radiance that the ray finds.
    pub weight: Vec3,
    /// The kind of the ray.
    pub kind: RayKind,
    /// The colour channels that the ray carries.
    pub channels: ColorChannels,
    /// The light pass that receives whatever the ray finds; `None` for camera rays, whose first surface decides.
    pub light_pass: Option<LightPass>,
    /// Number of reflections and refractions before the ray.
    pub depth: u32,
    /// Index of the sample in its batch.
    pub sample: u32,
    /// Seed of the ray's random numbers.
    pub seed: Seed,

    // Of paths.
    /// Share of a path whose guide the ray finds; 0 where an earlier surface scattered light.
    pub guide_share: f32,
    /// The weight that the ray would have without guiding over its weight; 1 where it has more by guiding. Russian roulette follows that one.
    pub unguided_ratio: f32,
    /// Whether an earlier surface of a path has the light of lamps that rays cannot hit, straight through glass: glass that the ray finds does not scatter it once more.
    pub has_lamps: bool,

    // Of Whitted's tree.
    /// Whether the ray sees the peaks of the environment: not where its last surface shows them as highlights.
    pub sees_peaks: bool,
    /// Whether an earlier surface sampled a rough lobe for the ray.
    pub is_sampled: bool,
    /// The lamps that an earlier surface of the ray showed. Their light passes glass straight, so frosted glass that the ray finds does not show them
    /// once more.
    pub(crate) shown_lamps: LightSet,
    /// Sum of α² of the rough lobes that the ray stands for: they blur the environment that it sees.
    pub blur: f32,
    /// The prefiltered lobe that the ray finds where it reaches the environment, instead of its direction.
    pub(crate) environment_lobe: Option<PrefilteredLobe>,
}

/// A surface that touches the one that a ray passed, and bounds no volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Touching {
    /// The ray hits it first, at `t` = 0.
    pub hit: Hit,
    /// The volumes on the viewer's side of both surfaces.
    pub media: MediaStack,
    /// The sides of surfaces there that the ray passed; the touching surface is not among them.
    pub passed: Vec<PassedSide>,
}

/// One side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassedSide {
    /// A triangle of the surface.
    pub triangle: u32,
    /// The side.
    pub facing: Facing,
}

/// The state of a ray where it arrives at a surface.
#[derive(Debug)]
pub(super) enum ArrivingState<'s> {
    /// That of the ray.
    OfRay(&'s RayState),
    /// With the volumes on the viewer's side of touching surfaces.
    AtTouching(Box<RayState>),
}

impl Deref for ArrivingState<'_> {
    type Target = RayState;

    #[inline]
    fn deref(&self) -> &RayState {
        match self {
            Self::OfRay(state) => state,
            Self::AtTouching(state) => state,
        }
    }
}

impl RayState {
    /// The state of a primary ray that starts in `media` with the full weight, for sample `sample` of a batch.
    #[inline(always)]
    pub(super) fn primary(differential: RayDifferential, media: MediaStack, sample: u32, seed: Seed) -> Self {
        Self {
            differential,
            media,
            touching: None,
            weight: Vec3::ONE,
            kind: RayKind::Camera,
            channels: ColorChannels::White,
            light_pass: None,
            guide_share: 1.0,
            unguided_ratio: 1.0,
            has_lamps: false,
            sees_peaks: true,
            is_sampled: false,
            shown_lamps: LightSet::default(),
            blur: 0.0,
            environment_lobe: None,
            depth: 0,
            sample,
            seed,
        }
    }

    /// The state where the ray arrives at a surface.
    #[inline]
    pub(super) fn arriving_at(&self, hit: &Hit) -> ArrivingState<'_> {
        match self.touching_at(hit.triangle) {
            Some(touching) if hit.t == 0.0 => ArrivingState::AtTouching(Box::new(Self {
                media: touching.media.clone(),
                touching: None,
                ..self.clone()
            })),
            _ => ArrivingState::OfRay(self),
        }
    }

    /// Whether the ray is outside of all volumes, at its first surface as well.
    #[inline]
    pub(super) fn is_in_vacuum(&self) -> bool {
        self.media.is_empty() && self.touching.is_none()
    }

    /// How the ray arrives at its touching surface, if that has this triangle.
    #[inline]
    pub(super) fn touching_at(&self, triangle: u32) -> Option<&Touching> {
        self.touching.as_deref().filter(|touching| touching.hit.triangle == triangle)
    }
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

impl RayKind {
    /// Whether a ray sees the shadows on catchers. Mirror images of the ground hold surfaces alone, and catchers are none.
    pub(super) fn sees_catchers(self) -> bool {
        self != Self::GroundReflection
    }
}
