//! Fitting the last frame's wide tree to triangles that moved, instead of building another.
//!
//! The tree keeps its shape; leaves get the corners of now, and boxes follow from the leaves up. That is possible while the
//! tree has exactly the triangles that take part, each in one leaf: not where triangles were split, nor where one was hidden,
//! shown, or lost its area. It keeps being good while triangles keep their neighbours. The quality watch compares the
//! tree's surface area heuristic cost with the least that it was since the tree was built.
//!
//! # When refitting pays
//!
//! Refitting saves [`SAVED_NS_PER_TRIANGLE`], and more where a better tree was built, and costs every ray of the frame
//! what the tree got worse. The SAH cost counts the nodes and leaves that a long ray meets, at about [`NS_PER_VISIT`]
//! each. So a refitted tree of cost `C` over `n` triangles is kept for `r` rays if `r (C − C_least) step ≤ n saved`. A tree that fails is built anew, and the
//! time of the attempt is lost; therefore the number of frames until the next attempt doubles with each failure, up to
//! [`MAX_PAUSE`], and an attempt that succeeds ends that.

#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rayon::prelude::*;

use crate::bvh::references::{Input, is_traced};
use crate::bvh::settings::{BuildSettings, BuilderKind, Refit};
use crate::bvh::statistics::{BuildStatistics, RebuildReason};
use crate::bvh::triangle_flags::TriangleFlags;
use crate::bvh::wide_tree::{Leaf, NO_CHILD, Tag, WIDTH, WORDS_PER_SLOT, WideNode, WideTree};
use crate::cancel::Cancelled;
use crate::geometry::{Aabb, BOX_PADDING, Triangle};
use glam::Vec3;

/// What building the LBVH costs beyond refitting, by measure: some 45 against 15.
const SAVED_NS_PER_TRIANGLE: f64 = 30.0;
/// What merging clusters costs beyond the LBVH.
const SAVED_PLOC_NS_PER_TRIANGLE: f64 = 30.0;
/// What a ray's visit of a node or a leaf costs, with the shading that goes with it.
const NS_PER_VISIT: f64 = 12.0;
/// Most frames that are built without an attempt to refit after attempts that failed.
const MAX_PAUSE: u32 = 64;

/// Places whose triangles are one task.
const SLOTS_PER_TASK: usize = 1 << 12;
const NODES_PER_TASK: usize = 1 << 8;
/// Levels of the wide tree whose children are tasks of their own.
const PARALLEL_LEVELS: u32 = 4;

/// What refitting knows of a tree, and its memory.
#[derive(Debug, Default)]
pub(crate) struct Refitter {
    /// How many triangles each leaf has, at its first place.
    counts: Vec<u8>,
    /// The box of each leaf, at its first place.
    leaf_boxes: Vec<Aabb>,
    boxes: Vec<NodeBox>,
    /// The least SAH cost of the tree since it was built, which another tree would have, too; `None` until it is asked for.
    least_cost: Option<f64>,
    /// Frames to be built before the next attempt.
    pause: u32,
    /// What `pause` becomes when the next attempt fails.
    next_pause: u32,
}

/// What came of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Attempt {
    /// The tree fits; its SAH cost over the least since it was built.
    Refitted { cost_ratio: f64 },
    /// Another tree must be built.
    Rebuild(RebuildReason),
}

/// The box of a node, written by one task and read by another.
#[derive(Debug, Default)]
struct NodeBox([AtomicU32; 6]);

/// Leaves that stand together, and the places of their boxes.
struct LeafTask<'a> {
    counts: &'a [u8],
    boxes: &'a mut [Aabb],
    words: &'a mut [f32],
}

/// Box and cost of a subtree; the cost is in square metres.
#[derive(Clone, Copy)]
struct Fitted {
    bounds: Aabb,
    cost: f64,
}

impl Refitter {
    /// Another tree was built.
    pub(crate) fn forget(&mut self) {
        self.counts.clear();
        self.least_cost = None;
    }

    /// Fits `tree`, which was built as `built` tells, to the triangles of now, or tells why not. Then it is of no use.
    pub(crate) fn attempt(
        &mut self,
        tree: &mut WideTree,
        built: &BuildStatistics,
        input: Input,
        settings: &BuildSettings,
    ) -> Result<Attempt, Cancelled> {
        let traced = built.triangles;
        if settings.refit == Refit::Off || tree.nodes.is_empty() {
            return Ok(Attempt::Rebuild(RebuildReason::NoPreviousTree));
        }
        if built.references != traced {
            return Ok(Attempt::Rebuild(RebuildReason::OtherTriangles));
        }
        if self.pause > 0 {
            self.pause -= 1;
            return Ok(Attempt::Rebuild(RebuildReason::Pausing));
        }
        let least_cost = self.cost_before(tree);
        if !has_as_many(input, traced) || !self.move_triangles(tree, input)? {
            return Ok(Attempt::Rebuild(RebuildReason::OtherTriangles));
        }

        // Boxes of nodes, and what they are worth.
        let cost = self.fit_boxes(tree).cost_a_ray();
        // Costs that are no numbers fail, too.
        let pays = cost <= most_cost(least_cost, built, settings);
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

    /// The least SAH cost so far; measured when it is first asked for.
    fn cost_before(&mut self, tree: &WideTree) -> f64 {
        if let Some(cost) = self.least_cost {
            return cost;
        }
        self.list_leaves(tree);
        self.boxes.resize_with(tree.nodes.len(), NodeBox::default);
        self.fit_boxes(tree).cost_a_ray()
    }

    /// Finds out where leaves begin, and their boxes.
    fn list_leaves(&mut self, tree: &WideTree) {
        self.counts.clear();
        self.counts.resize(tree.places(), 0);
        self.leaf_boxes.resize(tree.places(), Aabb::EMPTY);
        for node in &tree.nodes {
            for (lane, &child) in node.children.iter().enumerate().filter(|&(_, &child)| child != NO_CHILD) {
                if let Some(leaf) = Leaf::of(child) {
                    self.counts[leaf.first()] = leaf.count() as u8;
                    self.leaf_boxes[leaf.first()] = node.bounds(lane);
                }
            }
        }
    }

    /// Gives the leaves the corners of `triangles`; false if one of theirs no longer takes part.
    fn move_triangles(&mut self, tree: &mut WideTree, input: Input) -> Result<bool, Cancelled> {
        let mut tasks = Vec::new();
        let mut counts = self.counts.as_slice();
        let mut boxes = self.leaf_boxes.as_mut_slice();
        let mut words = tree.words.as_mut_slice();
        while !counts.is_empty() {
            // A task ends where a leaf begins.
            let end = counts.len().min(SLOTS_PER_TASK);
            let rest = counts[end..].iter().position(|&count| count > 0);
            let places = rest.map_or(counts.len(), |rest| end + rest);
            let task;
            (task, counts, boxes, words) = LeafTask::split_off(places, counts, boxes, words);
            tasks.push(task);
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

    /// Finds the boxes of all nodes from those of their leaves.
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
    /// The leaves of the first `places`, and what is left.
    fn split_off(
        places: usize,
        counts: &'a [u8],
        boxes: &'a mut [Aabb],
        words: &'a mut [f32],
    ) -> (Self, &'a [u8], &'a mut [Aabb], &'a mut [f32]) {
        let (counts, other_counts) = counts.split_at(places);
        let (boxes, other_boxes) = boxes.split_at_mut(places);
        let (words, other_words) = words.split_at_mut(places * WORDS_PER_SLOT);
        (Self { counts, boxes, words }, other_counts, other_boxes, other_words)
    }

    /// Moves the triangles and finds the boxes of their leaves; false if one no longer takes part.
    fn run(self, input: Input) -> bool {
        for (place, &count) in self.counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
            let count = usize::from(count);
            let words = &mut self.words[place * WORDS_PER_SLOT..][..count * WORDS_PER_SLOT];
            match move_leaf(words, count, input) {
                Some(bounds) => self.boxes[place] = bounds,
                None => return false,
            }
        }
        true
    }
}

impl Fitted {
    /// Nothing.
    const NONE: Self = Self { bounds: Aabb::EMPTY, cost: 0.0 };

    /// Both together.
    fn joined(&self, bounds: &Aabb, cost: f64) -> Self {
        Self { bounds: self.bounds.union(*bounds), cost: self.cost + cost }
    }

    /// The surface area heuristic cost: the nodes and leaves that a line through the root's box meets on average.
    fn cost_a_ray(&self) -> f64 {
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

/// Whether `traced` triangles take part.
fn has_as_many(Input { triangles, flags, .. }: Input, traced: usize) -> bool {
    let takes_part = |(triangle, flags): &(&Triangle, &TriangleFlags)| is_traced(triangle, **flags);
    let taking_part = triangles.par_iter().zip(flags).with_min_len(SLOTS_PER_TASK).filter(takes_part);
    // Where all have to, the tree's own tell.
    triangles.len() == traced || taking_part.count() == traced
}

/// The highest cost of a refitted tree that is kept.
fn most_cost(least_cost: f64, built: &BuildStatistics, settings: &BuildSettings) -> f64 {
    match settings.refit {
        Refit::Off => 0.0,
        Refit::UpTo(factor) => least_cost * f64::from(factor),
        Refit::Auto => {
            let merging = if built.builder == BuilderKind::Ploc { SAVED_PLOC_NS_PER_TRIANGLE } else { 0.0 };
            let saved = built.triangles as f64 * (SAVED_NS_PER_TRIANGLE + merging);
            least_cost + saved / (settings.expected_rays.max(1) as f64 * NS_PER_VISIT)
        }
    }
}

/// New corners and flags for the triangles of a leaf, and the box around them, output as the definition of a hit asks;
/// `None` if one of them takes no part any more.
fn move_leaf(words: &mut [f32], count: usize, input: Input) -> Option<Aabb> {
    let mut bounds = Aabb::EMPTY;
    for lane in 0..count {
        let triangle_id = Tag::of(words[9 * count + lane]).triangle();
        let triangle = input.triangles.get(triangle_id as usize)?;
        let flags = *input.flags.get(triangle_id as usize)?;
        if !is_traced(triangle, flags) {
            return None;
        }
        let [a, b, c] = triangle.vertices;
        let tag = Tag::new(triangle_id, flags).word();
        let components = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, tag];
        for (row, value) in words.chunks_exact_mut(count).zip(components) {
            row[lane] = value;
        }
        bounds = bounds.union(triangle.bounds());
    }
    let magnitude = bounds.min.abs().max(bounds.max.abs()).max_element();
    Some(bounds.grown(magnitude * BOX_PADDING + f32::MIN_POSITIVE))
}
