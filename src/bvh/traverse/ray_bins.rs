//! Rays of an incoherent packet, sorted into bins by dominant direction.

use std::ops::Range;

use super::packet::{MIN_PACKET, PACKET_SIZE};
use crate::geometry::{Ray, dominant_axes};

/// Bins: along and against each axis.
const BINS: usize = 6;
/// Bins that spread more than this per unit of depth have little in common unless they hold [`MANY_RAYS`].
const SCATTERED_SPREAD: f32 = 1.0;
/// See [`SCATTERED_SPREAD`].
const MANY_RAYS: usize = 48;

/// What the rays of a bin have in common.
#[derive(Clone, Copy)]
struct Bin {
    /// Number of rays.
    count: usize,
    /// First ray.
    first: usize,
    /// Whether all rays start at one point.
    has_one_origin: bool,
    /// Least and largest lateral movement per unit of depth.
    slope: [[f32; 2]; 2],
}

/// One to [`PACKET_SIZE`] rays by bin.
pub(super) struct RayBins<'a> {
    rays: &'a [Ray],
    /// Bin of each ray.
    numbers: [u8; PACKET_SIZE],
    bins: [Bin; BINS],
}

/// Rays stably sorted by bin.
pub(super) struct SortedRays {
    /// The rays.
    pub(super) rays: [Ray; PACKET_SIZE],
    /// Index of each ray before sorting.
    pub(super) indices: [u8; PACKET_SIZE],
    /// First ray of each bin, and the end of the last bin.
    starts: [usize; BINS + 1],
    /// Bins that are worth a packet.
    is_coherent: [bool; BINS],
}

/// Whether some of these rays surely differ in depth axis or sense. Looks at four of them only.
pub(super) fn differ(rays: &[Ray]) -> bool {
    let [Some(first), Some(last)] = [rays.first(), rays.last()] else { return false };
    let axes = dominant_axes(first.direction);
    let third = rays.len() / 3;
    [last, &rays[third], &rays[2 * third]].iter().any(|ray| dominant_axes(ray.direction) != axes)
}

impl Bin {
    const EMPTY: Self = Self {
        count: 0,
        first: 0,
        has_one_origin: true,
        slope: [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]],
    };

    /// Whether the rays are coherent enough to be traversed as a packet.
    fn is_coherent(&self) -> bool {
        let [low, high] = self.slope;
        let spread = (high[0] - low[0]).max(high[1] - low[1]);
        self.count >= MANY_RAYS
            || self.count >= MIN_PACKET && (self.has_one_origin || spread < SCATTERED_SPREAD)
    }
}

impl<'a> RayBins<'a> {
    /// Assigns the rays to bins.
    pub(super) fn new(rays: &'a [Ray]) -> Self {
        let mut numbers = [0; PACKET_SIZE];
        let mut bins = [Bin::EMPTY; BINS];
        for (i, (number, ray)) in numbers.iter_mut().zip(rays).enumerate() {
            let [x, y, depth] = dominant_axes(ray.direction);
            let direction = ray.direction.to_array();
            *number = (2 * depth) as u8 + u8::from(direction[depth] < 0.0);
            let bin = &mut bins[usize::from(*number)];
            if bin.count == 0 {
                bin.first = i;
            }
            bin.count += 1;
            bin.has_one_origin &= ray.origin == rays[bin.first].origin;
            // Against an axis the two lateral ones change places, which the spread does not depend on.
            let over_depth = direction[depth].recip();
            let slope = [direction[x] * over_depth, direction[y] * over_depth];
            for (lateral, slope) in slope.into_iter().enumerate() {
                bin.slope[0][lateral] = bin.slope[0][lateral].min(slope);
                bin.slope[1][lateral] = bin.slope[1][lateral].max(slope);
            }
        }
        Self { rays, numbers, bins }
    }

    /// Whether any bin is worth a packet.
    pub(super) fn has_packets(&self) -> bool {
        self.bins.iter().any(Bin::is_coherent)
    }

    /// Sorts the rays by bin.
    pub(super) fn sorted(&self) -> SortedRays {
        let mut starts = [0; BINS + 1];
        for (i, bin) in self.bins.iter().enumerate() {
            starts[i + 1] = starts[i] + bin.count;
        }
        let mut next = starts;
        let mut sorted = SortedRays {
            rays: [self.rays[0]; PACKET_SIZE],
            indices: [0; PACKET_SIZE],
            starts,
            is_coherent: self.bins.map(|bin| bin.is_coherent()),
        };
        for (i, (ray, &bin)) in self.rays.iter().zip(&self.numbers).enumerate() {
            let position = &mut next[usize::from(bin)];
            sorted.rays[*position] = *ray;
            sorted.indices[*position] = i as u8;
            *position += 1;
        }
        sorted
    }
}

impl SortedRays {
    /// Ranges of the bins that are not empty, and whether each is worth a packet.
    pub(super) fn bins(&self) -> impl Iterator<Item = (Range<usize>, bool)> + use<'_> {
        let ranges = self.starts.windows(2).map(|ends| ends[0]..ends[1]);
        ranges.zip(self.is_coherent).filter(|(range, _)| !range.is_empty())
    }
}
