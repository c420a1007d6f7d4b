//! Rays, boxes and triangles, and the one definition of what a hit is.
//!
//! Everything here is a pure function of its arguments in a fixed sequence of IEEE 754 operations, so that every caller on
//! every machine gets the same bits: no approximate reciprocal, and a fused multiply-add only where the rounding error of a
//! product is asked for.

mod aabb;
mod clip;
mod disk;
mod ray;
mod triangle;
mod unit;
mod watertight;

pub use aabb::Aabb;
pub use clip::{TrianglePart, rounded_down, rounded_up};
pub use disk::concentric_disk_point;
pub use ray::Ray;
pub use triangle::{Facing, Triangle, TriangleHit};
pub use unit::unit;
pub use watertight::{BOX_PADDING, ShearedRay, dominant_axes};
