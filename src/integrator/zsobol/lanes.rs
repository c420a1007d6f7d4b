//! Sample points of a block, computed in lanes.

use super::{DimensionKeys, SampleSequence};
use crate::geometry::{F32Lanes, LANES, Vec2Lanes};

/// One dimension of one sequence for each lane. All are of one image.
#[derive(Debug, Default)]
pub(crate) struct SequenceLanes {
    reversed_index: [u64; LANES],
    binary_digit: u32,
    shuffle: [u64; LANES],
    x: [u32; LANES],
    y: [u32; LANES],
}

impl SequenceLanes {
    /// Replaces the sequence of a lane and its dimension, which is that of `keys`.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, sequence: &SampleSequence, keys: &DimensionKeys) {
        self.reversed_index[lane] = sequence.reversed_index;
        self.binary_digit = sequence.binary_digit;
        self.shuffle[lane] = keys.shuffle;
        (self.x[lane], self.y[lane]) = (keys.x, keys.y);
    }

    /// [`SampleSequence::point_and_random_by`] of all lanes.
    #[inline(always)]
    pub(crate) fn points_and_randoms(&self, points: &mut Vec2Lanes, randoms: &mut F32Lanes) {
        for (lane, random_of) in randoms.iter_mut().enumerate() {
            let sequence = SampleSequence {
                reversed_index: self.reversed_index[lane],
                binary_digit: self.binary_digit,
                seed: 0,
            };
            let keys = DimensionKeys { shuffle: self.shuffle[lane], x: self.x[lane], y: self.y[lane] };
            let (point, random) = sequence.point_and_random_by(&keys);
            points.set(lane, point);
            *random_of = random;
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;

    use super::super::ZSobol;
    use super::*;
    use crate::geometry::vectorized;

    #[test]
    fn points_in_lanes_are_those_of_their_sequences() {
        for max_samples in [1, 4, 8, 300] {
            let sampler = ZSobol::new(max_samples, 5);
            let lanes = (0..LANES as u32).map(|lane| {
                // Some are beyond the count and have seeds of their own.
                let sequence = sampler.sequence((lane * 97, 4000 - lane), lane % 7);
                (sequence, DimensionKeys::new(sequence.seed(), lane * 3))
            });
            let mut sequences = SequenceLanes::default();
            for (lane, (sequence, keys)) in lanes.clone().enumerate() {
                sequences.set(lane, &sequence, &keys);
            }
            for level in [Level::fallback(), Level::new()] {
                let (mut points, mut randoms) = (Vec2Lanes::default(), F32Lanes::default());
                vectorized!(level, sequences.points_and_randoms(&mut points, &mut randoms));
                for (lane, (sequence, keys)) in lanes.clone().enumerate() {
                    let expected = sequence.point_and_random_by(&keys);
                    assert_eq!((points.get(lane), randoms[lane]), expected, "{max_samples}, {lane}");
                }
            }
        }
    }
}
