//! Refit of the last frame's wide tree to moved triangles, instead of a rebuild.
//!
//! The topology stays. Leaves get the new corners, and boxes are updated bottom-up. This requires that the tree holds exactly
//! the traced triangles: none was hidden, shown, or lost its area. Where triangles are split, each leaf keeps the part that it
//! covers ([`parts`]). The tree stays good while triangles keep their neighbours. Its quality is the ratio of its surface area
//! heuristic cost to the least cost since it was built.
//!
//! # When refitting pays
//!
//! Refitting saves [`SAVED_NS_PER_REFERENCE`], and for clustered trees [`CLUSTERING_NS_PER_REFERENCE`] as well. It costs every ray the loss of
//! quality. The SAH cost is the number of nodes and leaves that a long ray visits, at about [`NS_PER_VISIT`] each. A refitted
//! tree of cost `C` over `n` references is therefore kept for `r` rays if `r (C − C_least) visit ≤ n saved`. Otherwise the tree is
//! rebuilt and the time of the attempt is lost. The number of frames until the next attempt doubles with each failure, up to
//! [`MAX_PAUSE`]; a success resets it. With [`Refit::Auto`], trees of split triangles are always rebuilt: their parts take longer to follow than
//! the references to sort. [`Refit::UpTo`] refits them in parts.

mod parts;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rayon::prelude::*;

use self::parts::Part;
use super::cost_model::CLUSTERING_NS_PER_REFERENCE;
use crate::bvh::is_traced;
use crate::bvh::references::{Input, padding as padding_of};
use crate::bvh::settings::{BuildSettings, BuilderKind, Refit};
use crate::bvh::statistics::{BuildStatistics, RebuildReason};
use crate::bvh::triangle_flags::TriangleFlags;
use crate::bvh::wide_tree::{Leaf, NO_CHILD, Tag, WIDTH, WORDS_PER_SLOT, WideNode, WideTree, slot_words};
use crate::cancel::Cancelled;
use crate::geometry::{Aabb, Triangle};
use glam::Vec3;

/// Nanoseconds per reference that building the radix tree takes beyond refitting; measured, some 45 against 15.
const SAVED_NS_PER_REFERENCE: f64 = 30.0;
/// Nanoseconds of a ray's visit of a node or leaf, its share of shading included.
const NS_PER_VISIT: f64 = 12.0;
/// Maximum of frames that are rebuilt without an attempt after failures.
const MAX_PAUSE: u32 = 64;

/// Leaf slots per task.
const SLOTS_PER_TASK: usize = 1 << 12;
/// Nodes per task.
const NODES_PER_TASK: usize = 1 << 8;
/// Levels of the wide tree whose children are tasks of their own.
const PARALLEL_LEVELS: u32 = 4;

/// State of refitting between frames, and its scratch memory.
#[derive(Debug, Default)]
pub(crate) struct Refitter {
    /// Number of triangles of each leaf, at its first slot.
    counts: Vec<u8>,
    /// Box of each leaf, at its first slot.
    leaf_boxes: Vec<Aabb>,
    /// Part of the triangle at each slot; empty where no triangle is split.
    parts: Vec<Part>,
    /// Box of each node.
    boxes: Vec<NodeBox>,
    /// Least SAH cost since the tree was built, which a new tree would have too; `None` until it is first needed.
    least_cost: Option<f64>,
    /// Frames to rebuild before the next attempt.
    pause: u32,
    /// Value of `pause` after the next failure.
    next_pause: u32,
}

/// Outcome of an attempt to refit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Attempt {
    /// The tree was refitted.
    Refitted {
        /// SAH cost over the least since the tree was built.
        cost_ratio: f64,
    },
    /// The tree must be rebuilt.
    Rebuild(RebuildReason),
}

/// Box of a node, written by one task and read by another.
#[derive(Debug, Default)]
struct NodeBox([AtomicU32; 6]);

/// Consecutive leaves that one task refits.
struct LeafTask<'a> {
    counts: &'a [u8],
    boxes: &'a mut [Aabb],
    words: &'a mut [f32],
    /// Parts from the first slot on, unless all triangles are whole.
    parts: &'a [Part],
}

/// Box and cost of a subtree; the cost is in square metres.
#[derive(Clone, Copy)]
struct Fitted {
    bounds: Aabb,
    cost: f64,
}

impl Refitter {
    /// Resets the state after a rebuild.
    pub(crate) fn forget(&mut self) {
        self.counts.clear();
        self.least_cost = None;
    }

    /// Refits `tree`, whose build had the statistics `built`, to the new triangles. If the tree must be rebuilt, its contents are
    /// unspecified.
    pub(crate) fn attempt(
        &mut self,
        tree: &mut WideTree,
        built: &BuildStatistics,
        input: Input,
        settings: &BuildSettings,
    ) -> Result<Attempt, Cancelled> {
        let traced = built.triangles;
        let is_split = built.references != traced;
        if settings.refit == Refit::Off {
            return Ok(Attempt::Rebuild(RebuildReason::RefittingOff));
        }
        // A single leaf has no nodes either.
        if tree.nodes.is_empty() {
            return Ok(Attempt::Rebuild(RebuildReason::NoPreviousTree));
        }
        if is_split && settings.refit == Refit::Auto {
            return Ok(Attempt::Rebuild(RebuildReason::SplitTriangles));
        }
        if self.pause > 0 {
            self.pause -= 1;
            return Ok(Attempt::Rebuild(RebuildReason::Pausing));
        }
        if !has_count(input, traced) {
            return Ok(Attempt::Rebuild(RebuildReason::OtherTriangles));
        }
        let least_cost = self.cost_before(tree, is_split);
        if !self.move_triangles(tree, input)? {
            return Ok(Attempt::Rebuild(RebuildReason::OtherTriangles));
        }

        // Boxes of nodes, and their cost.
        let cost = self.fit_boxes(tree).cost_per_ray();
        // NaN fails, too.
        let pays = cost <= max_cost(least_cost, built, settings);
        if !pays {
            self.pause = self.next_pause;
            self.next_pause = (2 * self.next_pause).clamp(1, MAX_PAUSE);
            return Ok(Attempt::Rebuild(RebuildReason::CostRatioTooHigh));
        }
        let nodes = tree.nodes.par_iter_mut().with_min_len(NODES_PER_TASK);
        nodes.for_each(|node| self.store_boxes(node));
        self.next_pause = 0;
        self.least_cost = Some(if cost < least_cost { cost } else { least_cost });
        Ok(Attempt::Refitted { cost_ratio: cost / least_cost })
    }

    /// Least SAH cost so far; computed when it is first needed.
    fn cost_before(&mut self, tree: &WideTree, is_split: bool) -> f64 {
        if let Some(cost) = self.least_cost {
            return cost;
        }
        self.list_leaves(tree);
        self.list_parts(tree, is_split);
        self.boxes.resize_with(tree.nodes.len(), NodeBox::default);
        self.fit_boxes(tree).cost_per_ray()
    }

    /// Lists the first slots and boxes of all leaves.
    fn list_leaves(&mut self, tree: &WideTree) {
        self.counts.clear();
        self.counts.resize(tree.slots(), 0);
        self.leaf_boxes.resize(tree.slots(), Aabb::EMPTY);
        for node in &tree.nodes {
            for (lane, &child) in node.children.iter().enumerate().filter(|&(_, &child)| child != NO_CHILD) {
                if let Some(leaf) = Leaf::of(child) {
                    self.counts[leaf.first()] = leaf.count() as u8;
                    self.leaf_boxes[leaf.first()] = node.bounds(lane);
                }
            }
        }
    }

    /// Lists the parts of triangles that their leaves cover.
    fn list_parts(&mut self, tree: &WideTree, is_split: bool) {
        self.parts.clear();
        if !is_split {
            return;
        }
        self.parts.resize(tree.slots(), Part::WHOLE);
        let Self { parts, counts, leaf_boxes, .. } = self;
        // Slots after the first of a leaf have a count of zero.
        let mut rest = parts.as_mut_slice();
        let mut leaves = Vec::new();
        let mut first = 0;
        for (slot, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
            let (_, after) = std::mem::take(&mut rest).split_at_mut(slot - first);
            let (own, after) = after.split_at_mut(usize::from(count));
            leaves.push((slot, own));
            (rest, first) = (after, slot + usize::from(count));
        }
        leaves.into_par_iter().with_min_len(NODES_PER_TASK).for_each(|(slot, parts)| {
            let triangles = tree.triangles(Leaf::new(slot, parts.len()));
            for (lane, part) in parts.iter_mut().enumerate() {
                let triangle = Triangle { vertices: triangles.corners(lane) };
                *part = Part::inside(&triangle, &leaf_boxes[slot]);
            }
        });
    }

    /// Writes the new corners to all leaves; false if a triangle is no longer traced.
    fn move_triangles(&mut self, tree: &mut WideTree, input: Input) -> Result<bool, Cancelled> {
        let mut tasks = Vec::new();
        let mut counts = self.counts.as_slice();
        let mut boxes = self.leaf_boxes.as_mut_slice();
        let mut words = tree.words.as_mut_slice();
        let mut first = 0;
        while !counts.is_empty() {
            // Tasks end at the start of a leaf.
            let end = counts.len().min(SLOTS_PER_TASK);
            let rest = counts[end..].iter().position(|&count| count > 0);
            let slots = rest.map_or(counts.len(), |rest| end + rest);
            let task;
            (task, counts, boxes, words) = LeafTask::split_off(slots, counts, boxes, words);
            tasks.push(LeafTask { parts: self.parts.get(first..).unwrap_or_default(), ..task });
            first += slots;
        }
        let is_possible = AtomicBool::new(true);
        tasks.into_par_iter().try_for_each(|task| {
            input.cancel.check()?;
            if !task.run(input) {
                is_possible.store(false, Ordering::Relaxed);
            }
            Ok(())
        })?;
        Ok(is_possible.into_inner())
    }

    /// Computes the boxes of all nodes from those of the leaves.
    fn fit_boxes(&self, tree: &WideTree) -> Fitted {
        self.fit_node(tree, tree.root, 0)
    }

    fn fit_node(&self, tree: &WideTree, index: u32, level: u32) -> Fitted {
        let children = &tree.nodes[index as usize].children;
        let fit_lane = |&child: &u32| {
            if child == NO_CHILD {
                return Fitted::NONE;
            }
            match Leaf::of(child) {
                Some(leaf) => {
                    let bounds = self.leaf_boxes[leaf.first()];
                    Fitted { bounds, cost: bounds.area() }
                }
                None => self.fit_node(tree, child, level + 1),
            }
        };
        let join = |all: Fitted, lane: Fitted| all.joined(&lane.bounds, lane.cost);
        // Summed in the order of lanes, whoever found them.
        let lanes = if level < PARALLEL_LEVELS {
            let mut lanes = [Fitted::NONE; WIDTH];
            lanes.par_iter_mut().zip(children).for_each(|(lane, child)| *lane = fit_lane(child));
            lanes.into_iter().fold(Fitted::NONE, join)
        } else {
            children.iter().map(fit_lane).fold(Fitted::NONE, join)
        };
        self.boxes[index as usize].store(&lanes.bounds);
        Fitted { cost: lanes.cost + lanes.bounds.area(), ..lanes }
    }

    /// Gives a node the boxes of its children.
    fn store_boxes(&self, node: &mut WideNode) {
        for lane in 0..WIDTH {
            let child = node.children[lane];
            if child != NO_CHILD {
                let bounds = match Leaf::of(child) {
                    Some(leaf) => self.leaf_boxes[leaf.first()],
                    None => self.boxes[child as usize].load(),
                };
                node.put(lane, child, &bounds);
            }
        }
    }
}

impl<'a> LeafTask<'a> {
    /// Task of the first `slots`, and the rest.
    fn split_off(
        slots: usize,
        counts: &'a [u8],
        boxes: &'a mut [Aabb],
        words: &'a mut [f32],
    ) -> (Self, &'a [u8], &'a mut [Aabb], &'a mut [f32]) {
        let (counts, other_counts) = counts.split_at(slots);
        let (boxes, other_boxes) = boxes.split_at_mut(slots);
        let (words, other_words) = words.split_at_mut(slots * WORDS_PER_SLOT);
        (Self { counts, boxes, words, parts: &[] }, other_counts, other_boxes, other_words)
    }

    /// Writes the new corners and computes the boxes of leaves; false if a triangle is no longer traced.
    fn run(self, input: Input) -> bool {
        for (slot, &count) in self.counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
            let count = usize::from(count);
            let words = &mut self.words[slot * WORDS_PER_SLOT..][..count * WORDS_PER_SLOT];
            let parts = self.parts.get(slot..slot + count).unwrap_or_default();
            match move_leaf(words, count, parts, input) {
                Some(bounds) => self.boxes[slot] = bounds,
                None => return false,
            }
        }
        true
    }
}

impl Fitted {
    /// Empty subtree.
    const NONE: Self = Self { bounds: Aabb::EMPTY, cost: 0.0 };

    /// Union with a child of this box and cost.
    fn joined(&self, bounds: &Aabb, cost: f64) -> Self {
        Self { bounds: self.bounds.union(*bounds), cost: self.cost + cost }
    }

    /// Surface area heuristic cost: average number of nodes and leaves that a line through the root's box visits.
    fn cost_per_ray(&self) -> f64 {
        let area = self.bounds.area();
        if area > 0.0 { self.cost / area } else { f64::INFINITY }
    }
}

impl NodeBox {
    fn store(&self, bounds: &Aabb) {
        let planes = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
        for (slot, plane) in self.0.iter().zip(planes) {
            slot.store(plane.to_bits(), Ordering::Relaxed);
        }
    }

    fn load(&self) -> Aabb {
        let [x0, y0, z0, x1, y1, z1] =
            self.0.each_ref().map(|slot| f32::from_bits(slot.load(Ordering::Relaxed)));
        Aabb { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }
    }
}

/// Whether exactly `traced` triangles are traced.
fn has_count(Input { triangles, flags, .. }: Input, traced: usize) -> bool {
    let is_counted = |(triangle, flags): &(&Triangle, &TriangleFlags)| is_traced(triangle, **flags);
    triangles.par_iter().zip(flags).with_min_len(SLOTS_PER_TASK).filter(is_counted).count() == traced
}

/// Maximum cost of a refitted tree that is kept.
fn max_cost(least_cost: f64, built: &BuildStatistics, settings: &BuildSettings) -> f64 {
    match settings.refit {
        Refit::Off => 0.0,
        Refit::UpTo(factor) => least_cost * f64::from(factor),
        Refit::Auto => {
            let is_clustered = built.builder == BuilderKind::Ploc;
            let clustering = if is_clustered { CLUSTERING_NS_PER_REFERENCE } else { 0.0 };
            let saved = built.references as f64 * (SAVED_NS_PER_REFERENCE + clustering);
            least_cost + saved / (settings.expected_rays.max(1) as f64 * NS_PER_VISIT)
        }
    }
}

/// Writes new corners and flags of a leaf's triangles. Returns the box around them or their parts, grown as the definition of a
/// hit requires; `None` if a triangle is no longer traced.
fn move_leaf(words: &mut [f32], count: usize, parts: &[Part], input: Input) -> Option<Aabb> {
    let (mut bounds, mut padding) = (Aabb::EMPTY, 0.0_f32);
    for lane in 0..count {
        let triangle_id = Tag::of(words[9 * count + lane]).triangle();
        let triangle = input.triangles.get(triangle_id as usize)?;
        let flags = *input.flags.get(triangle_id as usize)?;
        if !is_traced(triangle, flags) {
            return None;
        }
        let new_words = slot_words(triangle.vertices, Tag::new(triangle_id, flags));
        for (row, value) in words.chunks_exact_mut(count).zip(new_words) {
            row[lane] = value;
        }
        let part = parts.get(lane).map_or_else(|| triangle.bounds(), |part| part.bounds(triangle));
        bounds = bounds.union(part);
        padding = padding.max(padding_of(triangle));
    }
    Some(bounds.grown(padding))
}
