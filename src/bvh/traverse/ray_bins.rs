//! Rays of an incoherent packet, sorted into bins by dominant direction.

use super::packet::PACKET_SIZE;
use crate::geometry::{Ray, dominant_axes};

/// Bins: along and against each axis.
const BINS: usize = 6;

/// Up to [`PACKET_SIZE`] rays, stably sorted by bin.
pub(super) struct RayBins {
    /// The rays.
    pub(super) rays: [Ray; PACKET_SIZE],
    /// Index of each ray before sorting.
    pub(super) indices: [u8; PACKET_SIZE],
    /// First ray of each bin, and the end of the last bin.
    starts: [usize; BINS + 1],
}

impl RayBins {
    /// Sorts one to [`PACKET_SIZE`] rays.
    pub(super) fn new(rays: &[Ray]) -> Self {
        // Count the rays of each bin.
        let mut bins = [0_u8; PACKET_SIZE];
        let mut starts = [0; BINS + 1];
        for (bin, ray) in bins.iter_mut().zip(rays) {
            let depth = dominant_axes(ray.direction)[2];
            *bin = (2 * depth) as u8 + u8::from(ray.direction[depth] < 0.0);
            starts[usize::from(*bin) + 1] += 1;
        }
        for bin in 0..BINS {
            starts[bin + 1] += starts[bin];
        }

        // Scatter.
        let mut next = starts;
        let mut sorted = Self { rays: [rays[0]; PACKET_SIZE], indices: [0; PACKET_SIZE], starts };
        for (i, (ray, &bin)) in rays.iter().zip(&bins).enumerate() {
            let position = &mut next[usize::from(bin)];
            sorted.rays[*position] = *ray;
            sorted.indices[*position] = i as u8;
            *position += 1;
        }
        sorted
    }

    /// Ranges of the bins that are not empty.
    pub(super) fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + use<'_> {
        self.starts.windows(2).map(|ends| ends[0]..ends[1]).filter(|range| !range.is_empty())
    }
}
