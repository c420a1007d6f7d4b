//! Surfaces that hide what is behind them.

use crate::bvh::Hit;
use crate::interaction::{alpha_at, catches_shadows};
use crate::scene::Material;
use crate::scene_view::SceneView;

/// Whether a surface hides what is behind it: it is at least half opaque, catches no shadows and is not of a transmissive material for which `passes_light` holds.
pub(super) fn is_wall(view: SceneView<'_>, hit: &Hit, passes_light: impl Fn(&Material) -> bool) -> bool {
    let material = &view.frame.materials[view.frame.instance(hit.triangle).material.index()];
    let is_passed = material.transmits() && passes_light(material);
    alpha_at(view, hit) >= 0.5 && !is_passed && !catches_shadows(view, hit)
}
