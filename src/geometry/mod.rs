//! Rays, boxes and triangles, and the one ray-triangle intersection test.
//!
//! Every function is a fixed sequence of IEEE 754 operations on its arguments, so that all machines compute the same bits. No
//! function uses an approximate reciprocal or a fused multiply-add.

mod aabb;
mod active_lanes;
mod clip;
mod direction_sample;
mod disk;
mod hit;
mod lanes;
mod ray;
mod sin_cos;
mod smoothstep;
mod spiral;
mod triangle;
mod unit;
mod watertight;

pub use aabb::Aabb;
pub(crate) use active_lanes::ActiveLanes;
pub(crate) use clip::{ClippedTriangle, rounded_down, rounded_up};
pub(crate) use direction_sample::DirectionSample;
pub(crate) use disk::concentric_disk_point;
pub use hit::{Facing, TriangleHit};
pub(crate) use lanes::{F32Lanes, LANES, Vec2Lanes, Vec3Lanes, compiled_for, vectorized};
pub use ray::Ray;
pub(crate) use sin_cos::sin_cos_of_turn;
pub(crate) use smoothstep::{smoothstep, smoothstep_f64};
pub(crate) use spiral::{GOLDEN_ANGLE, spiral_direction};
pub use triangle::Triangle;
pub(crate) use triangle::are_clearly_regular;
pub(crate) use unit::{normalized_or, unit, unit_or};
pub(crate) use watertight::{BOX_PADDING, ShearedRay, dominant_axes};
