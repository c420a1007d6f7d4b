//! Karras' construction node by node, as in the paper: [`super::radix_tree`] with the boxes of [`super::bottom_up_boxes`].
//!
//! Reference implementation of [`crate::bvh::build::hploc`] without clustering, which builds the same tree in less time.

use rayon::prelude::*;

use super::bottom_up_boxes::BottomUpBoxes;
use super::radix_tree::{LEAF, MortonKey, RadixTree};
use crate::bvh::build::binary_tree::{BinaryTree, LEAF_RANGE, Pair, Subtree};
use crate::bvh::build::morton::MortonOrder;
use crate::bvh::references::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

/// Scratch memory of the builder.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    keys: Vec<MortonKey>,
    radix_tree: RadixTree,
    boxes: BottomUpBoxes,
}

/// Fills `tree` with Karras' tree over `references` in `order`; areas are of boxes multiplied by `scale`.
pub(crate) fn build(
    tree: &mut BinaryTree,
    order: &MortonOrder,
    references: &[Reference],
    scratch: &mut Scratch,
    scale: f32,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    let Scratch { keys, radix_tree, boxes } = scratch;
    (0..order.len())
        .into_par_iter()
        .map(|position| MortonKey { code: order.code(position), index: order.index(position) })
        .collect_into_vec(keys);
    radix_tree.build(keys, cancel)?;
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
    let word = |child: u32| if child & LEAF == 0 { child } else { child & !LEAF | LEAF_RANGE };
    radix_tree
        .nodes
        .par_iter()
        .map(|node| Pair {
            bounds: node.children.map(bounds),
            children: node.children.map(word),
            counts: node.children.map(count),
        })
        .map(|pair| pair.packed())
        .collect_into_vec(&mut tree.nodes);

    keys.par_iter()
        .map(|key| references[key.index as usize].triangle_id)
        .collect_into_vec(&mut tree.triangle_ids);
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
