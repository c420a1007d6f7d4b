//! Renders whose answer is known: every expected number is derived beside it.
//!
//! Pictures are one pixel of one sample, so that the camera's axis is the only camera ray, unless it is about more.

mod distributed;
mod far;
mod glass;
mod layers;
mod light;
mod normals;
mod parts;
mod reflection;
mod stage;
mod surface;
mod surroundings;
