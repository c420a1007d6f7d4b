//! Early split clipping: smaller boxes for triangles whose own box wastes area.
//!
//! Parts of a triangle get boxes of their own, so that the hierarchy has several references to one triangle. [`gather`]
//! decides whether to split. [`priority`] and [`cut`] split the most wasteful triangles (Karras and Aila 2013). [`clip`],
//! [`threshold`] and [`budget`] split by area (Ernst and Greiner 2007).

mod budget;
mod clip;
mod cut;
mod gather;
mod priority;
mod threshold;

pub(super) use gather::{Scratch, gather};
