//! Shared code of the benchmarks of the hierarchy: test scenes, builds and traces of rayframe and of obvhs, and their clocks.

pub mod build;
pub mod chunks;
pub mod clock;
pub mod configuration;
pub mod hierarchy;
pub mod obvhs_build;
pub mod obvhs_preset;
pub mod obvhs_trace;
pub mod ray_set;
pub mod soup;
pub mod surface;
pub mod test_scenes;
pub mod trace;
