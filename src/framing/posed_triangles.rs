//! The triangles of a scene at the times at which it is measured.

use crate::bvh::TriangleFlags;
use crate::geometry::Triangle;

/// Times at which moving scenes are measured, evenly over the clips, both ends included.
pub(super) const TIMES: usize = 65;
/// Most triangles, over all times, that are kept instead of being posed anew for each measurement: 40 MB.
const KEPT_TRIANGLES: usize = 1_000_000;

/// Fewest and most times that may be added to these.
const ADDED: [usize; 2] = [8, 64];

/// The triangles of the scene at one time, by triangle id, with their flags.
#[derive(Debug)]
pub(super) struct PosedTriangles {
    pub(super) triangles: Vec<Triangle>,
    pub(super) flags: Vec<TriangleFlags>,
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

/// Bytes of the triangles that measuring a scene keeps.
pub(crate) fn kept_bytes(triangles: u64, moves: bool) -> u128 {
    let times = if moves { TIMES } else { 1 };
    let count = usize::try_from(triangles).unwrap_or(usize::MAX);
    if !are_kept(count, times) {
        return 0;
    }
    let times = times + most_added(count, times);
    u128::from(triangles) * (times * (size_of::<Triangle>() + size_of::<TriangleFlags>())) as u128
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_moving_triangles_are_kept() {
        assert_eq!(kept_bytes(15_384, true), 15_384 * (65 + 8) * 37);
        assert_eq!(kept_bytes(10, true), 10 * (65 + 64) * 37);
        assert_eq!((kept_bytes(15_385, true), kept_bytes(10, false)), (0, 0));
    }
}
