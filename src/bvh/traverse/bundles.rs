//! Sorting the rays of a tile by direction, where they do not all run the same way.

use super::tile::TILE;
use crate::geometry::{Ray, dominant_axes};

/// Directions that rays are told apart by: along or against each axis.
const WAYS: usize = 6;

/// Up to [`TILE`] rays, those that run the same way next to each other.
pub(super) struct Bundles {
    /// The rays.
    pub(super) rays: [Ray; TILE],
    /// The subscript that each of them came with.
    pub(super) from: [u8; TILE],
    /// Where each way begins, and where the last ends.
    pub(super) starts: [usize; WAYS + 1],
}

impl Bundles {
    /// Sorts up to [`TILE`] rays; the order of those that run the same way is kept.
    pub(super) fn new(rays: &[Ray]) -> Self {
        let mut ways = [0_u8; TILE];
        let mut starts = [0; WAYS + 1];
        for (way, ray) in ways.iter_mut().zip(rays) {
            let depth = dominant_axes(ray.direction)[2];
            *way = (2 * depth) as u8 + u8::from(ray.direction[depth] < 0.0);
            starts[usize::from(*way) + 1] += 1;
        }
        for way in 0..WAYS {
            starts[way + 1] += starts[way];
        }
        let mut next = starts;
        let mut sorted = Self { rays: [rays[0]; TILE], from: [0; TILE], starts };
        for (i, (ray, &way)) in rays.iter().zip(&ways).enumerate() {
            let place = &mut next[usize::from(way)];
            sorted.rays[*place] = *ray;
            sorted.from[*place] = i as u8;
            *place += 1;
        }
        sorted
    }

    /// The ranges of rays that run the same way.
    pub(super) fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + use<'_> {
        self.starts.windows(2).map(|ends| ends[0]..ends[1]).filter(|range| !range.is_empty())
    }
}
