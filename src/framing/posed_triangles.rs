//! The triangles of a scene at the times at which it is measured.

use super::blocks::block_bytes;
use crate::bvh::TriangleFlags;
use crate::geometry::{Aabb, Triangle};

/// Times at which moving scenes are measured, evenly over the clips, both ends included.
pub(super) const TIMES: usize = 65;
/// Fewest times of a clip where several are measured one by one.
const FEWEST_CLIP_TIMES: usize = 17;
/// Most triangles, over all times, that are kept instead of being posed anew for each measurement: 40 MB.
const KEPT_TRIANGLES: usize = 1_000_000;

/// Fewest and most times that may be added to these.
const ADDED: [usize; 2] = [8, 64];

/// Number of triangles whose positions are ranked.
pub(super) const SAMPLED_TRIANGLES: usize = 65_536;

/// The triangles of the scene at one time, by triangle id, with their flags.
#[derive(Debug)]
pub(super) struct PosedTriangles {
    pub(super) triangles: Vec<Triangle>,
    pub(super) flags: Vec<TriangleFlags>,
}

/// A triangle that stands for others.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledTriangle {
    /// Its id.
    pub(super) index: usize,
    /// At one time.
    pub(super) bounds: Aabb,
}

/// Bytes of the samples of so many triangles at so many times.
fn sample_bytes(triangles: usize, times: usize) -> usize {
    triangles.saturating_mul(times).min(2 * SAMPLED_TRIANGLES) * size_of::<SampledTriangle>()
}

/// Whether the triangles at all times are kept.
pub(super) fn are_kept(triangles: usize, times: usize) -> bool {
    times > 1 && triangles.saturating_mul(times) <= KEPT_TRIANGLES
}

/// Number of times that may be added: few where there are many triangles.
pub(super) fn most_added(triangles: usize, times: usize) -> usize {
    let [fewest, most] = ADDED;
    (KEPT_TRIANGLES / triangles.max(1)).saturating_sub(times).clamp(fewest, most)
}

/// Even times at which each of so many selections is measured that move surfaces.
pub(super) fn times_of_each(selections: usize) -> usize {
    (4 * TIMES / selections.max(1)).clamp(FEWEST_CLIP_TIMES, TIMES)
}

/// Bytes that measuring a scene keeps of its triangles, while so many selections move them or none does.
pub(crate) fn kept_bytes(triangles: u64, selections: usize, moves: bool) -> u128 {
    let count = usize::try_from(triangles).unwrap_or(usize::MAX);
    let times = if moves { times_of_each(selections).saturating_mul(selections) } else { 1 };
    let added = if moves { most_added(count, times) } else { 0 };
    let looked_at = (block_bytes(count, times, added) + sample_bytes(count, times)) as u128;
    if !are_kept(count, times) {
        return looked_at;
    }
    let of_triangle = (times + added) * (size_of::<Triangle>() + size_of::<TriangleFlags>());
    u128::from(triangles) * of_triangle as u128 + looked_at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_moving_triangles_are_kept() {
        let looked_at = |triangles: usize, times: usize, added: usize| {
            (block_bytes(triangles, times, added) + sample_bytes(triangles, times)) as u128
        };
        assert_eq!(kept_bytes(15_384, 1, true), 15_384 * (65 + 8) * 37 + looked_at(15_384, 65, 8));
        assert_eq!(kept_bytes(10, 1, true), 10 * (65 + 64) * 37 + looked_at(10, 65, 64));
        assert_eq!(kept_bytes(15_385, 1, true), looked_at(15_385, 65, 8));
        assert_eq!(kept_bytes(10, 1, false), looked_at(10, 1, 0));
        // 30 clips are measured at 17 times each.
        assert_eq!(kept_bytes(218_000, 30, true), looked_at(218_000, 510, 8));
        assert!(kept_bytes(218_000, 30, true) > 24_000_000);
        // Boxes and samples of many triangles take no more memory than those of some.
        assert!(kept_bytes(200_000_000, 1, true) < 34_000_000);
    }
}
