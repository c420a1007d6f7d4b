//! What shading must know about a ray besides the segment: how it got there and what it counts for.

use glam::Vec3;

use super::MediaStack;
use super::random::Seed;
use crate::bvh::Hit;

/// A branch of Whitted's tree, up to its last ray. That ray's direction has unit length, so that its `t` is in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Seconds since the start of the animation.
    pub time_seconds: f32,
    /// How wide the last ray is.
    pub footprint: Footprint,
    /// The closed volumes that the last ray starts in.
    pub media: MediaStack,
    /// A surface that touches the one that the last ray comes through: it is met first, at `t` = 0.
    pub touching: Option<Hit>,
    /// What the radiance that the last ray finds counts for.
    pub weight: Vec3,
    /// What made the last ray.
    pub class: PathClass,
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

/// The cone around a ray that stands for the pixel (Akenine-Möller et al. 2019, "Texture Level of Detail Strategies for
/// Real-Time Ray Tracing").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Width at the origin, metres.
    pub width: f32,
    /// Growth of the width a metre.
    pub spread: f32,
}

impl Footprint {
    /// Width after `t` metres.
    pub fn width_at(&self, t: f32) -> f32 {
        self.width + self.spread * t
    }
}
