//! Emissive triangles, which rays can hit.

use glam::{Vec2, Vec3};

use super::emitter_covers::EmitterCovers;
use super::emitters::{coat_transmittance, emitted, emitters};
use super::mis::power_heuristic;
use super::triangle_part::TrianglePart;
use crate::bvh::Hit;
use crate::geometry::{Facing, Ray, Triangle};
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::light_sampling::{LightTree, sample_triangle, triangle_pdf};
use crate::interaction::{RayDifferential, SurfacePoint};
use crate::scene_view::SceneView;

/// The emissive triangles of a frame, prepared for sampling.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct EmissiveTriangles {
    /// What of them emits light, ascending.
    parts: Vec<TrianglePart>,
    /// Luminance of the power of each part.
    powers: Vec<f32>,
    covers: EmitterCovers,
    tree: LightTree,
}

/// A point on an emissive triangle.
#[derive(Clone, Copy)]
pub(super) struct EmitterSample {
    /// Where a shadow ray towards it ends, just off the triangle.
    pub(super) end: Vec3,
    /// Unit vector towards it.
    pub(super) wi: Vec3,
    pub(super) radiance: Vec3,
    /// Density with respect to solid angle.
    pub(super) pdf: f32,
}

impl EmissiveTriangles {
    /// The lights of a frame.
    pub(in crate::integrator) fn new(view: SceneView<'_>) -> Self {
        let (parts, emitters, covers) = emitters(view);
        let powers = emitters.iter().map(|emitter| emitter.power).collect();
        Self { parts, powers, covers, tree: LightTree::new(&emitters, view.bvh.simd_level()) }
    }

    /// What of them emits light, ascending.
    pub(super) fn parts(&self) -> &[TrianglePart] {
        &self.parts
    }

    /// Luminance of the power of each part.
    pub(super) fn powers(&self) -> &[f32] {
        &self.powers
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// The radiance that leaves a point of an emissive triangle, past what covers it.
    pub(super) fn radiance(&self, view: SceneView<'_>, hit: &Hit) -> Vec3 {
        emitted(view, hit) * self.covers.uncovered_share(view, hit)
    }

    /// Samples a point on an emissive triangle for a surface at `position`. `normal` is that of a surface that scatters light of its own side
    /// alone.
    pub(super) fn sample_emitter(
        &self,
        view: SceneView<'_>,
        (position, normal): (Vec3, Option<Vec3>),
        (u_emitter, u): (f32, Vec2),
    ) -> Option<EmitterSample> {
        let (emitter, probability) = self.tree.sample(position, normal, u_emitter)?;
        let part = self.parts[emitter as usize];
        let triangle = part.triangle;
        let Triangle { vertices } = view.frame.triangles[triangle as usize];
        let sample = sample_triangle(part.corners(vertices), position, u)?;
        let [a, b, c] = vertices;
        let is_front = (b - a).cross(c - a).dot(sample.direction) < 0.0;
        let facing = if is_front { Facing::Front } else { Facing::Back };
        let Vec2 { x: u, y: v } = part.in_triangle(Vec2::from(sample.barycentrics));
        let hit = Hit { t: sample.distance, triangle, u, v, facing };
        let radiance = self.radiance(view, &hit);
        if radiance == Vec3::ZERO {
            return None;
        }
        let ray = Ray::new(position, sample.direction);
        let material = &view.frame.materials[view.frame.instance(triangle).material.index()];
        let point = if material.clear_coat.is_some() {
            SurfacePoint::new(view, &ray, &hit, &RayDifferential::ZERO)
        } else {
            SurfacePoint::flat(view, &ray, &hit)
        };
        let radiance = radiance * coat_transmittance(view, &point);
        let pdf = probability * sample.pdf;
        Some(EmitterSample { end: point.origin_outside(), wi: sample.direction, radiance, pdf })
    }

    /// Weight of the emission that a sampled ray finds at a hit.
    pub(super) fn emission_weight(
        &self,
        view: SceneView<'_>,
        hit: &Hit,
        point: &SurfacePoint<'_>,
        last: Option<&LastScatter>,
    ) -> f32 {
        let Some(last) = last else { return 1.0 };
        let at = Vec2::new(hit.u, hit.v);
        let Some(emitter) = TrianglePart::find(&self.parts, hit.triangle, at) else { return 1.0 };
        let Triangle { vertices } = view.frame.triangles[hit.triangle as usize];
        let span = point.position - last.position;
        let pdf = self.tree.probability(last.position, last.normal, emitter as u32)
            * triangle_pdf(self.parts[emitter].corners(vertices), last.position, span.normalize());
        power_heuristic(last.pdf, pdf)
    }
}
