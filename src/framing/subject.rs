//! What a camera frames: the visible triangles of the scene, or of a node, over the selected clips.

use std::collections::BTreeSet;

use glam::Vec3;

use crate::bvh::{TriangleFlags, is_traced};
use crate::frame::Frame;
use crate::geometry::{Aabb, Triangle};
use crate::scene::{AnimationIndex, NodeIndex, Scene, Selection};

use super::blocks::Blocks;
use super::extent::Extent;
use super::moving_surfaces::moves_surfaces;
use super::posed_triangles::{PosedTriangles, SampledTriangle, are_kept, times_of_each};

/// Fewest times where the scene has many triangles.
const FEWEST_TIMES: usize = 9;
/// Products of corners, times and directions that a measurement may take before it uses fewer times.
const PRODUCTS: usize = 400_000_000;
/// Triangles of one parallel task.
pub(super) const TRIANGLES_PER_TASK: usize = 8192;

/// Visible triangles over the selected clips, without backdrops.
#[derive(Debug)]
pub(super) struct Subject<'a> {
    pub(super) scene: &'a Scene,
    /// What is posed: the selected clips together, or each of the measured clips alone.
    pub(super) selections: Vec<Selection>,
    /// Times at which it is measured, each with the index of its selection: the even ones, then those that were added.
    pub(super) times: Vec<(usize, f64)>,
    /// Number of the even times.
    pub(super) even_times: usize,
    /// The scene at the first time.
    pub(super) frame: Frame,
    /// The triangles at the other times, where they are few enough to be kept.
    pub(super) kept: Option<Vec<PosedTriangles>>,
    /// Boxes of the triangles at all times.
    pub(super) blocks: Blocks,
    /// Some of the triangles over the even times, which [`Self::content`] ranks.
    pub(super) samples: Vec<SampledTriangle>,
    /// Whether a triangle belongs to the framed node, by its id; `None` where the whole scene is framed.
    pub(super) follows_node: Option<Vec<bool>>,
    /// Whether an instance is framed, by its index in the frame.
    pub(super) is_framed: Vec<bool>,
    /// Whether an instance may be a floor under what is framed: it is a shadow catcher or a backdrop.
    pub(super) may_be_floor: Vec<bool>,
    /// Whether a triangle is far from the rest at all times, by its id; `None` where none is.
    pub(super) is_outlier: Option<Vec<bool>>,
    /// Bounds over all times; where nothing is visible, two metres around the framed node or the origin.
    pub(super) bounds: Aabb,
    /// Whether nothing is visible.
    pub(super) is_empty: bool,
}

impl<'a> Subject<'a> {
    /// Measures the scene, or the nodes below `node`, while the clips of `selection` play together; where `clips` are given, while
    /// each of these plays alone.
    ///
    /// Of a whole scene, large instances with few triangles around all others (skies, ground planes) are left out, and so are
    /// triangles far from the rest.
    pub(super) fn measure(
        scene: &'a Scene,
        selection: &Selection,
        node: Option<NodeIndex>,
        clips: &[AnimationIndex],
    ) -> Self {
        let mut frame = Frame::default();
        let alone = clips.iter().map(|&clip| Selection { clips: vec![clip], ..selection.clone() });
        let mut selections: Vec<Selection> = alone.collect();
        if selections.is_empty() {
            selections.push(selection.clone());
        }
        let times = sample_times(scene, &selections);
        frame.pose_surfaces(scene, &selections[0], 0.0);
        let follows_node = node.map(|node| frame.triangles_of_node(scene, node));
        let is_framed = frame.instances.iter().enumerate().map(|(index, instance)| {
            let mut triangles = frame.triangle_range(index);
            let is_selected =
                follows_node.as_ref().is_none_or(|follows| triangles.any(|triangle| follows[triangle]));
            is_selected && !frame.materials[instance.material.index()].is_shadow_catcher
        });
        let is_framed = is_framed.collect();
        let catchers = frame
            .instances
            .iter()
            .map(|instance| node.is_none() && frame.materials[instance.material.index()].is_shadow_catcher);
        let may_be_floor = catchers.collect();
        let mut subject = Self {
            scene,
            selections,
            even_times: times.len(),
            times,
            frame,
            kept: None,
            blocks: Blocks::new(0, 0),
            samples: Vec::new(),
            follows_node,
            is_framed,
            may_be_floor,
            is_outlier: None,
            bounds: Aabb::EMPTY,
            is_empty: false,
        };
        subject.keep_triangles();
        let extents = subject.look_at_times();
        if node.is_none() {
            subject.leave_out_backdrops(&extents);
        }
        let framed = extents.iter().zip(&subject.is_framed).filter(|(_, is_framed)| **is_framed);
        subject.bounds = framed.fold(Aabb::EMPTY, |bounds, (instance, _)| bounds.union(instance.path));
        if node.is_none() {
            subject.leave_out_outliers(&extents);
        }
        subject.add_times();
        subject.is_empty = subject.bounds.is_empty();
        if subject.is_empty {
            let center = node.and_then(|node| subject.frame.node_position(node)).unwrap_or(Vec3::ZERO);
            subject.bounds = Aabb { min: center - Vec3::ONE, max: center + Vec3::ONE };
        }
        subject
    }

    /// Every how many even times are visited to multiply all corners by so many directions.
    pub(super) fn stride(&self, directions: usize) -> usize {
        let products = (self.frame.triangles.len() * 3 * directions).max(1);
        let most = self.even_times.max(FEWEST_TIMES);
        let count = (PRODUCTS / products).clamp(FEWEST_TIMES, most);
        ((most - 1) / (count - 1)).max(1)
    }

    /// The bounds of the instances that may be floors over all times, each with its lowest point along the unit vector `up`.
    pub(super) fn floors(&self, up: Vec3) -> Vec<(f32, Aabb)> {
        let mut floors = vec![(f32::INFINITY, Aabb::EMPTY); self.may_be_floor.len()];
        if !self.may_be_floor.contains(&true) {
            return Vec::new();
        }
        self.visit(1, |triangles, flags| {
            for (index, &instance) in self.frame.instance_of_triangle.iter().enumerate() {
                let instance = instance as usize;
                let triangle = &triangles[index];
                if self.may_be_floor[instance] && is_traced(triangle, flags[index]) {
                    let [a, b, c] = triangle.vertices.map(|corner| corner.dot(up));
                    let (lowest, bounds) = floors[instance];
                    floors[instance] = (lowest.min(a).min(b).min(c), bounds.union(triangle.bounds()));
                }
            }
        });
        floors.retain(|(_, bounds)| !bounds.is_empty());
        floors
    }

    /// Indices of the nodes that are framed.
    pub(super) fn framed_nodes(&self) -> BTreeSet<u32> {
        let framed = self.frame.instances.iter().zip(&self.is_framed).filter(|(_, is_framed)| **is_framed);
        framed.map(|(instance, _)| instance.node.0).collect()
    }

    /// Number of framed instances of nodes, each of which may have several mesh instances.
    pub(super) fn framed_node_instances(&self) -> usize {
        let framed = self.frame.instances.iter().zip(&self.is_framed).filter(|(_, is_framed)| **is_framed);
        framed.map(|(instance, _)| (instance.node, instance.node_instance)).collect::<BTreeSet<_>>().len()
    }

    /// Whether the instance with this index is framed.
    pub(super) fn frames_instance(&self, instance: u32) -> bool {
        self.is_framed[instance as usize]
    }

    /// Looks at all times once: for the boxes and the samples of triangles. Returns the extent of each framed instance.
    fn look_at_times(&mut self) -> Vec<Extent> {
        let count = self.frame.triangles.len();
        let mut extents = vec![Extent::NOWHERE; self.is_framed.len()];
        let mut blocks = Blocks::new(count, self.times.len());
        let mut samples = Vec::new();
        self.visit(1, |triangles, flags| {
            self.extend_extents(&mut extents, triangles, flags);
            blocks.add(blocks.boxes(triangles, flags));
            samples.extend(self.sampled(triangles, flags));
        });
        (self.blocks, self.samples) = (blocks, samples);
        extents
    }

    /// Keeps the triangles at all times, if they are few.
    fn keep_triangles(&mut self) {
        if are_kept(self.frame.triangles.len(), self.times.len()) {
            let mut kept = Vec::new();
            self.visit(1, |triangles, flags| {
                kept.push(PosedTriangles { triangles: triangles.to_vec(), flags: flags.to_vec() });
            });
            self.kept = Some(kept);
        }
    }

    /// Indices of every `stride`-th of the even times, and of those that were added.
    pub(super) fn visited_times(&self, stride: usize) -> impl Iterator<Item = usize> {
        (0..self.even_times).step_by(stride).chain(self.even_times..self.times.len())
    }

    /// Calls `visit` with the triangles and their flags at every `stride`-th of the even times, and at those that were added.
    pub(super) fn visit(&self, stride: usize, mut visit: impl FnMut(&[Triangle], &[TriangleFlags])) {
        let mut poses = TimePoses::new(self);
        for time in self.visited_times(stride) {
            let (triangles, flags) = poses.at(time);
            visit(triangles, flags);
        }
    }

    /// Whether the triangle `index` is framed where it is posed like this. What has a scale of 0 is not: rays never hit it.
    pub(super) fn frames_triangle(&self, index: usize, triangle: &Triangle, flags: TriangleFlags) -> bool {
        self.may_frame_triangle(index) && is_traced(triangle, flags)
    }

    /// Whether the triangle `index` is framed where rays hit it.
    pub(super) fn may_frame_triangle(&self, index: usize) -> bool {
        self.is_framed[self.frame.instance_of_triangle[index] as usize]
            && self.follows_node.as_ref().is_none_or(|follows| follows[index])
            && self.is_outlier.as_ref().is_none_or(|is_outlier| !is_outlier[index])
    }
}

/// The triangles of a subject at one of its times after the other.
pub(super) struct TimePoses<'s> {
    subject: &'s Subject<'s>,
    frame: Frame,
    /// Index of the selection that the frame was posed with.
    posed: Option<usize>,
}

impl<'s> TimePoses<'s> {
    pub(super) fn new(subject: &'s Subject<'s>) -> Self {
        Self { subject, frame: Frame::of_positions(), posed: None }
    }

    /// The triangles and their flags at the time with this index.
    pub(super) fn at(&mut self, time: usize) -> (&[Triangle], &[TriangleFlags]) {
        let subject = self.subject;
        if let Some(PosedTriangles { triangles, flags }) = subject.kept.as_ref().map(|kept| &kept[time]) {
            return (triangles, flags);
        }
        if time == 0 {
            return (&subject.frame.triangles, &subject.frame.flags);
        }
        let (selection, seconds) = subject.times[time];
        let of_clips = &subject.selections[selection];
        if self.posed == Some(selection) {
            self.frame.pose_surfaces_again(subject.scene, of_clips, seconds);
        } else {
            self.frame.pose_surfaces(subject.scene, of_clips, seconds);
        }
        self.posed = Some(selection);
        (&self.frame.triangles, &self.frame.flags)
    }
}

/// Times of every selection: many of a single one, fewer of each of several, and one where nothing moves.
fn sample_times(scene: &Scene, selections: &[Selection]) -> Vec<(usize, f64)> {
    let count = times_of_each(selections.len());
    let mut times = Vec::new();
    for (index, selection) in selections.iter().enumerate() {
        let duration = f64::from(selection.clip_seconds(scene));
        if duration > 0.0 && moves_surfaces(scene, selection) {
            times.extend((0..count).map(|i| (index, duration * i as f64 / (count - 1) as f64)));
        } else {
            times.push((index, 0.0));
        }
    }
    times
}
