//! Top-down construction by the surface area heuristic (Ernst and Greiner 2007, Algorithm 2): full sweeps over sorted centres, and
//! binned as Wald 2007.

use rayframe::geometry::Aabb;

use super::hierarchy::{Bvh2, Node};
use super::references::{Reference, bounds_of, center_bounds};

const BINS: usize = 16;
/// Largest leaf. Larger ones are split even where the heuristic would not.
const MOST_IN_LEAF: usize = 8;

/// Builds with every position between two sorted centres as a candidate.
pub(crate) fn full_sweep(references: Vec<Reference>) -> Bvh2 {
    top_down(references, &sweep)
}

/// Builds with sixteen bins along the longest axis of the centres.
pub(crate) fn binned(references: Vec<Reference>) -> Bvh2 {
    top_down(references, &bin)
}

/// Binned, with one reference a leaf.
pub(crate) fn single_leaves(references: Vec<Reference>) -> Bvh2 {
    top_down(references, &|references| bin(references).or(Some(references.len() / 2)))
}

/// Builds from the root. `split` reorders references and returns how many go left; `None` makes a leaf.
pub(crate) fn top_down(
    mut references: Vec<Reference>,
    split: &dyn Fn(&mut [Reference]) -> Option<usize>,
) -> Bvh2 {
    let mut nodes = Vec::with_capacity(references.len() * 2);
    let node = |references: &[Reference], first: usize| Node {
        bounds: bounds_of(references),
        first: first as u32,
        count: references.len() as u32,
    };
    if !references.is_empty() {
        nodes.push(node(&references, 0));
    }
    let mut pending = vec![0_usize];
    while let Some(index) = pending.pop().filter(|&index| index < nodes.len()) {
        let first = nodes[index].first as usize;
        let range = &mut references[first..first + nodes[index].count as usize];
        let Some(left) = (range.len() > 1).then(|| split(range)).flatten() else { continue };
        let (a, b) = range.split_at(left);
        nodes[index].first = nodes.len() as u32;
        nodes[index].count = 0;
        pending.extend([nodes.len() + 1, nodes.len()]);
        let children = [node(a, first), node(b, first + left)];
        nodes.extend(children);
    }
    Bvh2 { nodes, references }
}

fn sweep(references: &mut [Reference]) -> Option<usize> {
    let count = references.len();
    let mut best: Option<(f64, usize, usize)> = None;
    let mut right_areas = vec![0.0; count];
    for axis in 0..3 {
        sort_along(references, axis);
        let mut right = Aabb::EMPTY;
        for at in (1..count).rev() {
            right = right.union(references[at].bounds);
            right_areas[at] = right.area();
        }
        let mut left = Aabb::EMPTY;
        for at in 1..count {
            left = left.union(references[at - 1].bounds);
            let cost = left.area() * at as f64 + right_areas[at] * (count - at) as f64;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, at));
            }
        }
    }
    let (cost, axis, at) = best?;
    if is_leaf_cheaper(references, cost) {
        return None;
    }
    sort_along(references, axis);
    Some(at)
}

/// Sorts by the centres of boxes; equal ones by triangle, so that the order is one.
fn sort_along(references: &mut [Reference], axis: usize) {
    let center = |reference: &Reference| reference.bounds.min[axis] + reference.bounds.max[axis];
    references.sort_unstable_by(|a, b| center(a).total_cmp(&center(b)).then(a.triangle.cmp(&b.triangle)));
}

fn bin(references: &mut [Reference]) -> Option<usize> {
    let centers = center_bounds(references);
    let axis = centers.extent().max_position();
    let (low, extent) = (centers.min[axis], centers.extent()[axis]);
    let scale = BINS as f32 * (1.0 - 1.0e-6) / extent;
    if !scale.is_finite() {
        return (references.len() > MOST_IN_LEAF).then_some(references.len() / 2);
    }
    let bin_of = |reference: &Reference| ((reference.bounds.center()[axis] - low) * scale) as usize;
    let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
    for reference in references.iter() {
        let bin = &mut bins[bin_of(reference).min(BINS - 1)];
        *bin = (bin.0.union(reference.bounds), bin.1 + 1);
    }
    let join = |bins: &[(Aabb, usize)]| {
        bins.iter().fold((Aabb::EMPTY, 0), |(all, count), bin| (all.union(bin.0), count + bin.1))
    };
    let cost = |at: usize| {
        let ((left, left_count), (right, right_count)) = (join(&bins[..at]), join(&bins[at..]));
        left.area() * left_count as f64 + right.area() * right_count as f64
    };
    let (cost, at) = (1..BINS).map(|at| (cost(at), at)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    if is_leaf_cheaper(references, cost) {
        return None;
    }
    let left = partition(references, |reference| bin_of(reference).min(BINS - 1) < at);
    if left == 0 || left == references.len() { Some(references.len() / 2) } else { Some(left) }
}

/// Whether a leaf costs less than children whose areas times counts sum to `children`, with unit costs.
fn is_leaf_cheaper(references: &[Reference], children: f64) -> bool {
    let area = bounds_of(references).area();
    references.len() <= MOST_IN_LEAF && references.len() as f64 * area <= area + children
}

/// Moves those that satisfy `is_left` to the front; returns their number.
pub(crate) fn partition<T: Copy>(items: &mut [T], is_left: impl Fn(&T) -> bool) -> usize {
    let mut left = 0;
    for at in 0..items.len() {
        if is_left(&items[at]) {
            items.swap(at, left);
            left += 1;
        }
    }
    left
}
