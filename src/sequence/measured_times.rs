//! Times of an animation at which it is measured, whatever frames are rendered.

use crate::scene::{Scene, SelectedCamera, Selection};
use crate::uneven::uneven_shares;

use super::job::duration_seconds;

/// Fewest and most measured times of an animation, its first and last among them.
pub(super) const TIMES: [usize; 2] = [5, 17];
/// What is measured: the animation, or one turn of a turntable where that is longer.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredSpan {
    /// Length in seconds, from time 0 on; 0 where nothing moves.
    seconds: f64,
    /// Whether its end is its start.
    is_turn: bool,
}

impl MeasuredSpan {
    /// That of a selection.
    pub(super) fn of(scene: &Scene, selection: &Selection) -> Self {
        let seconds = f64::from(duration_seconds(scene, selection));
        match &selection.camera {
            SelectedCamera::Turntable(turntable) if turntable.turn_seconds > seconds => {
                Self { seconds: turntable.turn_seconds, is_turn: true }
            }
            _ => Self { seconds, is_turn: false },
        }
    }

    /// Whether anything moves.
    pub(super) fn moves(self) -> bool {
        self.seconds > 0.0
    }

    /// `count` times in order: its start, its end unless that is the same, and others between them; the start alone where it is one. What has any period is
    /// seen at several of its states, where the times are many.
    pub(super) fn times(self, count: usize) -> impl Iterator<Item = f64> {
        let end = (count > 1 && !self.is_turn).then_some(1.0);
        let between = uneven_shares(count.saturating_sub(1 + usize::from(end.is_some())));
        std::iter::once(0.0).chain(between).chain(end).map(move |share| self.seconds * share)
    }
}

/// Number of measured times of an animation, where `triangles` are posed at each and at most about `posed_triangles` in all.
pub(super) fn times_of(triangles: usize, posed_triangles: usize, most: usize) -> usize {
    let [fewest, all] = TIMES;
    (posed_triangles / triangles.max(1)).min(most).clamp(fewest, all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_order_from_start_to_end() {
        let span = MeasuredSpan { seconds: 3.0, is_turn: false };
        for count in [2, 5, 17] {
            let times: Vec<_> = span.times(count).collect();
            assert_eq!((times.len(), times.first(), times.last()), (count, Some(&0.0), Some(&3.0)));
            assert!(times.is_sorted());
        }
        assert_eq!(span.times(1).collect::<Vec<_>>(), [0.0]);
    }

    #[test]
    fn the_end_of_a_turn_is_not_measured_again() {
        let times: Vec<_> = MeasuredSpan { seconds: 3.0, is_turn: true }.times(17).collect();
        assert_eq!((times.len(), times[0]), (17, 0.0));
        assert!(times.is_sorted() && times[16] > 2.7 && times[16] < 3.0, "{times:?}");
    }

    #[test]
    fn many_triangles_or_selections_have_the_fewest() {
        assert_eq!(
            [0, 1000, 400_000, 4_000_000].map(|count| times_of(count, 4_000_000, 17)),
            [17, 17, 10, 5]
        );
        assert_eq!([100, 8, 1].map(|most| times_of(0, 4_000_000, most)), [17, 8, 5]);
    }
}
