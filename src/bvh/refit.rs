//! Fitting the last frame's wide tree to triangles that moved, instead of building another.
//!
//! The tree keeps its shape; leaves get the corners of now, and boxes follow from the leaves up. That is possible while the
//! tree has exactly the triangles that take part, each in one leaf: not where triangles were split, nor where one was hidden,
//! shown, or lost its area. It keeps being good while triangles keep their neighbours. The quality watch compares the
//! tree's surface area heuristic cost with what it was when the tree was built.
//!
//! # When refitting pays
//!
//! Refitting saves [`SAVED_NANOSECONDS_A_TRIANGLE`] and costs every ray of the frame what the tree got worse. The SAH cost
//! counts the nodes and leaves that a long ray meets, at about [`NANOSECONDS_A_STEP`] each. So a refitted tree of cost `C`
//! over `n` triangles is kept for `r` rays if `r (C − C_built) step ≤ n saved`. A tree that fails is built anew, and the
//! time of the attempt is lost; therefore the number of frames until the next attempt doubles with each failure, up to
//! [`LONGEST_PAUSE`], and an attempt that succeeds ends that.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rayon::prelude::*;

use super::split_clip::{Input, is_traced};
use super::wide::{Leaf, NO_CHILD, Tag, Triangles, WIDTH, WORDS_A_PLACE, WideNode, WideTree};
use super::{BuildSettings, BuildStatistics, PrimitiveFlags, Refit};
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::{Aabb, BOX_PADDING, Triangle};
use glam::Vec3;

/// What building a tree costs beyond refitting one.
const SAVED_NANOSECONDS_A_TRIANGLE: f64 = 30.0;
/// What a ray's visit of a node or a leaf costs.
const NANOSECONDS_A_STEP: f64 = 8.0;
/// Most frames that are built without an attempt to refit after attempts that failed.
const LONGEST_PAUSE: u32 = 64;

/// Places whose triangles are one task.
const PLACES_A_TASK: usize = 1 << 12;
const NODES_A_TASK: usize = 1 << 8;
/// Levels of the wide tree whose children are tasks of their own.
const PARALLEL_LEVELS: u32 = 4;

/// What refitting knows of a tree, and its memory.
#[derive(Debug, Default)]
pub(super) struct Refitter {
    /// How many triangles each leaf has, at its first place.
    counts: Vec<u8>,
    boxes: Vec<NodeBox>,
    /// The SAH cost of the tree as it was built; `None` until it is asked for.
    built_cost: Option<f64>,
    /// Frames to be built before the next attempt.
    pause: u32,
    /// What `pause` becomes when the next attempt fails.
    next_pause: u32,
}

/// What came of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Attempt {
    /// The tree fits; its SAH cost now and when it was built.
    Refitted { cost: f64, built_cost: f64 },
    /// Another tree must be built.
    Rebuild(Reason),
}

/// Why a tree is built rather than refitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// There is none, or it may not be refitted.
    First,
    /// Other triangles take part than before, or some are split.
    OtherTriangles,
    /// Refitted it would cost rays more than building costs.
    Decayed,
    /// Refitting has not paid in the last frames.
    Pausing,
}

/// The box of a node, written by one task and read by another.
#[derive(Debug, Default)]
struct NodeBox([AtomicU32; 6]);

/// Box and cost of a subtree; the cost is in square metres.
#[derive(Clone, Copy)]
struct Fitted {
    bounds: Aabb,
    cost: f64,
}

impl Refitter {
    /// Another tree was built.
    pub(super) fn forget(&mut self) {
        self.counts.clear();
        self.built_cost = None;
    }

    /// Fits `tree`, which was built as `built` tells, to the triangles of now, or tells why not. Then it is of no use.
    pub(super) fn attempt(
        &mut self,
        tree: &mut WideTree,
        built: &BuildStatistics,
        input: Input,
        settings: &BuildSettings,
    ) -> Result<Attempt, Cancelled> {
        let Input { triangles, flags, cancel } = input;
        let traced = built.triangles;
        if settings.refit == Refit::Off || tree.nodes.is_empty() {
            return Ok(Attempt::Rebuild(Reason::First));
        }
        if built.references != traced {
            return Ok(Attempt::Rebuild(Reason::OtherTriangles));
        }
        if self.pause > 0 {
            self.pause -= 1;
            return Ok(Attempt::Rebuild(Reason::Pausing));
        }
        let built_cost = match self.built_cost {
            Some(cost) => cost,
            None => {
                self.list_leaves(tree);
                self.boxes.resize_with(tree.nodes.len(), NodeBox::default);
                *self.built_cost.insert(self.fit_boxes(tree).cost_a_ray())
            }
        };

        // The same triangles as before?
        let are_others_out = || {
            let taking_part = triangles.par_iter().zip(flags).with_min_len(PLACES_A_TASK);
            taking_part.filter(|(triangle, flags)| is_traced(triangle, **flags)).count() == traced
        };
        if triangles.len() != traced && !are_others_out() {
            return Ok(Attempt::Rebuild(Reason::OtherTriangles));
        }
        if !self.move_triangles(tree, triangles, flags, cancel)? {
            return Ok(Attempt::Rebuild(Reason::OtherTriangles));
        }

        // Boxes of leaves, boxes of nodes, and what they are worth.
        tree.nodes.par_iter_mut().with_min_len(NODES_A_TASK).for_each(|node| fit_leaves(node, &tree.words));
        cancel.check()?;
        let cost = self.fit_boxes(tree).cost_a_ray();
        let boxes = &self.boxes;
        tree.nodes.par_iter_mut().with_min_len(NODES_A_TASK).for_each(|node| store_boxes(node, boxes));
        if cost > most_cost(built_cost, traced, settings) {
            self.pause = self.next_pause;
            self.next_pause = (2 * self.next_pause).clamp(1, LONGEST_PAUSE);
            return Ok(Attempt::Rebuild(Reason::Decayed));
        }
        self.next_pause = 0;
        Ok(Attempt::Refitted { cost, built_cost })
    }

    /// Finds out where leaves begin.
    fn list_leaves(&mut self, tree: &WideTree) {
        self.counts.clear();
        self.counts.resize(tree.places(), 0);
        let children = tree.nodes.iter().flat_map(|node| node.children);
        for leaf in children.filter(|&child| child != NO_CHILD).filter_map(Leaf::of) {
            self.counts[leaf.first()] = leaf.count() as u8;
        }
    }

    /// Gives the leaves the corners of `triangles`; false if one of theirs no longer takes part.
    fn move_triangles(
        &self,
        tree: &mut WideTree,
        triangles: &[Triangle],
        flags: &[PrimitiveFlags],
        cancel: &CancelFlag,
    ) -> Result<bool, Cancelled> {
        let mut tasks = Vec::new();
        let (mut counts, mut words) = (self.counts.as_slice(), tree.words.as_mut_slice());
        while counts.len() > PLACES_A_TASK {
            // A task begins where a leaf does.
            let leaf = counts[PLACES_A_TASK..].iter().position(|&count| count > 0);
            let places = PLACES_A_TASK + leaf.unwrap_or(counts.len() - PLACES_A_TASK);
            let (counts_of_task, words_of_task);
            (counts_of_task, counts) = counts.split_at(places);
            (words_of_task, words) = words.split_at_mut(places * WORDS_A_PLACE);
            tasks.push((counts_of_task, words_of_task));
        }
        tasks.push((counts, words));

        let is_possible = AtomicBool::new(true);
        tasks.into_par_iter().try_for_each(|(counts, words)| {
            cancel.check()?;
            for (place, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
                let words = &mut words[place * WORDS_A_PLACE..][..usize::from(count) * WORDS_A_PLACE];
                if !move_leaf(words, usize::from(count), triangles, flags) {
                    is_possible.store(false, Ordering::Relaxed);
                    break;
                }
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
        let node = &tree.nodes[index as usize];
        let fit_lane = |lane: usize| {
            let child = node.children[lane];
            if child == NO_CHILD {
                return Fitted { bounds: Aabb::EMPTY, cost: 0.0 };
            }
            if Leaf::of(child).is_none() {
                return self.fit_node(tree, child, level + 1);
            }
            let bounds = node.bounds(lane);
            Fitted { bounds, cost: bounds.area() }
        };
        let mut lanes = [Fitted { bounds: Aabb::EMPTY, cost: 0.0 }; WIDTH];
        if level < PARALLEL_LEVELS {
            lanes.par_iter_mut().enumerate().for_each(|(lane, fitted)| *fitted = fit_lane(lane));
        } else {
            for (lane, fitted) in lanes.iter_mut().enumerate() {
                *fitted = fit_lane(lane);
            }
        }
        let bounds = lanes.iter().fold(Aabb::EMPTY, |all, lane| all.union(lane.bounds));
        self.boxes[index as usize].store(&bounds);
        // Summed in the order of lanes, whoever found them.
        Fitted { bounds, cost: bounds.area() + lanes.iter().map(|lane| lane.cost).sum::<f64>() }
    }
}

impl Fitted {
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

/// The highest cost of a refitted tree that is kept.
fn most_cost(built_cost: f64, triangles: usize, settings: &BuildSettings) -> f64 {
    match settings.refit {
        Refit::Off => 0.0,
        Refit::UpTo(factor) => built_cost * f64::from(factor),
        Refit::Auto => {
            let saved = triangles as f64 * SAVED_NANOSECONDS_A_TRIANGLE;
            built_cost + saved / (settings.expected_rays.max(1) as f64 * NANOSECONDS_A_STEP)
        }
    }
}

/// New corners and flags for the triangles of a leaf; false if one of them takes no part any more.
fn move_leaf(words: &mut [f32], count: usize, triangles: &[Triangle], flags: &[PrimitiveFlags]) -> bool {
    for lane in 0..count {
        let primitive = Triangles::new(words, count).tag(lane).primitive();
        let triangle = &triangles[primitive as usize];
        let flags = flags[primitive as usize];
        if !is_traced(triangle, flags) {
            return false;
        }
        let [a, b, c] = triangle.vertices;
        let tag = Tag::new(primitive, flags).word();
        let components = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, tag];
        for (component, value) in components.into_iter().enumerate() {
            words[component * count + lane] = value;
        }
    }
    true
}

/// Boxes of those children that are leaves.
fn fit_leaves(node: &mut WideNode, words: &[f32]) {
    for lane in 0..WIDTH {
        let child = node.children[lane];
        if child != NO_CHILD
            && let Some(leaf) = Leaf::of(child)
        {
            let bounds = leaf_bounds(Triangles::new(&words[WORDS_A_PLACE * leaf.first()..], leaf.count()));
            node.put(lane, child, &bounds);
        }
    }
}

/// Boxes of those children that are nodes.
fn store_boxes(node: &mut WideNode, boxes: &[NodeBox]) {
    for lane in 0..WIDTH {
        let child = node.children[lane];
        if child != NO_CHILD && Leaf::of(child).is_none() {
            node.put(lane, child, &boxes[child as usize].load());
        }
    }
}

/// The box around the triangles of a leaf, grown as the definition of a hit asks.
fn leaf_bounds(triangles: Triangles<'_>) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for axis in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|corner| triangles.lanes(corner, axis));
        let mut low = *a;
        let mut high = *a;
        for lane in 0..WIDTH {
            low[lane] = lesser(lesser(a[lane], b[lane]), c[lane]);
            high[lane] = greater(greater(a[lane], b[lane]), c[lane]);
        }
        // Lanes beyond the last hold anything.
        bounds.min[axis] = low[..triangles.count()].iter().fold(f32::INFINITY, |a, &b| lesser(a, b));
        bounds.max[axis] = high[..triangles.count()].iter().fold(f32::NEG_INFINITY, |a, &b| greater(a, b));
    }
    let magnitude = bounds.min.abs().max(bounds.max.abs()).max_element();
    bounds.grown(magnitude * BOX_PADDING + f32::MIN_POSITIVE)
}

fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
