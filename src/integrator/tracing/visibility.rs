//! Surfaces that the rays of a wavefront see, also beyond transparent ones, and rays that leave the scene.

use std::time::Instant;

use super::ground::GroundHit;
use super::receiver_shadows::ReceivedLight;
use super::tracer::{Tracer, seconds_since};
use crate::bvh::{Hit, TriangleFlags};
use crate::integrator::least_weights::MIN_WEIGHT;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::wavefront::{FollowedRay, RaySlot, Wavefront};
use crate::integrator::{Integrator, LightPass, RayKind, RayState, TRANSPARENCY_LIMIT};
use crate::interaction::{alpha_at, catches_shadows};

impl Tracer<'_, '_> {
    /// Finds all surfaces that a wavefront of child rays sees, in the order of its rays and along each ray.
    pub(super) fn find_surface_hits(&mut self, wavefront: &mut Wavefront) {
        // Closest hits, all rays of one signature at once
        let view = self.context.view;
        let start = Instant::now();
        wavefront.find_hits(view.bvh, |hit| alpha_at(view, hit) > 0.0, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);

        for &slot in wavefront.in_order() {
            match wavefront.ray(slot).1.kind {
                RayKind::Camera => {}
                RayKind::Reflection | RayKind::GroundReflection => self.statistics.reflection_rays += 1,
                RayKind::Refraction => self.statistics.refraction_rays += 1,
            }
        }

        // Transparent surfaces and misses, ray by ray
        self.follow_all(wavefront, |_, slot, state| {
            state.touching.as_deref().map(|touching| touching.hit).or_else(|| wavefront.hit(slot))
        });
    }

    /// Follows the rays of a wavefront in their order. `first` returns the first hit of a ray.
    pub(super) fn follow_all(
        &mut self,
        wavefront: &Wavefront,
        first: impl Fn(&Self, RaySlot, &RayState) -> Option<Hit>,
    ) {
        self.find_first_receivers(wavefront, &first);
        self.find_escaped_radiances(wavefront, &first);
        for (number, &slot) in wavefront.in_order().iter().enumerate() {
            let followed = wavefront.followed(slot);
            if let Some(radiance) = self.escaped_radiances.get(number).copied().flatten() {
                self.add_escaped(followed.state, radiance);
                continue;
            }
            let received = self.first_receivers.get(number).copied().flatten();
            let hit = first(self, slot, followed.state);
            self.follow(slot, followed, hit, received);
        }
    }

    /// Follows one ray from its first hit through transparent surfaces to an opaque one or out of the scene. `received` is the light on its first
    /// receiver, where no surface is in front of that.
    #[inline]
    pub(super) fn follow(
        &mut self,
        slot: RaySlot,
        followed: FollowedRay<'_>,
        first: Option<Hit>,
        received: Option<ReceivedLight>,
    ) {
        let state = followed.state;
        let view = self.context.view;
        let is_solid = |hit: &Hit| !view.frame.flags[hit.triangle as usize].has(TriangleFlags::FILTERED);
        match first {
            Some(hit) if self.context.settings.ground.is_none() && is_solid(&hit) => {
                let light_pass = state.light_pass;
                let surface_hit = SurfaceHit { slot, hit, share: 1.0, light_pass, replaced: 0 };
                self.aovs.add_coverage(view.frame, state, &surface_hit);
                self.surface_hits.push(surface_hit);
                self.set_coverage(state, 1.0);
            }
            _ => self.follow_through(slot, followed, first, received),
        }
    }

    /// [`Tracer::follow`] for any surfaces and with the ground.
    fn follow_through(
        &mut self,
        slot: RaySlot,
        followed: FollowedRay<'_>,
        first: Option<Hit>,
        mut received: Option<ReceivedLight>,
    ) {
        let FollowedRay { ray, state, last } = followed;
        let view = self.context.view;
        let weight = state.weight.max_element();
        let mut through = 1.0_f32;
        let mut light_pass = state.light_pass;
        let mut passes = 0;
        let mut receivers = 0;
        let mut next = first;
        // Shadow rays pass the ground and shadow catchers, and so do the sampled rays that are weighed against them.
        let mut ground_hit = if last.is_none() { self.ground_hit(slot, ray, state) } else { None };
        for _ in 0..TRANSPARENCY_LIMIT {
            let in_front = |ground: &mut GroundHit<'_>| next.is_none_or(|hit| ground.t < hit.t);
            if let Some(ground) = ground_hit.take_if(in_front) {
                // What is received belongs to the first receiver alone.
                through *=
                    1.0 - self.ground_alpha(&ground, received.take(), receivers, (through, light_pass));
                receivers += 1;
                if self.ends(state, weight * through) {
                    return;
                }
            }
            let Some(hit) = next else {
                return self.escape(followed, through, light_pass);
            };
            let coverage = alpha_at(view, &hit);
            let alpha = if catches_shadows(view, &hit) {
                let occluders = self.context.occluders;
                ground_hit =
                    ground_hit.and_then(|ground| ground.behind_catcher((hit.t, coverage), occluders));
                let number = receivers;
                receivers += 1;
                let mut caught = || self.caught_shadow(followed, &hit, received.take(), number);
                let is_caught = last.is_none() && state.kind.sees_catchers();
                if is_caught { coverage * caught() } else { 0.0 }
            } else {
                let alpha = self.covered_share(state, coverage, &mut passes);
                let surface_hit = SurfaceHit { slot, hit, share: through * alpha, light_pass, replaced: 0 };
                if surface_hit.share > 0.0 {
                    self.aovs.add_coverage(view.frame, state, &surface_hit);
                    self.surface_hits.push(surface_hit);
                }
                light_pass = light_pass.or(Some(LightPass::Transparency));
                if let Some(ground) = &mut ground_hit {
                    ground.through *= 1.0 - alpha;
                }
                alpha
            };
            through *= 1.0 - alpha;
            let mirror_share = ground_hit.as_ref().map_or(0.0, GroundHit::mirror_share);
            if self.ends(state, weight * through.max(mirror_share)) {
                return;
            }
            let visible = |hit: &Hit| alpha_at(view, hit) > 0.0;
            next = view.bvh.closest_hit(ray, Some(hit.order()), visible, &mut self.counters);
        }
        self.statistics.transparency_limit_reached += 1;
        self.set_coverage(state, 1.0);
    }

    /// Ends a ray of which too little is left.
    fn ends(&mut self, state: &RayState, left: f32) -> bool {
        // Beyond the first surface of a path, Russian roulette alone decides.
        let is_path = self.context.settings.integrator == Integrator::Path && state.depth > 0;
        let ends = if is_path { left <= 0.0 } else { left < MIN_WEIGHT };
        if ends {
            self.statistics.dropped_weight += f64::from(left);
            self.set_coverage(state, 1.0);
        }
        ends
    }

    /// Adds the environment to a ray that leaves the scene with the share `through` of its weight.
    fn escape(
        &mut self,
        FollowedRay { ray, state, last }: FollowedRay<'_>,
        through: f32,
        light_pass: Option<LightPass>,
    ) {
        let sees_environment = match state.kind {
            RayKind::Camera => self.context.settings.show_background,
            RayKind::Reflection | RayKind::Refraction => true,
            RayKind::GroundReflection => false,
        };
        if !sees_environment {
            return self.set_coverage(state, 1.0 - through);
        }
        let weight = state.weight * state.media.transmittance(f32::INFINITY) * through;
        let environment = self.context.view.environment;
        let differential = state.differential.direction;
        let is_path = self.context.settings.integrator == Integrator::Path;
        let radiance = match state.kind {
            RayKind::Camera => environment.background_over(ray.direction, differential),
            _ if !is_path => self.reflected_environment(ray, state),
            RayKind::Reflection | RayKind::Refraction | RayKind::GroundReflection => {
                environment.radiance_over(ray.direction, differential)
            }
        };
        match self.context.settings.integrator {
            Integrator::Whitted => {
                self.add(state.sample, light_pass.unwrap_or(LightPass::Environment), weight * radiance);
            }
            Integrator::Path => {
                let (share, light_pass) = self.path_environment(ray.direction, light_pass, last);
                self.add_to_path(state, last, light_pass, weight * radiance * share);
            }
        }
        self.set_coverage(state, 1.0);
    }

    fn set_coverage(&mut self, state: &RayState, coverage: f32) {
        if state.kind == RayKind::Camera {
            self.values[state.sample as usize].coverage = coverage;
        }
    }
}
