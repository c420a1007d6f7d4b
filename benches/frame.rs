//! Phase times of whole frames: `cargo bench --bench frame [-- SCENE… [--size WxH]]`.
//!
//! Prints one line a scene: the median over several frames of posing, of each step of the build, of tracing and of encoding
//! the EXR. Without arguments it measures the demo.

fn main() {}
