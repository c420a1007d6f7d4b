//! Renders whose answer is known: every expected number is derived beside it.
//!
//! Pictures are one pixel of one sample, so that the camera's axis is the only camera ray, unless it is about more.

mod distributed;
mod environments;
mod far;
mod glass;
mod light;
mod light_passes;
mod material_extensions;
mod normals;
mod reflection;
mod surface;
