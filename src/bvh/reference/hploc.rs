//! H-PLOC node by node, as in the paper: the reference implementation of [`crate::bvh::build::hploc`].
//!
//! Every leaf of Karras' stored radix tree walks towards the root. The first one to reach a node ends; the second finds the
//! clusters of both children. If they are more than the node's threshold, it merges nearest ones, found by testing all pairs.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::radix_tree::{LEAF, MortonKey, NO_PARENT, RadixTree};
use crate::bvh::box_area::scaled_half_area;
use crate::bvh::build::clustering::Clustering;
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// Subtree with its references.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cluster {
    pub(crate) bounds: Aabb,
    /// Triangles below, sorted.
    pub(crate) triangle_ids: Vec<u32>,
    pub(crate) children: Option<Box<[Self; 2]>>,
}

impl Cluster {
    fn joined(left: Self, right: Self) -> Self {
        let mut triangle_ids = [left.triangle_ids.as_slice(), &right.triangle_ids].concat();
        triangle_ids.sort_unstable();
        let bounds = left.bounds.union(right.bounds);
        Self { bounds, triangle_ids, children: Some(Box::new([left, right])) }
    }
}

/// Clusters that the root passes on.
pub(crate) fn clusters(
    keys: &[MortonKey],
    references: &[Reference],
    clustering: &Clustering,
    scale: f32,
) -> Result<Vec<Cluster>, Cancelled> {
    let mut tree = RadixTree::default();
    tree.build(keys, &CancelFlag::new())?;
    let leaf = |position: u32| {
        let reference = &references[keys[position as usize].index as usize];
        let triangle_ids = vec![reference.triangle_id];
        vec![Cluster { bounds: reference.bounds, triangle_ids, children: None }]
    };
    if keys.len() < 2 {
        return Ok((0..keys.len() as u32).flat_map(leaf).collect());
    }

    // Walk up from all leaves.
    let visits: Vec<AtomicU32> = tree.nodes.iter().map(|_| AtomicU32::new(0)).collect();
    let passed: Vec<Mutex<Vec<Cluster>>> = tree.nodes.iter().map(|_| Mutex::default()).collect();
    let taken = |child: u32| match child & LEAF {
        0 => std::mem::take(&mut *passed[child as usize].lock().unwrap_or_else(PoisonError::into_inner)),
        _ => leaf(child & !LEAF),
    };
    (0..keys.len() as u32).into_par_iter().for_each(|position| {
        let mut child = position | LEAF;
        loop {
            let parent = tree.parent(child);
            if parent == NO_PARENT || visits[parent as usize].fetch_add(1, Ordering::AcqRel) == 0 {
                return;
            }
            let node = &tree.nodes[parent as usize];
            let [first, last] = node.range;
            let mut clusters = node.children.map(taken).concat();
            merge(&mut clusters, clustering, (last - first + 1) as usize, scale);
            *passed[parent as usize].lock().unwrap_or_else(PoisonError::into_inner) = clusters;
            child = parent;
        }
    });
    Ok(taken(0))
}

/// Merges the clusters of a node of `references` down to its threshold.
fn merge(clusters: &mut Vec<Cluster>, clustering: &Clustering, references: usize, scale: f32) {
    let mut slow_rounds = 0;
    while clusters.len() > clustering.threshold(references) {
        let before = clusters.len();
        let nearest: Vec<usize> = if slow_rounds == 2 {
            // All adjacent pairs.
            slow_rounds = 0;
            (0..before).map(|i| if i ^ 1 < before { i ^ 1 } else { i }).collect()
        } else {
            slow_rounds += 1;
            (0..before).map(|i| nearest(clusters, i, clustering.radius as usize, scale)).collect()
        };
        let mut old: Vec<Option<Cluster>> = clusters.drain(..).map(Some).collect();
        for i in 0..before {
            let other = nearest[i];
            let is_mutual = other != i && nearest[other] == i;
            if is_mutual && other > i {
                let pair = [i, other].map(|i| old[i].take());
                if let [Some(left), Some(right)] = pair {
                    clusters.push(Cluster::joined(left, right));
                }
            } else if !is_mutual {
                clusters.extend(old[i].take());
            }
        }
        if (before - clusters.len()) * 16 >= before {
            slow_rounds = 0;
        }
    }
}

/// Cluster within the radius that has the lowest key together with the one at `i`.
fn nearest(clusters: &[Cluster], i: usize, radius: usize, scale: f32) -> usize {
    let key = |j: usize| {
        let area = scaled_half_area(&clusters[i].bounds.union(clusters[j].bounds), scale);
        area.to_bits() & !31 | (i ^ j) as u32 & 31
    };
    let around = i.saturating_sub(radius)..clusters.len().min(i + radius + 1);
    around.filter(|&j| j != i).min_by_key(|&j| key(j)).unwrap_or(i)
}
