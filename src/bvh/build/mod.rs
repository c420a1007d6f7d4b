//! Construction of hierarchies from boxes.
//!
//! Boxes are sorted by the Morton codes of their centres ([`morton`], [`radix_sort`]). A binary tree over that order
//! ([`binary_tree`]) is Karras' radix tree ([`ranges`], [`radix_scan`]), whose nodes merge clusters where [`cost_model`] expects
//! that to pay ([`hploc`], [`clustering`], [`cluster_scan`], [`clusters`], [`sweep`]). The binary tree is collapsed to the wide tree that rays
//! traverse ([`collapse`]). A wide tree of the last frame is refitted instead where that pays ([`refit`]).

pub(super) mod binary_tree;
mod cluster_scan;
pub(super) mod clustering;
mod clusters;
pub(super) mod collapse;
pub(super) mod cost_model;
pub(super) mod hploc;
pub(super) mod morton;
mod radix_scan;
mod radix_sort;
mod ranges;
mod refit;
mod sweep;

pub(super) use refit::{Attempt, Refitter};
