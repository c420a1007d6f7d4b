//! Rays that meet two triangles of one surface where they share an edge or a corner.
//!
//! The triangle test lets nothing through between neighbours, so that a ray exactly on their edge meets both. A surface that
//! is seen through must still count once.

use crate::bvh::Hit;
use crate::interaction::PosedScene;

/// Barycentric weights up to this are on the edge; their own rounding is smaller.
const ON_EDGE: f32 = 1e-6;

/// Whether `hit` is the same crossing of the same surface as `previous`, which came before it on the same ray.
pub(super) fn is_met_again(posed: PosedScene<'_>, previous: &Hit, hit: &Hit) -> bool {
    let shape = |hit: &Hit| posed.frame.shape_of_triangle[hit.primitive as usize];
    let close = hit.t - previous.t <= hit.t * (4.0 * f32::EPSILON);
    close
        && previous.facing == hit.facing
        && on_edge(previous)
        && on_edge(hit)
        && shape(previous) == shape(hit)
}

fn on_edge(hit: &Hit) -> bool {
    hit.u <= ON_EDGE || hit.v <= ON_EDGE || 1.0 - hit.u - hit.v <= ON_EDGE
}
