//! Random numbers as a pure function of pixel, time, sample and purpose, so that images do not depend on the order of work.
//!
//! The samples of a pixel are the points of Sobol's first two dimensions, scrambled and shuffled by hashes of pixel, time and purpose, so
//! that points for two purposes are independent (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020).

use glam::Vec2;

use super::unit_interval::unit_interval;
use super::zsobol::{scramble, scrambled_point};

/// The steps of R₂ (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018) along both axes: 2³² over the plastic number,
/// and over its square.
pub const R2: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// Seed of the random numbers of one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seed {
    /// Hash of pixel, time and the chain of child rays.
    stream: u32,
    /// Index of the sample in its stream.
    index: u32,
}

/// The decision that a random number is for. Each purpose has its own numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The point on the lens.
    Lens,
    /// The point on the light with this index.
    Light(u32),
    /// The direction in a rough reflection lobe.
    Reflection,
    /// The direction in a rough transmission lobe.
    Refraction,
    /// The direction in the lobe of a rough coat.
    Coat,
    /// Whether a facet reflects or refracts.
    Facet,
}

impl Purpose {
    fn number(self) -> u32 {
        match self {
            Self::Lens => 0,
            Self::Reflection => 1,
            Self::Refraction => 2,
            Self::Coat => 3,
            Self::Facet => 4,
            Self::Light(index) => 16 + index,
        }
    }
}

impl Seed {
    /// The seed of sample `index` of a pixel at a time.
    pub fn new(pixel: (u32, u32), time_seconds: f32, index: u32) -> Self {
        Self::of_hashed_time(Self::hashed_time(time_seconds), pixel, index)
    }

    /// The part of [`Seed::new`] that a frame's samples share.
    pub(super) fn hashed_time(time_seconds: f32) -> u32 {
        hash(time_seconds.to_bits())
    }

    /// [`Seed::new`] from [`Seed::hashed_time`].
    #[inline]
    pub(super) fn of_hashed_time(hashed_time: u32, (x, y): (u32, u32), index: u32) -> Self {
        Self { stream: hash(hash(hashed_time ^ x) ^ y), index }
    }

    /// The seed of child ray `number` of `count` for a purpose.
    #[must_use]
    pub fn child(self, purpose: Purpose, number: u32, count: u32) -> Self {
        let stream = hash(self.stream ^ hash(purpose.number() + 1));
        Self { stream, index: self.index.wrapping_mul(count).wrapping_add(number) }
    }

    /// A point in the unit square.
    pub fn point(self, purpose: Purpose) -> Vec2 {
        let x = hash(self.stream ^ hash(purpose.number()));
        let y = hash(x);
        // In the same order, points of two purposes or bounces would depend on each other.
        let index = shuffled(self.index, hash(y));
        scrambled_point(u64::from(index), [x, y])
    }

    /// A number in [0, 1), independent of all points: white noise.
    pub fn random(self, purpose: Purpose) -> f32 {
        unit_interval(hash(hash(self.stream ^ hash(purpose.number())) ^ hash(self.index)))
    }
}

/// The position of an index in a nested uniform shuffle: aligned blocks of a power of two indices stay together.
fn shuffled(index: u32, key: u32) -> u32 {
    scramble(index.reverse_bits(), key)
}

/// A point of the unit square, moved around it by a number of steps of R₂.
pub(super) fn r2_moved(point: Vec2, steps: u32) -> Vec2 {
    let [x, y] = R2.map(|step| unit_interval(step.wrapping_mul(steps)));
    (point + Vec2::new(x, y)).fract()
}

/// A bijection of 32 bits that flips about half of them (Wellons, "Prospecting for Hash Functions", 2018).
pub(super) fn hash(mut x: u32) -> u32 {
    x = x.wrapping_add(0x9E37_79B9);
    x ^= x >> 16;
    x = x.wrapping_mul(0x21F0_AAAD);
    x ^= x >> 15;
    x = x.wrapping_mul(0x735A_2D97);
    x ^ x >> 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_pixel_fill_the_square_evenly() {
        for purpose in [Purpose::Lens, Purpose::Light(3)] {
            let mut cells = [0; 16];
            for index in 0..256 {
                let p = Seed::new((7, 9), 0.5, index).point(purpose);
                assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
                cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
            }
            assert_eq!(cells, [16; 16]);
        }
    }

    /// Counts of pairs of points in the cells of a 4 by 4 grid, by the first coordinate of each.
    fn joint_counts(points: impl Fn(u32) -> [Vec2; 2]) -> [u32; 16] {
        let mut cells = [0; 16];
        for index in 0..4096 {
            let [a, b] = points(index);
            cells[(a.x * 4.0) as usize * 4 + (b.x * 4.0) as usize] += 1;
        }
        cells
    }

    #[test]
    fn points_of_purposes_and_bounces_are_independent() {
        let seed = |index| Seed::new((7, 9), 0.5, index);
        let purposes = joint_counts(|i| [Purpose::Lens, Purpose::Light(0)].map(|p| seed(i).point(p)));
        let bounces = joint_counts(|i| {
            let first = seed(i).child(Purpose::Reflection, 0, 1);
            [first, first.child(Purpose::Reflection, 0, 1)].map(|seed| seed.point(Purpose::Reflection))
        });
        let facets = joint_counts(|i| {
            let seed = seed(i);
            [seed.point(Purpose::Refraction), Vec2::splat(seed.random(Purpose::Facet))]
        });
        // 256 pairs a cell, with a standard deviation of 15.5 were they random.
        for cells in [purposes, bounces, facets] {
            assert!(cells.iter().all(|count| (190..=322).contains(count)), "{cells:?}");
        }
    }

    #[test]
    fn aligned_blocks_of_samples_fill_the_square_evenly() {
        for first in [0, 16, 240] {
            let (mut columns, mut cells) = ([0; 16], [0; 16]);
            for index in first..first + 16 {
                let p = Seed::new((7, 9), 0.5, index).point(Purpose::Light(3));
                columns[(p.x * 16.0) as usize] += 1;
                cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
            }
            assert_eq!((columns, cells), ([1; 16], [1; 16]));
        }
    }

    #[test]
    fn pixels_times_purposes_and_children_differ() {
        let seed = Seed::new((3, 4), 0.0, 0);
        let point = seed.point(Purpose::Lens);
        for other in [Seed::new((4, 3), 0.0, 0), Seed::new((3, 4), 1.0, 0), Seed::new((3, 4), 0.0, 1)] {
            assert_ne!(other.point(Purpose::Lens), point);
        }
        assert_ne!(seed.point(Purpose::Reflection), point);
        let (first, second) = (seed.child(Purpose::Reflection, 0, 4), seed.child(Purpose::Reflection, 1, 4));
        assert_ne!(first.point(Purpose::Reflection), second.point(Purpose::Reflection));
        assert_ne!(first, seed.child(Purpose::Refraction, 0, 4));
    }

    #[test]
    fn the_mean_over_pixels_is_the_center() {
        // 10 000 independent uniform numbers: standard deviation of the mean 0.0029.
        let points = (0..10_000).map(|i| Seed::new((i % 100, i / 100), 0.0, 0).point(Purpose::Lens));
        let mean = points.sum::<Vec2>() / 10_000.0;
        assert!((mean - Vec2::splat(0.5)).abs().max_element() < 0.012, "{mean}");
    }
}
