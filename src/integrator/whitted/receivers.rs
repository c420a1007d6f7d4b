//! Receivers: points of shadow catchers and the ground.
//!
//! Their direct light must be known before the ray goes on beyond them. So the shadow rays of the first receivers of all rays of a wavefront are
//! traced together before any ray is followed. What lies behind transparent surfaces and other receivers is found as it is reached.

use std::time::Instant;

use glam::Vec3;

use super::tracer::{Tracer, seconds_since};
use super::wavefront::{RaySlot, Wavefront};
use crate::bvh::Hit;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::random::Purpose;
use crate::integrator::shadow::ShadowBatch;
use crate::integrator::{EnvSamples, MediaStack, RayState, Seed};
use crate::interaction::catches_shadows;

/// Shadow rays after which queued receivers are traced: enough for full packets, and little memory.
const RAYS_TOGETHER: usize = 4096;

/// A point that receives light.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Receiver {
    pub(in crate::integrator) position: Vec3,
    /// Unit normal on the lit side.
    pub(in crate::integrator) normal: Vec3,
    pub(in crate::integrator) seed: Seed,
}

/// Luminance of the direct light on a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ReceivedLight {
    pub(super) unoccluded: f32,
    pub(super) arriving: f32,
}

/// The shadow rays of receivers. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct ReceiverShadows {
    /// For each light, then for the environment.
    batches: Vec<ShadowBatch>,
    rays: Vec<ReceiverRay>,
    /// The end of each receiver's rays.
    ends: Vec<usize>,
}

/// A shadow ray, and the irradiance that it decides about.
#[derive(Clone, Copy, Debug)]
struct ReceiverRay {
    batch: usize,
    /// Index in its batch.
    index: u32,
    irradiance: Vec3,
}

impl ReceiverShadows {
    fn clear(&mut self) {
        self.batches.iter_mut().for_each(ShadowBatch::clear);
        self.rays.clear();
        self.ends.clear();
    }

    fn push(&mut self, batch: usize, ray: Ray, irradiance: Vec3) {
        if batch >= self.batches.len() {
            self.batches.resize_with(batch + 1, ShadowBatch::default);
        }
        let index = self.batches[batch].push(ray, MediaStack::default());
        self.rays.push(ReceiverRay { batch, index, irradiance });
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
            let (ray, state) = wavefront.ray(slot);
            // The sampled rays of paths pass receivers.
            let is_received = wavefront.last_scatter(slot).is_none()
                && self.add_first_receiver(&mut shadows, (ray, state), first(self, slot, state));
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
        (ray, state): (&Ray, &RayState),
        first: Option<Hit>,
    ) -> bool {
        let ground = self.context.settings.ground.and_then(|ground| Some((ground, ground.hit(ray)?)));
        if let Some((ground, t)) = ground
            && first.is_none_or(|hit| t < hit.t)
        {
            let position = ray.at(t);
            let receiver = Receiver { position, normal: ground.up, seed: state.seed };
            self.add_receiver(shadows, &receiver, |_| position);
            return true;
        }
        let Some(hit) = first.filter(|hit| catches_shadows(self.context.view, hit)) else { return false };
        let (receiver, point) = self.catcher_receiver(ray, state, &hit);
        self.add_receiver(shadows, &receiver, |span| point.shadow_end_outside(span));
        true
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
        for (index, light) in context.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(receiver.position) else { continue };
            let cosine = incidence.wi.dot(receiver.normal);
            if cosine > 0.0 {
                let ray = light.shadow_ray(shadow_end(incidence.span), receiver.seed, index);
                shadows.push(index, ray, incidence.irradiance * cosine);
            }
        }
        let (rays, share) = match context.settings.env_samples {
            EnvSamples::Fixed(rays) if context.environment_directions.is_some() => (rays, 1.0 / rays as f32),
            _ => (1, context.occluded_share),
        };
        for number in 0..rays {
            if let Some(wi) = self.light_direction(receiver, number) {
                let irradiance = context.view.environment.irradiance(receiver.normal) * share;
                shadows.push(context.lights.len(), Ray::new(shadow_end(Vec3::ZERO), wi), irradiance);
            }
        }
        shadows.ends.push(shadows.rays.len());
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
        let first = receiver.checked_sub(1).map_or(0, |before| shadows.ends[before]);
        let mut light = ReceivedLight::default();
        for &ReceiverRay { batch, index, irradiance } in &shadows.rays[first..shadows.ends[receiver]] {
            let shadow = shadows.batches[batch].transmittance(self.context, index, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            light.unoccluded += luminance(irradiance);
            light.arriving += luminance(irradiance * shadow.transmittance);
        }
        light
    }

    /// A direction from which light of the environment reaches a receiver, for the shadow ray of this number.
    fn light_direction(&self, receiver: &Receiver, number: u32) -> Option<Vec3> {
        let Some(directions) = &self.context.environment_directions else {
            return self.environment_direction(receiver);
        };
        let purpose =
            |dimension: u32| Purpose::Light(self.context.lights.len() as u32 + 2 * number + dimension);
        let u_choice = receiver.seed.point(purpose(1)).x;
        directions.diffuse(receiver.normal, receiver.seed.point(purpose(0)), u_choice)
    }
}
