//! Construction of light trees by binned splits of least cost.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::emitter::Emitter;
use super::light_bounds::LightBounds;
use super::light_node::{Content, LightNode};
use crate::geometry::Aabb;

/// Most bins along an axis. There are no more bins than emitters.
const BINS: usize = 12;

/// Nodes of more emitters are divided along any axis in which their extent is at least this share of the largest.
const SMALL_COUNT: usize = 4;
const LEAST_EXTENT: f32 = 0.25;

/// Below this level, nodes are split into equal counts.
const MAX_COST_LEVEL: u32 = 32;

/// Most levels of a tree below its root, and of one made from it: a level of equal counts takes one bit of a count.
pub(super) const MAX_LEVELS: usize = MAX_COST_LEVEL as usize + 32;

/// Nodes of more emitters build their children in parallel.
const PARALLEL_COUNT: usize = 1 << 12;

/// Nodes of more emitters are binned in parallel, in parts of this size: sums are the same for every thread count.
const BINNED_PART: usize = 1 << 16;

/// An emitter of the tree under construction.
#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    normal: Vec3,
    /// Share of the power of all emitters.
    power: f32,
    is_two_sided: bool,
    emitter: u32,
}

impl Item {
    fn center(&self) -> Vec3 {
        self.bounds.center()
    }
}

/// The nodes of a binary tree, the root first.
pub(super) fn build(emitters: &[Emitter]) -> Vec<LightNode> {
    let mut items = items(emitters);
    let Some(count) = items.len().checked_sub(1) else { return Vec::new() };

    // Fill the descendants of the root, then the root.
    let filler = node(&single(emitters, &items[0]), Content::Emitter(0));
    let mut nodes = vec![filler; 2 * count + 1];
    let (root, descendants) = nodes.split_at_mut(1);
    root[0] = build_node(emitters, &mut items, descendants, Position { first: 1, level: 0 }).0;
    nodes
}

fn node(bounds: &LightBounds, content: Content) -> LightNode {
    LightNode { bounds: bounds.compact(), is_two_sided: bounds.is_two_sided, content }
}

/// The emitters that emit, with their shares of the power.
fn items(emitters: &[Emitter]) -> Vec<Item> {
    let is_lit = |emitter: &Emitter| emitter.power > 0.0 && emitter.power < f32::INFINITY;
    let total: f64 =
        emitters.iter().filter(|emitter| is_lit(emitter)).map(|emitter| f64::from(emitter.power)).sum();
    let item = |(index, emitter): (usize, &Emitter)| {
        let [a, b, c] = emitter.corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).try_normalize()?.as_vec3();
        let bounds = Aabb::from_points(&emitter.corners);
        let power = (f64::from(emitter.power) / total) as f32;
        let is_usable = is_lit(emitter) && index < LightNode::LIMIT / 2 && bounds.center().is_finite();
        let is_two_sided = emitter.is_two_sided;
        is_usable.then_some(Item { bounds, normal, power, is_two_sided, emitter: index as u32 })
    };
    emitters.par_iter().enumerate().filter_map(item).collect()
}

fn single(emitters: &[Emitter], item: &Item) -> LightBounds {
    LightBounds::of_emitter(&emitters[item.emitter as usize], item.normal, item.power)
}

/// Where a node is in the tree.
#[derive(Clone, Copy)]
struct Position {
    /// Index of its first descendant.
    first: u32,
    level: u32,
}

/// Builds the tree over `items` and fills its `descendants`, two less than twice as many.
fn build_node(
    emitters: &[Emitter],
    items: &mut [Item],
    descendants: &mut [LightNode],
    position: Position,
) -> (LightNode, LightBounds) {
    let Position { first, level } = position;
    if let [item] = items {
        let bounds = single(emitters, item);
        return (node(&bounds, Content::Emitter(item.emitter)), bounds);
    }
    let is_large = items.len() > PARALLEL_COUNT;
    let left_count = split(items, level);
    let (left, right) = items.split_at_mut(left_count);
    let (children, descendants) = descendants.split_at_mut(2);
    let (left_descendants, right_descendants) = descendants.split_at_mut(2 * left_count - 2);
    let left_position = Position { first: first + 2, level: level + 1 };
    let right_first = first + 2 * left_count as u32;
    let right_position = Position { first: right_first, level: level + 1 };
    let mut build_left = || build_node(emitters, left, left_descendants, left_position);
    let mut build_right = || build_node(emitters, right, right_descendants, right_position);
    let ((left_node, left_bounds), (right_node, right_bounds)) =
        if is_large { rayon::join(build_left, build_right) } else { (build_left(), build_right()) };
    children.copy_from_slice(&[left_node, right_node]);
    let bounds = left_bounds.union(&right_bounds);
    (node(&bounds, Content::Children(first)), bounds)
}

/// Orders at least two items into two sets and returns the count of the first.
fn split(items: &mut [Item], level: u32) -> usize {
    let centers = items.iter().fold(Aabb::EMPTY, |bounds, item| bounds.union_point(item.center()));
    if items.len() > 2 && level < MAX_COST_LEVEL {
        let binning = Binning::new(&centers, items.len());
        if let Some(plane) = best_plane(items, centers.extent(), &binning) {
            return partition(items, |item| binning.bin(item.center(), plane.axis) < plane.bin);
        }
    }
    let half = items.len() / 2;
    let axis = centers.extent().max_position();
    let key = |item: &Item| (item.center()[axis], item.emitter);
    items.select_nth_unstable_by(half, |a, b| {
        let ((a, i), (b, j)) = (key(a), key(b));
        a.total_cmp(&b).then(i.cmp(&j))
    });
    half
}

/// Moves the items that satisfy `is_first` to the front, and returns their count.
fn partition(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for index in 0..items.len() {
        if is_first(&items[index]) {
            items.swap(index, count);
            count += 1;
        }
    }
    count
}

/// The bins along the axes of a node.
struct Binning {
    min: Vec3,
    /// Bins by length.
    scale: Vec3,
    count: usize,
    /// Whether emitters are divided along an axis: not along one in which the node is far smaller than in another, and in small
    /// nodes only along the longest.
    is_used: [bool; 3],
}

impl Binning {
    fn new(centers: &Aabb, item_count: usize) -> Self {
        let count = item_count.min(BINS);
        let extent = centers.extent();
        let least = extent.max_element() * if item_count > SMALL_COUNT { LEAST_EXTENT } else { 1.0 };
        let is_used = extent.to_array().map(|length| length > 0.0 && length >= least);
        Self { min: centers.min, scale: Vec3::splat(count as f32) / extent, count, is_used }
    }

    fn bin(&self, center: Vec3, axis: usize) -> usize {
        (((center[axis] - self.min[axis]) * self.scale[axis]) as usize).min(self.count - 1)
    }
}

/// A border between bins: the first bin on its upper side.
struct Plane {
    axis: usize,
    bin: usize,
}

/// The border of least cost that leaves items on both sides (section 4.4 of the paper).
fn best_plane(items: &[Item], extent: Vec3, binning: &Binning) -> Option<Plane> {
    let mut best: Option<(f32, Plane)> = None;
    let bins = bins(items, binning);
    for (axis, bins) in bins.iter().enumerate().filter(|(axis, _)| binning.is_used[*axis]) {
        // Regularise: thin boxes are not cut thinner.
        let factor = extent.max_element() / extent[axis];
        let mut above = BinSum::EMPTY;
        let mut costs_above = [0.0; BINS];
        for index in (1..binning.count).rev() {
            above = above.union(&bins[index]);
            costs_above[index] = above.cost();
        }
        let mut below = BinSum::EMPTY;
        for (index, cost_above) in costs_above.iter().enumerate().take(binning.count).skip(1) {
            // A border above an empty bin divides as the one below it does.
            if bins[index - 1].count == 0 {
                continue;
            }
            below = below.union(&bins[index - 1]);
            let cost = factor * (below.cost() + cost_above);
            let is_split = (below.count as usize) < items.len() && cost.is_finite();
            if is_split && best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, Plane { axis, bin: index }));
            }
        }
    }
    best.map(|(_, plane)| plane)
}

/// What the cost of a set of emitters is computed from.
#[derive(Clone, Copy)]
struct BinSum {
    bounds: Aabb,
    count: u32,
    power: f32,
    /// The sum of the normals; those of two-sided emitters point up.
    normals: Vec3,
}

impl BinSum {
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, count: 0, power: 0.0, normals: Vec3::ZERO };

    fn add(&mut self, item: &Item) {
        self.bounds = self.bounds.union(item.bounds);
        self.count += 1;
        self.power += item.power;
        let is_reversed = item.is_two_sided && item.normal.dot(Vec3::new(0.48, 0.6, 0.64)) < 0.0;
        self.normals += if is_reversed { -item.normal } else { item.normal };
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            count: self.count + other.count,
            power: self.power + other.power,
            normals: self.normals + other.normals,
        }
    }

    /// Power × surface area × solid angle of the directions. In place of the cone of all normals, the cap of the sphere whose
    /// normals have the same mean: one of angle θₒ has a mean of length (1 + cos θₒ) / 2.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let mean = (self.normals.length() / self.count as f32).min(1.0);
        let e = self.bounds.extent();
        let area = 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x);
        self.power * area * solid_angle(2.0 * mean - 1.0)
    }
}

/// The solid angle of the directions of emission for a cone of normals, weighted by their cosine beyond it (equation 1): a
/// polynomial through its values π, 2π + π²/2 and 4π for θₒ = 0, π/2 and π, which is within a tenth of the others.
fn solid_angle(cos_theta_o: f32) -> f32 {
    let q = (0.5 * (1.0 - cos_theta_o)).max(0.0).sqrt();
    PI + q * (16.25 - 6.83 * q)
}

/// The sums of the bins along all axes.
fn bins(items: &[Item], binning: &Binning) -> [[BinSum; BINS]; 3] {
    if items.len() <= BINNED_PART {
        return part_bins(items, binning);
    }
    let parts: Vec<_> = items.par_chunks(BINNED_PART).map(|part| part_bins(part, binning)).collect();
    parts.iter().fold([[BinSum::EMPTY; BINS]; 3], |mut sums, part| {
        for (sum, bin) in sums.as_flattened_mut().iter_mut().zip(part.as_flattened()) {
            *sum = sum.union(bin);
        }
        sums
    })
}

fn part_bins(items: &[Item], binning: &Binning) -> [[BinSum; BINS]; 3] {
    let mut bins = [[BinSum::EMPTY; BINS]; 3];
    for item in items {
        let center = item.center();
        for (axis, bins) in bins.iter_mut().enumerate().filter(|(axis, _)| binning.is_used[*axis]) {
            bins[binning.bin(center, axis)].add(item);
        }
    }
    bins
}
