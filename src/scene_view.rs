//! One frame as the renderer reads it: scene, posed frame, hierarchy and environment.

use crate::bvh::Bvh;
use crate::frame::Frame;
use crate::scene::{Environment, Scene};

/// Everything that rays of one frame interact with. The parts belong together: `frame` poses `scene`, `bvh` holds the triangles of
/// `frame`.
#[derive(Clone, Copy, Debug)]
pub struct SceneView<'a> {
    /// Images, texture coordinates and vertex colours.
    pub scene: &'a Scene,
    /// The scene at one time.
    pub frame: &'a Frame,
    /// Hierarchy over the frame's triangles.
    pub bvh: &'a Bvh,
    /// Light from outside the scene.
    pub environment: &'a Environment,
}
