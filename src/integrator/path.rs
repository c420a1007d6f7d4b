//! What shading must know about a ray besides the segment: how it got there and what it counts for.

use glam::Vec3;

use super::random::Seed;
use super::{LightPass, MediaStack};
use crate::bvh::Hit;
use crate::interaction::Footprint;

/// A branch of Whitted's tree, up to its last ray. That ray's direction has unit length, so that its `t` is in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Seconds since the start of the animation.
    pub time_seconds: f32,
    /// What the last ray stands for.
    pub footprint: Footprint,
    /// The closed volumes that the last ray starts in.
    pub media: MediaStack,
    /// A surface that touches the one that the last ray comes through: it is met first, at `t` = 0.
    pub touching: Option<Hit>,
    /// What the radiance that the last ray finds counts for.
    pub weight: Vec3,
    /// What made the last ray.
    pub class: PathClass,
    /// Which colours it stands for.
    pub spectrum: Spectrum,
    /// The part of the light that whatever the last ray finds belongs to; `None` for rays from the camera, where what they
    /// meet decides.
    pub part: Option<LightPass>,
    /// Reflections and refractions so far.
    pub depth: u32,
    /// Subscript of the sample in its batch.
    pub sample: u32,
    /// What random numbers follow from.
    pub seed: Seed,
}

/// What made a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathClass {
    /// The camera.
    Camera,
    /// A mirror, somewhere before.
    Reflection,
    /// Glass, somewhere before.
    Refraction,
}

/// Which colours a ray stands for. Glass that bends them differently parts white rays into three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spectrum {
    /// All.
    #[default]
    White,
    /// Red alone.
    Red,
    /// Green alone.
    Green,
    /// Blue alone.
    Blue,
}

impl Spectrum {
    /// Single colours, in the order of channels.
    pub const COLORS: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// One in the channels that it stands for, zero in others.
    pub fn mask(self) -> Vec3 {
        match self {
            Self::White => Vec3::ONE,
            Self::Red => Vec3::X,
            Self::Green => Vec3::Y,
            Self::Blue => Vec3::Z,
        }
    }
}
