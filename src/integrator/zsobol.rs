//! Temporary.
use super::random::{Purpose, Seed};
use glam::Vec2;
#[derive(Clone, Copy, Debug)]
pub(crate) struct ZSobol {
    seed: u32,
}
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SampleSequence(Seed);
impl ZSobol {
    pub(crate) fn new(_max_samples: u32, seed: u32) -> Self {
        Self { seed }
    }
    pub(crate) fn sequence(&self, pixel: (u32, u32), sample: u32) -> SampleSequence {
        SampleSequence(Seed::new(pixel, self.seed as f32, sample))
    }
}
impl SampleSequence {
    pub(crate) fn number(&self, dimension: u32) -> f32 {
        self.0.point(Purpose::Light(dimension)).x
    }
    pub(crate) fn point(&self, dimension: u32) -> Vec2 {
        self.0.point(Purpose::Light(dimension))
    }
}
