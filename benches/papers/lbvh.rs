//! Linear hierarchies over Morton codes: the radix tree of Karras 2012, and HLBVH as Garanzha, Pantaleoni and McAllister 2011.

use glam::Vec3;
use rayon::prelude::*;

use rayframe::geometry::Aabb;

use super::hierarchy::{Bvh2, Node};
use super::references::{Reference, center_bounds};
use super::sah_bvh;

/// Bits of a code an axis: those of the product, and those of HLBVH.
const FINE_BITS: u32 = 21;
const HLBVH_BITS: u32 = 10;
/// Leading bits of a code that all references of a cluster share.
const CLUSTER_BITS: u32 = 15;

/// A reference with its Morton code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coded {
    pub(crate) code: u64,
    pub(crate) reference: Reference,
}

/// The Morton code of a point of the unit cube: the bits of z, y and x in turn, x highest.
pub(crate) fn morton_code(point: Vec3, bits: u32) -> u64 {
    let cells = (1_u64 << bits) as f32;
    let last = (1_u64 << bits) - 1;
    let cell = |component: f32| ((component * cells) as u64).min(last);
    let [x, y, z] = point.to_array().map(cell);
    (0..bits).fold(0, |code, bit| {
        let of = |cell: u64, place: u32| (cell >> bit & 1) << (3 * bit + place);
        code | of(x, 2) | of(y, 1) | of(z, 0)
    })
}

/// References in the order of their codes; of equal ones, in theirs.
pub(crate) fn sorted(references: &[Reference], bits: u32) -> Vec<Coded> {
    let centers = center_bounds(references);
    let scale = centers.extent().map(|extent| if extent > 0.0 { 1.0 / extent } else { 0.0 });
    let code = |reference: &Reference| Coded {
        code: morton_code((reference.bounds.center() - centers.min) * scale, bits),
        reference: *reference,
    };
    let mut coded: Vec<_> = references.par_iter().map(code).collect();
    coded.par_sort_by_key(|coded| coded.code);
    coded
}

/// Number of references of `sorted` below the left child: those whose highest differing bit is 0; half of equal codes.
pub(crate) fn split_of(sorted: &[Coded]) -> usize {
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return 0 };
    let difference = first.code ^ last.code;
    if difference == 0 {
        return sorted.len() / 2;
    }
    let highest = difference.ilog2();
    sorted.partition_point(|coded| coded.code >> highest & 1 == 0)
}

/// Karras' tree, from the top. The product builds the same from every node at once.
pub(crate) fn karras(references: &[Reference]) -> Bvh2 {
    let sorted = sorted(references, FINE_BITS);
    let mut tree =
        Bvh2 { nodes: Vec::new(), references: sorted.iter().map(|coded| coded.reference).collect() };
    if !sorted.is_empty() {
        tree.nodes.push(Node { bounds: Aabb::EMPTY, first: 0, count: 0 });
        run_queue(&mut tree.nodes, &sorted, vec![(0, 0..sorted.len())]);
    }
    tree
}

/// HLBVH: clusters of common leading bits get a tree by the surface area heuristic, and are trees of middle splits below.
pub(crate) fn hlbvh(references: &[Reference]) -> Bvh2 {
    let sorted = sorted(references, HLBVH_BITS);
    let cluster = |coded: &Coded| coded.code >> (3 * HLBVH_BITS - CLUSTER_BITS);
    let mut clusters = Vec::new();
    for chunk in sorted.chunk_by(|a, b| cluster(a) == cluster(b)) {
        let first = clusters.last().map_or(0, |range: &std::ops::Range<usize>| range.end);
        clusters.push(first..first + chunk.len());
    }

    // The tree over clusters, whose leaves have one each.
    let boxes = (0_u32..).zip(&clusters).map(|(index, range)| {
        let bounds =
            sorted[range.clone()].iter().fold(Aabb::EMPTY, |all, coded| all.union(coded.reference.bounds));
        Reference { bounds, triangle: index }
    });
    let top = sah_bvh::single_leaves(boxes.collect());

    // The clusters in the order of the leaves, so that every node has a range of references.
    let ordered: Vec<_> =
        top.references.iter().map(|leaf| clusters[leaf.triangle as usize].clone()).collect();
    let coded: Vec<_> = ordered.iter().flat_map(|range| sorted[range.clone()].iter().copied()).collect();
    let mut starts = Vec::with_capacity(ordered.len());
    let mut start = 0;
    for range in &ordered {
        starts.push(start..start + range.len());
        start += range.len();
    }
    let mut nodes = top.nodes;
    let leaves: Vec<_> = (0..nodes.len()).filter(|&index| nodes[index].count > 0).collect();
    let mut queue = Vec::new();
    for index in leaves {
        queue.push((index, starts[nodes[index].first as usize].clone()));
    }
    run_queue(&mut nodes, &coded, queue);
    Bvh2 { nodes, references: coded.iter().map(|coded| coded.reference).collect() }
}

/// Splits the nodes of a queue; the children of all are the next queue. Boxes follow from the leaves up.
fn run_queue(nodes: &mut Vec<Node>, sorted: &[Coded], mut queue: Vec<(usize, std::ops::Range<usize>)>) {
    let first_made = queue.iter().map(|(index, _)| *index).min().unwrap_or(0);
    while !queue.is_empty() {
        let splits: Vec<_> = queue
            .par_iter()
            .map(
                |(_, range)| {
                    if range.len() > 1 { range.start + split_of(&sorted[range.clone()]) } else { range.end }
                },
            )
            .collect();
        let mut next = Vec::with_capacity(queue.len() * 2);
        for ((index, range), split) in queue.iter().zip(splits) {
            if range.len() == 1 {
                let bounds = sorted[range.start].reference.bounds;
                nodes[*index] = Node { bounds, first: range.start as u32, count: 1 };
                continue;
            }
            let child = nodes.len();
            nodes[*index] = Node { bounds: Aabb::EMPTY, first: child as u32, count: 0 };
            nodes.resize(child + 2, nodes[*index]);
            next.extend([(child, range.start..split), (child + 1, split..range.end)]);
        }
        queue = next;
    }
    for index in (first_made..nodes.len()).rev() {
        let node = nodes[index];
        if node.count == 0 {
            let [a, b] = [node.first, node.first + 1].map(|child| nodes[child as usize].bounds);
            nodes[index].bounds = a.union(b);
        }
    }
}
