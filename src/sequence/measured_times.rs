//! Times of an animation at which it is measured, whatever frames are rendered.

use crate::scene::{Scene, SelectedCamera, Selection};
use crate::uneven::uneven_shares;

/// Fewest and most measured times of an animation, its first and last among them.
pub(super) const TIMES: [usize; 2] = [5, 17];

/// What is measured: from the first key to the last, or one turn of a turntable.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredSpan {
    /// Its start, seconds.
    start: f64,
    /// Its length, seconds; 0 where nothing moves.
    length: f64,
    /// Whether its end is its start.
    is_loop: bool,
}

impl MeasuredSpan {
    /// That of a selection. Nothing moves before the first key: shots of films begin at late times. Keys of paths before time 0 are for frames before it, which
    /// must be asked for.
    pub(super) fn of(scene: &Scene, selection: &Selection) -> Self {
        let of_clips = (!selection.clips.is_empty())
            .then(|| [selection.clip_start_seconds(scene), selection.clip_seconds(scene)].map(f64::from));
        let (of_path, is_loop) = match &selection.camera {
            SelectedCamera::Turntable(turntable) => {
                return Self { start: 0.0, length: turntable.turn_seconds, is_loop: true };
            }
            SelectedCamera::Path(path) => {
                (Some([path.start_seconds(), path.duration_seconds]), path.is_loop && of_clips.is_none())
            }
            _ => (None, false),
        };
        let union =
            |[a, b]: [f64; 2], [c, d]: [f64; 2]| [if c < a { c } else { a }, if d > b { d } else { b }];
        let [start, end] = [of_clips, of_path].into_iter().flatten().reduce(union).unwrap_or([0.0; 2]);
        let start = if start > 0.0 { start } else { 0.0 };
        Self { start, length: if end > start { end - start } else { 0.0 }, is_loop }
    }

    /// Whether anything moves.
    pub(super) fn moves(self) -> bool {
        self.length > 0.0
    }

    /// `count` times in order: the start, the end unless that is the same, and others between them; the start alone where it is one. What has any period is
    /// seen at several of its states, where the times are many.
    pub(super) fn times(self, count: usize) -> impl Iterator<Item = f64> {
        let end = (count > 1 && !self.is_loop).then_some(1.0);
        let between = uneven_shares(count.saturating_sub(1 + usize::from(end.is_some())));
        let shares = std::iter::once(0.0).chain(between).chain(end);
        shares.map(move |share| self.start + self.length * share)
    }
}

/// Number of measured times of an animation, where `triangles` are posed at each and at most about `posed_triangles` in all.
pub(super) fn times_of(triangles: usize, posed_triangles: usize, most: usize) -> usize {
    let [fewest, all] = TIMES;
    (posed_triangles / triangles.max(1)).min(most).clamp(fewest, all)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::scene::{
        Animation, AnimationIndex, AnimationTarget, CameraChanges, CameraMotion, CameraPath, Channel,
        Interpolation, Keyframes, NodeIndex,
    };

    fn scene(times_seconds: [f32; 2]) -> Scene {
        let keyframes = Keyframes {
            times_seconds: times_seconds.to_vec(),
            values: vec![0.0; 6],
            width: 3,
            interpolation: Interpolation::Linear,
        };
        let target = AnimationTarget::Translation(NodeIndex(0));
        let animation = Animation { name: None, channels: vec![Channel { target, keyframes }] };
        Scene { animations: vec![animation], ..Scene::default() }
    }

    /// First and last measured times of a scene whose clip has keys at `clip`, seen by a camera that moves between those of `path`.
    fn ends(clip: Option<[f32; 2]>, path: Option<[f32; 2]>, is_loop: bool) -> [f64; 2] {
        let clips = vec![AnimationIndex(0)];
        let path = path.map(|keys| CameraPath {
            motion: CameraMotion::Scene {
                scene: Arc::new(scene(keys)),
                clips: clips.clone(),
                node: NodeIndex(0),
            },
            content_key: String::new(),
            label: String::new(),
            duration_seconds: keys[1].into(),
            is_loop,
        });
        let selection = Selection {
            roots: Vec::new(),
            clips: if clip.is_some() { clips } else { Vec::new() },
            camera: path.map_or(SelectedCamera::Auto, |path| SelectedCamera::Path(Arc::new(path))),
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: None,
        };
        let times: Vec<_> = MeasuredSpan::of(&scene(clip.unwrap_or_default()), &selection).times(9).collect();
        [times[0], times[8]]
    }

    #[test]
    fn spans_hold_all_keys_from_time_0_on() {
        assert_eq!(ends(None, None, false), [0.0, 0.0]);
        assert_eq!(ends(Some([3.0, 5.0]), None, false), [3.0, 5.0]);
        assert_eq!(ends(Some([3.0, 5.0]), Some([4.0, 9.0]), false), [3.0, 9.0]);
        assert_eq!(ends(None, Some([-40.0, 1.0]), false), [0.0, 1.0]);
        assert_eq!(ends(None, Some([-40.0, -2.0]), false), [0.0, 0.0]);
    }

    #[test]
    fn loops_beside_clips_are_measured_to_their_end() {
        assert_eq!(ends(Some([0.0, 4.0]), Some([0.0, 4.0]), true), [0.0, 4.0]);
        let [start, end] = ends(None, Some([1.0, 4.0]), true);
        assert!(start == 0.0 && end > 3.0 && end < 4.0, "{end}");
    }

    #[test]
    fn times_are_in_order_from_start_to_end() {
        let span = MeasuredSpan { start: 2.0, length: 3.0, is_loop: false };
        for count in [2, 5, 17] {
            let times: Vec<_> = span.times(count).collect();
            assert_eq!((times.len(), times.first(), times.last()), (count, Some(&2.0), Some(&5.0)));
            assert!(times.is_sorted());
        }
        assert_eq!(span.times(1).collect::<Vec<_>>(), [2.0]);
    }

    #[test]
    fn the_end_of_a_loop_is_not_measured_again() {
        let times: Vec<_> = MeasuredSpan { start: 0.0, length: 3.0, is_loop: true }.times(17).collect();
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
