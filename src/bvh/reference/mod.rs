//! Reference implementations and validation, which tests compare fast code with.
//!
//! [`karras`] builds the radix tree node by node as in the paper ([`radix_tree`], [`bottom_up_boxes`]), and `hploc` clusters its
//! nodes. [`brute_force`] tests every triangle. [`validate`] checks the invariants of a finished hierarchy.

mod bottom_up_boxes;
mod brute_force;
#[cfg(test)]
pub(super) mod hploc;
pub(super) mod karras;
pub(super) mod radix_tree;
mod validate;

pub(super) use brute_force::TriangleList;
