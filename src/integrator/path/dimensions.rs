//! Dimensions of a path's sample points.

use std::rc::Rc;

use glam::Vec2;

use crate::integrator::ColorChannels;
use crate::integrator::zsobol::{DimensionKeys, SampleSequence};

/// Dimensions of one bounce.
const OF_BOUNCE: u32 = 16;
/// Number of decisions.
const DECISIONS: usize = Decision::Coverage as usize + 1;

/// A decision at one surface of a path. Each has a sample point of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// The colour channel that goes on where a surface disperses light.
    Channel,
    /// The lobe of the ray that goes on; whether the path ends.
    LobeAndRoulette,
    /// Its direction.
    Direction,
    /// The punctual light.
    Light,
    /// The point on that light.
    LightPoint,
    /// The direction to the environment.
    Environment,
    /// The emissive triangle.
    Emitter,
    /// The point on that triangle.
    EmitterPoint,
    /// Whether a transparent surface is passed.
    Coverage,
}

impl Decision {
    /// Its dimension at a surface after `depth` bounces.
    pub(super) fn dimension(self, depth: u32) -> u32 {
        dimension(depth, self as u32)
    }
}

fn dimension(depth: u32, decision: u32) -> u32 {
    depth.wrapping_mul(OF_BOUNCE).wrapping_add(decision)
}

/// The keys of all decisions after some number of bounces. The paths of a wavefront share them.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::integrator) struct BounceKeys {
    /// Seed and number of bounces; `None` before the first use.
    of: Option<(u32, u32)>,
    keys: [DimensionKeys; DECISIONS],
}

impl BounceKeys {
    /// The keys of `sequence` after `depth` bounces. They take the place of `known` unless these are the same.
    pub(super) fn shared(known: &mut Rc<Self>, sequence: &SampleSequence, depth: u32) -> Rc<Self> {
        if known.of != Some((sequence.seed(), depth)) {
            Rc::make_mut(known).prepare(sequence, depth);
        }
        Rc::clone(known)
    }

    fn prepare(&mut self, sequence: &SampleSequence, depth: u32) {
        self.of = Some((sequence.seed(), depth));
        for (decision, keys) in (0..).zip(&mut self.keys) {
            *keys = DimensionKeys::new(sequence.seed(), dimension(depth, decision));
        }
    }
}

/// The sample points of one path after some number of bounces.
#[derive(Clone, Debug)]
pub(super) struct BounceSamples {
    pub(super) sequence: SampleSequence,
    /// The keys of `sequence`.
    pub(super) keys: Rc<BounceKeys>,
}

impl BounceSamples {
    /// The colour channel that goes on.
    pub(super) fn single_channel(&self) -> ColorChannels {
        let u = self.number(Decision::Channel);
        ColorChannels::SINGLE[((u * 3.0) as usize).min(2)]
    }

    /// A number in [0, 1).
    pub(super) fn number(&self, decision: Decision) -> f32 {
        self.sequence.number_by(&self.keys.keys[decision as usize])
    }

    /// A point in the unit square.
    pub(super) fn point(&self, decision: Decision) -> Vec2 {
        self.sequence.point_by(&self.keys.keys[decision as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::zsobol::ZSobol;

    #[test]
    fn samples_by_keys_are_those_of_the_dimensions() {
        let mut keys: Rc<BounceKeys> = Rc::default();
        // Sample 5 is beyond the four of a pixel and has a seed of its own.
        for (depth, sample) in [(0, 1), (3, 1), (3, 5), (0, 2)] {
            let sequence = ZSobol::new(4, 7).sequence((10, 20), sample);
            let samples = BounceSamples { sequence, keys: BounceKeys::shared(&mut keys, &sequence, depth) };
            for decision in [Decision::Channel, Decision::Direction, Decision::Coverage] {
                let dimension = decision.dimension(depth);
                assert_eq!(samples.number(decision), sequence.number(dimension));
                assert_eq!(samples.point(decision), sequence.point(dimension));
            }
        }
    }
}
