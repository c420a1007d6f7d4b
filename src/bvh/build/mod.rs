//! Construction of hierarchies from boxes.
//!
//! Boxes are sorted by the Morton codes of their centres ([`morton`], [`radix_sort`]). A binary tree over that order
//! ([`binary_tree`]) is the radix tree ([`lbvh`]) or the result of clustering ([`ploc`], [`clusters`], [`sweep`]);
//! [`cost_model`] chooses. The binary tree is collapsed to the wide tree that rays traverse ([`collapse`]). A wide tree of
//! the last frame is refitted instead where that pays ([`refit`]).

pub(super) mod binary_tree;
mod clusters;
pub(super) mod collapse;
pub(super) mod cost_model;
pub(super) mod lbvh;
pub(super) mod morton;
pub(super) mod ploc;
mod radix_sort;
mod refit;
mod sweep;

pub(super) use refit::{Attempt, Refitter};
