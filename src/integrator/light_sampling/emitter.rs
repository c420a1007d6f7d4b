//! Triangles that emit light.

use glam::Vec3;

/// An emissive triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emitter {
    /// Corners in world space; the front is where they are counterclockwise.
    pub(crate) corners: [Vec3; 3],
    /// Luminance of the mean radiance × area × π, of both sides together.
    pub(crate) power: f32,
    /// Whether the back emits as the front does.
    pub(crate) is_two_sided: bool,
}
