//! What the rays of a generation see: surfaces, through see-through ones too, or what surrounds the scene.

use std::time::Instant;

use super::wavefront::{Place, Wavefront};
use super::{LEAST_WEIGHT, Tracer, seconds_since};
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::integrator::{LightPass, PASS_THROUGH_LIMIT, RayKind, RayState};
use crate::interaction::{alpha_at, catches_shadows};

/// A surface that a ray sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceHit {
    /// The ray.
    pub(super) place: Place,
    pub(super) hit: Hit,
    /// Share of the ray that see-through surfaces in front and the surface's own coverage leave.
    pub(super) share: f32,
    /// See [`RayState::part`]; what lies behind see-through surfaces is a part by itself.
    pub(super) part: Option<LightPass>,
}

impl Tracer<'_, '_> {
    /// Finds everything that a generation sees, in the order of rays and along each ray.
    pub(super) fn find_surface_hits(&mut self, wavefront: &mut Wavefront) {
        // First hits, all rays of a kind at once
        let view = self.context.view;
        let start = Instant::now();
        wavefront.find_hits(self.context.view.bvh, |hit| alpha_at(view, hit) > 0.0, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);

        // What follows from them, ray by ray
        self.surface_hits.clear();
        for &place in wavefront.in_order() {
            let (ray, state) = wavefront.ray(place);
            let first = state.touching.or(wavefront.hit(place));
            match state.kind {
                RayKind::Camera => {
                    self.statistics.camera_rays += 1;
                    self.statistics.camera_hits += u64::from(first.is_some());
                }
                RayKind::Reflection => self.statistics.reflection_rays += 1,
                RayKind::Refraction => self.statistics.refraction_rays += 1,
            }
            self.follow(place, (ray, state), first);
        }
    }

    /// Follows one ray from its first hit through see-through surfaces up to a solid one or out of the scene.
    fn follow(&mut self, place: Place, (ray, state): (&Ray, &RayState), first: Option<Hit>) {
        let view = self.context.view;
        let weight = state.weight.max_element();
        let mut through = 1.0_f32;
        let mut part = state.part;
        let mut next = first;
        for _ in 0..PASS_THROUGH_LIMIT {
            let Some(hit) = next else {
                return self.escape((ray, state), through, part);
            };
            let alpha = if catches_shadows(view, &hit) {
                self.caught_shadow(ray, state, &hit)
            } else {
                let alpha = alpha_at(view, &hit);
                let surface_hit = SurfaceHit { place, hit, share: through * alpha, part };
                self.records.cover(view, state, &surface_hit);
                self.surface_hits.push(surface_hit);
                part = part.or(Some(LightPass::Transparency));
                alpha
            };
            through *= 1.0 - alpha;
            if weight * through < LEAST_WEIGHT {
                self.statistics.dropped_weight += f64::from(weight * through);
                return self.cover(state, 1.0);
            }
            let there = |hit: &Hit| alpha_at(view, hit) > 0.0;
            next = self.context.view.bvh.closest_hit(ray, Some(hit.order()), there, &mut self.counters);
        }
        self.statistics.pass_through_limit_reached += 1;
        self.cover(state, 1.0);
    }

    /// What is left of a ray leaves the scene.
    fn escape(&mut self, (ray, state): (&Ray, &RayState), through: f32, part: Option<LightPass>) {
        if state.kind == RayKind::Camera && !self.context.settings.show_background {
            return self.cover(state, 1.0 - through);
        }
        let weight = state.weight * state.media.transmittance(f32::INFINITY) * through;
        let environment = self.context.view.environment;
        let turns = state.differential.direction;
        let radiance = match state.kind {
            RayKind::Camera => environment.background_over(ray.direction, turns),
            RayKind::Reflection | RayKind::Refraction => environment.radiance_over(ray.direction, turns),
        };
        self.add(state.sample, part.unwrap_or(LightPass::Environment), weight * radiance);
        self.cover(state, 1.0);
    }

    fn cover(&mut self, state: &RayState, coverage: f32) {
        if state.kind == RayKind::Camera {
            self.values[state.sample as usize].coverage = coverage;
        }
    }
}
