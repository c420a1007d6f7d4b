//! Points on emissive triangles, chosen by their expected share of the light at a point.
//!
//! | module | holds |
//! |---|---|
//! | `light_tree`, `wide_light_node`, `emitter` | the choice of one of many emissive triangles |
//! | `light_tree_build`, `light_tree_collapse`, `light_node`, `light_bounds` | construction of the tree |
//! | `triangle` | points on an emissive triangle |
//!
//! Every choice comes with its probability or its density, which can also be asked for the choice of another technique, for
//! multiple importance sampling. Lights, materials and visibility are not known here.

mod emitter;
mod light_bounds;
mod light_node;
mod light_tree;
mod light_tree_build;
mod light_tree_collapse;
mod triangle;
mod wide_light_node;

pub(crate) use emitter::Emitter;
pub(crate) use light_tree::LightTree;
pub(crate) use triangle::{sample_triangle, triangle_pdf};
