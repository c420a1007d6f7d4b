//! Early split clipping: smaller boxes for triangles whose own box wastes area.
//!
//! Parts of a triangle get boxes of their own, so that the hierarchy has several references to one triangle. [`gather`]
//! decides whether to split. [`priority`] and [`cut`] split the most wasteful triangles (Karras and Aila 2013), [`area`] those
//! with the largest boxes (Ernst and Greiner 2007).

mod area;
mod cut;
mod gather;
mod priority;

pub(super) use gather::{Scratch, gather};
