//! Bounding volume hierarchy over the world-space triangles of one frame.
//!
//! [`Builder::build`] turns the triangles into a [`Bvh`]. Three queries trace it: the closest visible hit, the closest hit of
//! either side, and occlusion. Rays are traced one by one; the first and the last query also take batches.
//!
//! | module | holds |
//! |---|---|
//! | `references`, `lane_boxes` | the boxes that a hierarchy is built over |
//! | `split` | early split clipping: several boxes for triangles with wasteful ones |
//! | `build` | Morton codes, radix sort, Karras' radix tree with clustering, collapse to eight children, refit, cost model |
//! | `wide_tree` | the memory layout that rays traverse |
//! | `traverse` | single rays and packets |
//! | `reference` | the papers' per-node construction, brute force and validation, for tests |
//! | `builder`, `hierarchy` | the phases of a build, and its result with the queries |
//!
//! Builders know only boxes. Traversal knows only triangles and their [`TriangleFlags`]. Neither knows materials.
//!
//! Settings change the time of a query, never its answer, to the last bit: [`crate::geometry`] defines what a hit is, and of
//! hits with equal `t` the lowest triangle index wins.

mod box_area;
mod build;
mod builder;
mod hierarchy;
mod hit;
mod lane_boxes;
mod outer_boxes;
mod reference;
mod references;
mod settings;
mod simd;
mod split;
mod statistics;
mod traverse;
mod triangle_flags;
mod wide_tree;

pub use builder::Builder;
pub use hierarchy::Bvh;
pub use hit::{Hit, HitOrder};
pub use settings::{BuildSettings, BuilderKind, Refit, Split};
pub use simd::SimdLevel;
pub use statistics::{BuildKind, BuildStatistics, RebuildReason, TraversalCounters};
pub use triangle_flags::TriangleFlags;
pub(crate) use triangle_flags::is_traced;
pub use wide_tree::MAX_TRIANGLES;
