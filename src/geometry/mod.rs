//! Rays, boxes and triangles, and the one definition of what a hit is.
//!
//! Everything here is a pure function of its arguments in a fixed sequence of IEEE 754 operations (no fused
//! multiply-add, no approximate reciprocal), so that every caller on every machine gets the same bits.

mod aabb;
mod clip;
mod ray;
mod triangle;
mod watertight;

pub use aabb::Aabb;
pub use clip::TrianglePart;
pub use ray::Ray;
pub use triangle::{Facing, Triangle, TriangleHit};
pub use watertight::{BOX_PADDING, ShearedRay, dominant_axes};
