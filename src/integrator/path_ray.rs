//! A ray with everything that shading must know about how it got there.

use glam::Vec3;

use super::MediaStack;
use crate::bvh::Hit;
use crate::geometry::Ray;

/// A branch of Whitted's tree.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRay {
    /// The segment; its direction has unit length, so that `t` is in metres.
    pub ray: Ray,
    /// Seconds since the start of the animation.
    pub time_seconds: f32,
    /// How wide the ray is.
    pub footprint: Footprint,
    /// The closed volumes that the ray starts in.
    pub media: MediaStack,
    /// A surface that touches the one that the ray comes through: it is met first, at `t` = 0.
    pub touching: Option<Hit>,
    /// What the radiance that the ray finds counts for.
    pub weight: Vec3,
    /// What made the ray.
    pub class: PathClass,
    /// Reflections and refractions so far.
    pub depth: u32,
    /// Subscript of the sample in its batch.
    pub sample: u32,
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
