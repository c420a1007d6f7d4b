//! Emissive triangles of a frame. Those whose texture varies are divided where it does.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::emitter_covers::EmitterCovers;
use super::triangle_part::{MOST_HALVINGS, TrianglePart};
use crate::bsdf::Coat;
use crate::bvh::{Hit, TriangleFlags};
use crate::color::luminance;
use crate::frame::MeshInstance;
use crate::geometry::Facing;
use crate::integrator::light_sampling::Emitter;
use crate::interaction::{
    SurfacePoint, catches_shadows, clear_coat_at, emission_around, emission_at, emission_texels,
};
use crate::scene_view::SceneView;

/// Texels of the full image along a cell, the smallest part of a triangle whose emission is measured.
const CELL_TEXELS: f32 = 8.0;
/// Halvings of the edges of textured triangles down to a cell, unless these have fewer texels.
const LEAST_HALVINGS: u32 = 1;
/// Cells of all triangles of an instance that are measured, unless [`LEAST_HALVINGS`] make more.
const MOST_CELLS: u32 = 1 << 18;
/// Parts with less than this share of the power of all emitters are not divided.
const LEAST_SHARE: f64 = 1.0 / 4096.0;
/// Parts are not divided where the emission of their cells varies by this factor at most.
const EVEN_RATIO: f32 = 2.0;

/// The parts of triangles that emit light, ascending, what a light tree needs to know of each, and what covers them. Triangles that no ray hits
/// are left out.
pub(super) fn emitters(view: SceneView<'_>) -> (Vec<TrianglePart>, Vec<Emitter>, EmitterCovers) {
    let instances = view.frame.instances.par_iter().map(|instance| lit_triangles(view, instance));
    let mut triangles: Vec<LitTriangle> = instances.collect::<Vec<_>>().into_iter().flatten().collect();
    let ids: Vec<u32> = triangles.iter().map(|triangle| triangle.triangle).collect();
    let (covers, hidden) = EmitterCovers::new(view, &ids);
    triangles.retain(|triangle| hidden.binary_search(&triangle.triangle).is_err());
    let power: f64 = triangles.iter().map(|triangle| f64::from(triangle.power)).sum();
    let least_power = (power * LEAST_SHARE) as f32;
    let parts = triangles.par_iter().map(|triangle| triangle.parts(view, least_power));
    let (parts, emitters) = parts.collect::<Vec<_>>().into_iter().flatten().unzip();
    (parts, emitters, covers)
}

/// A triangle that emits light.
struct LitTriangle {
    triangle: u32,
    /// Halvings of its edges down to a cell.
    halvings: u32,
    /// As that of an [`Emitter`].
    power: f32,
}

fn lit_triangles(view: SceneView<'_>, instance: &MeshInstance) -> Vec<LitTriangle> {
    let material = &view.frame.materials[instance.material.index()];
    if material.unlit || material.emissive.max_element() <= 0.0 || material.is_shadow_catcher {
        return Vec::new();
    }
    let count = instance.primitive(view.scene).triangles.len() as u32;
    let most_halvings = ((MOST_CELLS / count.max(1)).max(1).ilog2() / 2).clamp(LEAST_HALVINGS, MOST_HALVINGS);
    let ids = instance.first_triangle..instance.first_triangle + count;
    let lit = ids
        .into_par_iter()
        .filter(|&triangle| !view.frame.flags[triangle as usize].has(TriangleFlags::HIDDEN));
    let lit = lit.map(|triangle| {
        let texels = emission_texels(view, triangle);
        let to_cells = halvings_between(CELL_TEXELS, texels).max(LEAST_HALVINGS);
        let halvings = to_cells.min(halvings_between(1.0, texels)).min(most_halvings);
        let cells = cells_of(view, triangle, halvings);
        LitTriangle { triangle, halvings, power: power_of(view, triangle, mean(&cells)) }
    });
    lit.filter(|lit| lit.power > 0.0 && lit.power < f32::INFINITY).collect()
}

/// Halvings of `length` to `target` or less.
fn halvings_between(target: f32, length: f32) -> u32 {
    (0..MOST_HALVINGS)
        .find(|&halvings| length <= target * (1_u32 << halvings) as f32)
        .unwrap_or(MOST_HALVINGS)
}

/// The power of a triangle with this mean luminance of its radiance.
fn power_of(view: SceneView<'_>, triangle: u32, luminance: f32) -> f32 {
    let [a, b, c] = view.frame.triangles[triangle as usize].vertices;
    let area = 0.5 * (b - a).cross(c - a).length();
    let sides = if is_two_sided(view, triangle) { 2.0 } else { 1.0 };
    luminance * area * sides * std::f32::consts::PI
}

fn is_two_sided(view: SceneView<'_>, triangle: u32) -> bool {
    !view.frame.flags[triangle as usize].has(TriangleFlags::SINGLE_SIDED)
}

impl LitTriangle {
    /// The parts of the triangle that emit light. Those of less than `least_power` are not divided.
    fn parts(&self, view: SceneView<'_>, least_power: f32) -> Vec<(TrianglePart, Emitter)> {
        let whole = TrianglePart::whole(self.triangle);
        let corners = view.frame.triangles[self.triangle as usize].vertices;
        let is_two_sided = is_two_sided(view, self.triangle);
        if self.halvings == 0 || self.power < least_power {
            return vec![(whole, Emitter { corners, power: self.power, is_two_sided })];
        }
        let least_share = least_power / power_of(view, self.triangle, 1.0);
        let mut parts = Vec::new();
        divide(whole, &cells_of(view, self.triangle, self.halvings), least_share, &mut parts);
        let emitter = |(part, share): (TrianglePart, f32)| {
            let power = power_of(view, self.triangle, share);
            (part, Emitter { corners: part.corners(corners), power, is_two_sided })
        };
        parts.into_iter().map(emitter).collect()
    }
}

/// Adds the lit parts of a part to `parts`, each with its share of the mean luminance of the triangle. `cells` are those of the part.
fn divide(part: TrianglePart, cells: &[f32], least_share: f32, parts: &mut Vec<(TrianglePart, f32)>) {
    let share = mean(cells) * part.area_share();
    let [least, most] =
        cells.iter().fold([f32::INFINITY, 0.0], |[least, most], &cell| [cell.min(least), cell.max(most)]);
    if most <= 0.0 {
        return;
    }
    if share < least_share || cells.len() < 4 || most <= least * EVEN_RATIO {
        return parts.push((part, share));
    }
    for (quarter, cells) in part.quarters().into_iter().zip(cells.chunks_exact(cells.len() / 4)) {
        divide(quarter, cells, least_share, parts);
    }
}

/// The luminance of the emission of all cells of a triangle, in the order of the parts.
fn cells_of(view: SceneView<'_>, triangle: u32, halvings: u32) -> Vec<f32> {
    let hit = |at: Vec2| Hit { t: 0.0, triangle, u: at.x, v: at.y, facing: Facing::Front };
    if halvings == 0 {
        return vec![luminance(emission_at(view, &hit(Vec2::splat(1.0 / 3.0))))];
    }
    let mut cells = vec![TrianglePart::whole(triangle)];
    for _ in 0..halvings {
        cells = cells.into_iter().flat_map(TrianglePart::quarters).collect();
    }
    let at = |point: Vec2| luminance(emission_around(view, &hit(point), halvings));
    // Texels of a mip level are as wide as the cells: the middle and points near the corners see all that a cell touches.
    let mean = |cell: TrianglePart| {
        let corners = cell.barycentrics();
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let near_corners: f32 = corners.map(|corner| at(middle + (corner - middle) * 0.9)).iter().sum();
        (at(middle) + near_corners) / 4.0
    };
    cells.into_iter().map(mean).collect()
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
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
