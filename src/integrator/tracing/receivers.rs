//! Receivers: points of shadow catchers and the ground.
//!
//! Their direct light must be known before the ray goes on beyond them. So the shadow rays of the first receivers of all rays of a wavefront are
//! traced together before any ray is followed. What lies behind transparent surfaces and other receivers is found as it is reached.

use std::time::Instant;

use glam::{Vec2, Vec3};

use super::receiver_shadows::{QueuedReceiver, ReceivedLight, ReceiverRay, ReceiverShadows};
use super::tracer::{Tracer, seconds_since};
use crate::bvh::Hit;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::environment_directions::GOLDEN_SHARE;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::random::{Purpose, r2_moved};
use crate::integrator::wavefront::{FollowedRay, RaySlot, Wavefront};
use crate::integrator::zsobol::SampleSequence;
use crate::integrator::{EnvSamples, Integrator, MediaStack, RayState, Seed};
use crate::interaction::catches_shadows;

/// Shadow rays after which queued receivers are traced: enough for full packets, and little memory.
const RAYS_TOGETHER: usize = 4096;

/// Shadow rays to the environment from a receiver that a camera sees, unless their number is set. Most of them miss everything and are cheap;
/// each that does not is a speck on an even surface.
const RAYS_OF_ALL_LIGHT: u32 = 4;
/// The same where they go towards the occluders alone.
const RAYS_TO_OCCLUDERS: u32 = 3;

/// Share of the light about which a single ray may decide at most, to be no worse than that many.
const MOST_OF_ONE_RAY: f32 = 0.5;

/// Share of the light for which a ray is traced at least. Where less is in question, rays are traced for some samples, and decide about this much there:
/// that takes a sixth of the time of a character on the ground away, and adds 0.3 % to the noise of its shadow.
const LEAST_OF_ONE_RAY: f32 = 0.125;

/// First dimension of the sample points of receivers, beyond those of surfaces and paths.
const FIRST_DIMENSION: u32 = 1 << 31;
/// Dimensions from one receiver along a ray to the next, of which it uses two.
const DIMENSIONS: u32 = 16;

/// A point that receives light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    pub(super) position: Vec3,
    /// Unit normal on the lit side.
    pub(super) normal: Vec3,
    pub(super) seed: Seed,
    /// The sample points of the pixel, and the first dimension of this receiver, on camera rays.
    pub(super) points: Option<(SampleSequence, u32)>,
}

impl Receiver {
    /// The point in the unit square of this number, for directions to the environment of a scene with so many lights.
    fn environment_point(&self, lights: usize, number: u32) -> Vec2 {
        match self.points {
            Some((sequence, first_dimension)) => sequence.point(first_dimension + number),
            None => self.seed.point(Purpose::Light(lights as u32 + number)),
        }
    }
}

impl Tracer<'_, '_> {
    /// Finds the light on the first receiver of each ray of a wavefront that no surface hides. `first` returns the first hit of a ray.
    pub(super) fn find_first_receivers(
        &mut self,
        wavefront: &Wavefront,
        first: impl Fn(&Self, RaySlot, &RayState) -> Option<Hit>,
    ) {
        self.first_receivers.clear();
        if !self.context.has_receivers {
            return;
        }
        let mut shadows = std::mem::take(&mut self.receiver_shadows);
        let mut lights = std::mem::take(&mut self.first_receivers);
        shadows.clear();
        let mut traced = 0;
        for &slot in wavefront.in_order() {
            let followed = wavefront.followed(slot);
            // The sampled rays of paths pass receivers.
            let is_received = followed.last.is_none()
                && self.add_first_receiver(&mut shadows, followed, first(self, slot, followed.state));
            lights.push(is_received.then(ReceivedLight::default));
            if shadows.rays.len() >= RAYS_TOGETHER {
                self.receive(&mut shadows, &mut lights[traced..]);
                traced = lights.len();
            }
        }
        self.receive(&mut shadows, &mut lights[traced..]);
        (self.receiver_shadows, self.first_receivers) = (shadows, lights);
    }

    /// Traces the queued rays, sets the lights of their receivers and clears the queue.
    fn receive(&mut self, shadows: &mut ReceiverShadows, lights: &mut [Option<ReceivedLight>]) {
        self.trace_receivers(shadows);
        for (receiver, light) in lights.iter_mut().flatten().enumerate() {
            *light = self.received_light(shadows, receiver);
        }
        shadows.clear();
    }

    /// Adds the receiver that a ray reaches before all surfaces; `false` if there is none.
    fn add_first_receiver(
        &self,
        shadows: &mut ReceiverShadows,
        followed: FollowedRay<'_>,
        first: Option<Hit>,
    ) -> bool {
        let FollowedRay { ray, state, .. } = followed;
        let ground = self.context.settings.ground.and_then(|ground| Some((ground, ground.hit(ray)?)));
        if let Some((ground, t)) = ground
            && first.is_none_or(|hit| t < hit.t)
        {
            let position = ray.at(t);
            let points = self.receiver_points(state, 0);
            let receiver = Receiver { position, normal: ground.up, seed: state.seed, points };
            self.add_receiver(shadows, &receiver, |_| position);
            return true;
        }
        let is_catcher = |hit: &Hit| state.kind.sees_catchers() && catches_shadows(self.context.view, hit);
        let Some(hit) = first.filter(is_catcher) else { return false };
        let (receiver, point) = self.catcher_receiver(followed, &hit, 0);
        self.add_receiver(shadows, &receiver, |span| point.shadow_end_outside(span));
        true
    }

    /// The sample points of a camera ray's receiver with this number along the ray. Several deeper rays may belong to one
    /// sample, and have none.
    pub(super) fn receiver_points(&self, state: &RayState, number: u32) -> Option<(SampleSequence, u32)> {
        let has_points = state.depth == 0 && self.context.sample_points.is_some();
        has_points.then(|| (self.sequences[state.sample as usize], FIRST_DIMENSION + number * DIMENSIONS))
    }

    /// The direct light on one receiver. `shadow_end` returns the end of a shadow ray by its span.
    pub(super) fn direct_light_on(
        &mut self,
        receiver: &Receiver,
        shadow_end: impl Fn(Vec3) -> Vec3,
    ) -> ReceivedLight {
        let mut shadows = std::mem::take(&mut self.receiver_shadows);
        shadows.clear();
        self.add_receiver(&mut shadows, receiver, shadow_end);
        self.trace_receivers(&mut shadows);
        let light = self.received_light(&shadows, 0);
        self.receiver_shadows = shadows;
        light
    }

    fn add_receiver(
        &self,
        shadows: &mut ReceiverShadows,
        receiver: &Receiver,
        shadow_end: impl Fn(Vec3) -> Vec3,
    ) {
        let context = self.context;
        let mut certain = 0.0;
        for (index, light) in context.receiver_lights().enumerate() {
            let Some(incidence) = light.incidence(receiver.position) else { continue };
            let cosine = incidence.wi.dot(receiver.normal);
            if cosine > 0.0 {
                let ray = light.shadow_ray(shadow_end(incidence.span), receiver.seed, index);
                let irradiance = incidence.irradiance * cosine;
                if context.occluders.is_some_and(|occluders| occluders.is_missed_by(&ray)) {
                    certain += luminance(irradiance);
                } else {
                    // No volumes are around a receiver.
                    let is_distant = incidence.span == Vec3::ZERO;
                    let media = SurfaceMedia::of_lamp(is_distant, MediaStack::default());
                    shadows.push(index, (ray, media), irradiance);
                }
            }
        }
        certain += self.add_environment(shadows, receiver, &shadow_end);
        shadows.receivers.push(QueuedReceiver { end: shadows.rays.len(), certain });
    }

    /// Adds shadow rays to the environment. Returns the luminance of its light that arrives without any.
    fn add_environment(
        &self,
        shadows: &mut ReceiverShadows,
        receiver: &Receiver,
        shadow_end: impl Fn(Vec3) -> Vec3,
    ) -> f32 {
        let context = self.context;
        let Some(directions) = &context.environment_directions else { return 0.0 };
        let irradiance = shadows.irradiance((context.view.environment, directions), receiver.normal);
        let all = irradiance.exact * context.occluded_share;
        if luminance(all) <= 0.0 {
            return 0.0;
        }
        let origin = shadow_end(Vec3::ZERO);
        let lights = context.receiver_lights().count();
        // No ray may decide about more than all light: shadows would be too light where they are limited to it.
        let range = context.occluders.and_then(|occluders| occluders.range_from(origin, receiver.normal));
        let light = range.map(|range| directions.in_range(range, irradiance.of_grid));
        let light = light.filter(|light| light.max_share() <= 1.0);
        let max_share = light.map(|light| light.max_share());
        let (rays, probability) = self.environment_rays(receiver, max_share);
        // The rays of a sample share one sample point, which each moves on.
        let point = |number| receiver.environment_point(lights, number);
        let (u, choice) = (point(0), point(1).x);
        let Some(light) = light else {
            for number in 0..rays {
                let random = (choice + number as f32 * GOLDEN_SHARE).fract();
                if let Some(wi) = directions.grid.diffuse(receiver.normal, r2_moved(u, number), random) {
                    let ray = (Ray::new(origin, wi), SurfaceMedia::default());
                    shadows.push(lights, ray, all / rays as f32);
                }
            }
            return 0.0;
        };
        // All light from beyond the range arrives.
        let mut certain = luminance(all);
        if choice >= probability || max_share <= Some(0.0) {
            return certain;
        }
        for number in 0..rays {
            let (wi, share) = light.sample(r2_moved(u, number));
            if share > 0.0 {
                let decided = all * (share / (rays as f32 * probability));
                certain -= luminance(decided);
                shadows.push(lights, (Ray::new(origin, wi), SurfaceMedia::default()), decided);
            }
        }
        certain
    }

    /// How many shadow rays go to the environment, and the probability that they are traced. `max_share` is the largest share of its
    /// light that one ray may decide about where rays go towards the occluders alone.
    fn environment_rays(&self, receiver: &Receiver, max_share: Option<f32>) -> (u32, f32) {
        let settings = &self.context.settings;
        let rays = match settings.env_samples {
            _ if receiver.points.is_none() => 1,
            // Paths take many samples. Their rays are as sparse as those of `Whitted` below.
            _ if settings.integrator == Integrator::Path => 1,
            EnvSamples::Fixed(rays) => rays,
            EnvSamples::Auto => match max_share {
                Some(share) if share <= MOST_OF_ONE_RAY => 1,
                Some(_) => RAYS_TO_OCCLUDERS,
                None => RAYS_OF_ALL_LIGHT,
            },
        };
        let probability = match (settings.env_samples, max_share) {
            (EnvSamples::Auto, Some(share)) => (share / LEAST_OF_ONE_RAY).min(1.0),
            _ => 1.0,
        };
        (rays, probability)
    }

    fn trace_receivers(&mut self, shadows: &mut ReceiverShadows) {
        let start = Instant::now();
        for batch in shadows.batches.iter_mut().filter(|batch| !batch.is_empty()) {
            batch.trace(self.context, &mut self.counters);
        }
        self.statistics.query_seconds += seconds_since(start);
        self.statistics.shadow_rays += shadows.rays.len() as u64;
    }

    /// The light on the receiver with this index, after its rays were traced.
    fn received_light(&mut self, shadows: &ReceiverShadows, receiver: usize) -> ReceivedLight {
        let first = receiver.checked_sub(1).map_or(0, |before| shadows.receivers[before].end);
        let QueuedReceiver { end, certain } = shadows.receivers[receiver];
        let mut light = ReceivedLight { unoccluded: certain, arriving: certain };
        for &ReceiverRay { batch, index, irradiance } in &shadows.rays[first..end] {
            let shadow = shadows.batches[batch].transmittance(self.context, index, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            light.unoccluded += luminance(irradiance);
            light.arriving += luminance(irradiance * shadow.transmittance);
        }
        light
    }
}
