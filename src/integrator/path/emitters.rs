//! Emissive triangles of a frame.

use glam::Vec3;
use rayon::prelude::*;

use crate::bsdf::Coat;
use crate::bvh::{Hit, TriangleFlags};
use crate::color::luminance;
use crate::frame::MeshInstance;
use crate::geometry::Facing;
use crate::integrator::light_sampling::Emitter;
use crate::interaction::{SurfacePoint, catches_shadows, clear_coat_at, emission_at};
use crate::scene_view::SceneView;

/// Points along each side of a textured triangle at which its emission is measured.
const STEPS: u32 = 6;

/// Ids of the emissive triangles, ascending, and what a light tree needs to know of each.
pub(super) fn emitters(view: SceneView<'_>) -> (Vec<u32>, Vec<Emitter>) {
    let instances = view.frame.instances.par_iter().map(|instance| emitters_of(view, instance));
    let by_instance: Vec<Vec<(u32, Emitter)>> = instances.collect();
    by_instance.into_iter().flatten().unzip()
}

fn emitters_of(view: SceneView<'_>, instance: &MeshInstance) -> Vec<(u32, Emitter)> {
    let material = &view.frame.materials[instance.material.index()];
    if material.unlit || material.emissive.max_element() <= 0.0 || material.is_shadow_catcher {
        return Vec::new();
    }
    let is_textured = material.emissive_texture.is_some() || material.base_color_texture.is_some();
    let steps = if is_textured { STEPS } else { 1 };
    let count = instance.primitive(view.scene).triangles.len() as u32;
    let ids = instance.first_triangle..instance.first_triangle + count;
    ids.filter_map(|triangle| Some((triangle, emitter(view, triangle, steps)?))).collect()
}

/// The emitter of a triangle; `None` where no light is found on it.
fn emitter(view: SceneView<'_>, triangle: u32, steps: u32) -> Option<Emitter> {
    let flags = view.frame.flags[triangle as usize];
    if flags.has(TriangleFlags::HIDDEN) {
        return None;
    }
    let corners = view.frame.triangles[triangle as usize].vertices;
    let (mut sum, mut points) = (0.0, 0);
    for (row, column) in (0..steps).flat_map(|row| (0..steps - row).map(move |column| (row, column))) {
        let at = |step: u32| (step as f32 + 1.0 / 3.0) / steps as f32;
        let hit = Hit { t: 0.0, triangle, u: at(row), v: at(column), facing: Facing::Front };
        sum += luminance(emission_at(view, &hit));
        points += 1;
    }
    let is_two_sided = !flags.has(TriangleFlags::SINGLE_SIDED);
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let sides = if is_two_sided { 2.0 } else { 1.0 };
    let power = sum / points as f32 * area * sides * std::f32::consts::PI;
    (power > 0.0 && power < f32::INFINITY).then_some(Emitter { corners, power, is_two_sided })
}

/// Radiance that leaves a point of a triangle towards a viewer; zero on the back of a single-sided one.
pub(super) fn emitted(view: SceneView<'_>, hit: &Hit) -> Vec3 {
    let flags = view.frame.flags[hit.triangle as usize];
    let is_back = hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED);
    if is_back || catches_shadows(view, hit) { Vec3::ZERO } else { emission_at(view, hit) }
}

/// Share of the emission of a point that passes its coat.
pub(super) fn coat_transmittance(view: SceneView<'_>, point: &SurfacePoint<'_>) -> f32 {
    clear_coat_at(view, point)
        .map_or(1.0, |coat| Coat::new(coat.factor, coat.roughness).transmittance(point.wo.dot(coat.normal)))
}
