//! Times of an animation at which it is measured, whatever frames are rendered.

use crate::scene::{Scene, SelectedCamera, Selection};
use crate::uneven::uneven_shares;

use super::job::duration_seconds;

/// Fewest and most measured times of an animation, its first and last among them.
pub(super) const TIMES: [usize; 2] = [5, 17];
/// Number of posed triangles up to which more than the fewest times are measured.
const POSED_TRIANGLES: usize = 4_000_000;
/// Times of all selections that are measured together.
const SHARED_TIMES: usize = 16 * TIMES[1];

/// Length of what is measured, seconds: the animation, and one turn of a turntable. 0 where nothing moves.
pub(super) fn measured_seconds(scene: &Scene, selection: &Selection) -> f64 {
    let animation = f64::from(duration_seconds(scene, selection));
    match &selection.camera {
        SelectedCamera::Turntable(turntable) if turntable.turn_seconds > animation => turntable.turn_seconds,
        _ => animation,
    }
}

/// Number of measured times of an animation, by the number of its triangles and that of the selections that are measured together.
pub(super) fn times_of(triangles: usize, selections: usize) -> usize {
    let [fewest, most] = TIMES;
    let most = (SHARED_TIMES / selections.max(1)).clamp(fewest, most);
    (POSED_TRIANGLES / triangles.max(1)).clamp(fewest, most)
}

/// `count` times of an animation of so many seconds, in order: its start, its end, and others between them; the start alone where it is one. What has any period
/// is seen at several of its states, where the times are many.
pub(super) fn measured_times(duration: f64, count: usize) -> impl Iterator<Item = f64> {
    let between = uneven_shares(count.saturating_sub(2));
    std::iter::once(0.0).chain(between).chain((count > 1).then_some(1.0)).map(move |share| duration * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_order_from_start_to_end() {
        for count in [2, 5, 17] {
            let times: Vec<_> = measured_times(3.0, count).collect();
            assert_eq!((times.len(), times.first(), times.last()), (count, Some(&0.0), Some(&3.0)));
            assert!(times.is_sorted());
        }
        assert_eq!(measured_times(3.0, 1).collect::<Vec<_>>(), [0.0]);
    }

    #[test]
    fn many_triangles_or_selections_have_the_fewest() {
        assert_eq!([times_of(0, 1), times_of(1000, 1), times_of(1_000_000, 1)], [17, 17, 5]);
        assert_eq!([times_of(0, 16), times_of(0, 32), times_of(0, 1000)], [17, 8, 5]);
    }
}
