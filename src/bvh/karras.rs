//! The paper's hierarchy as a builder: [`super::lbvh`] and [`super::fit`], node by node.
//!
//! [`super::linear_pass`] gives the same tree in a fraction of the time; this one is what it is compared with.

use rayon::prelude::*;

use super::binary_tree::{BinaryTree, PLACES, Pair, Subtree};
use super::fit::FittedBoxes;
use super::lbvh::{Keyed, LEAF, RadixTree};
use super::morton::MortonOrder;
use super::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// Memory of the builder.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    keys: Vec<Keyed>,
    radix_tree: RadixTree,
    boxes: FittedBoxes,
}

/// Fills `tree` with Karras' tree over `references` in `order`; areas are of boxes multiplied by `scale`.
pub(super) fn build(
    tree: &mut BinaryTree,
    order: &MortonOrder,
    references: &[Reference],
    scratch: &mut Scratch,
    (scale, cancel): (f32, &CancelFlag),
) -> Result<(), Cancelled> {
    let Scratch { keys, radix_tree, boxes } = scratch;
    keys.clear();
    keys.extend((0..order.len()).map(|place| Keyed { code: order.code(place), index: order.index(place) }));
    radix_tree.link(keys, cancel)?;
    boxes.fit(radix_tree, keys, references, cancel)?;

    let bounds = |child: u32| -> Aabb {
        if child & LEAF == 0 {
            boxes.bounds(child)
        } else {
            references[keys[(child & !LEAF) as usize].index as usize].bounds
        }
    };
    let count = |child: u32| {
        if child & LEAF == 0 {
            let [first, last] = radix_tree.nodes[child as usize].range;
            last - first + 1
        } else {
            1
        }
    };
    let word = |child: u32| if child & LEAF == 0 { child } else { child & !LEAF | PLACES };
    radix_tree
        .nodes
        .par_iter()
        .map(|node| Pair {
            bounds: node.children.map(bounds),
            children: node.children.map(word),
            counts: node.children.map(count),
        })
        .collect_into_vec(&mut tree.nodes);

    tree.primitives.clear();
    tree.primitives.extend(keys.iter().map(|key| references[key.index as usize].primitive));
    let root = if keys.len() == 1 { LEAF } else { 0 };
    tree.root = (!keys.is_empty()).then(|| Subtree {
        bounds: bounds(root),
        child: word(root),
        count: keys.len() as u32,
        height: boxes.depth(),
    });
    tree.area_sum = 0.5 * f64::from(scale).powi(2) * boxes.inner_area_sum();
    Ok(())
}
