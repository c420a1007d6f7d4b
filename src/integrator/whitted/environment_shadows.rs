//! Shadows of the environment: what surfaces look up is multiplied by the light that sampled shadow rays let through.

use glam::{Vec2, Vec3};

use super::environment_lookup::{EnvironmentLookup, MAX_LOOKUPS, join_faint};
use super::occluder_buffers::OccluderTask;
use super::sampled_lookups::traced_point;
use super::shading::{Arrival, Shading};
use crate::geometry::Ray;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::tracing::{ShadowRay, Tracer};
use crate::integrator::wavefront::{BOUNCES, RaySignature};
use crate::integrator::zsobol::SampleSequence;
use crate::integrator::{EnvSamples, GlassShadows, LightPass, MediaStack, RayState};

/// Numbers of lookups: signatures are below 64.
const MAX_NUMBERS: usize = 64 * MAX_LOOKUPS;

/// A lookup of a surface and how its shadow rays are queued.
struct QueuedLookup<'l> {
    lookup: &'l EnvironmentLookup,
    light_pass: LightPass,
    /// Number of its sample points, below [`MAX_NUMBERS`].
    number: usize,
    /// See [`JoinedLookups::directions`].
    direction: Option<Vec3>,
    /// Whether what stops the rays is found and lit.
    traces_occluder: bool,
}

/// Lookups of a surface of which faint ones have joined brighter ones.
#[derive(Clone, Copy)]
pub(super) struct JoinedLookups<'l> {
    pub(super) lookups: &'l [EnvironmentLookup],
    /// Index of the brightest of those that have shadow rays.
    pub(super) brightest: Option<usize>,
    /// For each lookup the direction of its first shadow ray; `None` where it sends no ray.
    pub(super) directions: &'l [Option<Vec3>],
}

impl Tracer<'_, '_> {
    /// The most shadow rays of the lookups of one surface.
    pub(in crate::integrator) fn most_lookup_rays(&self) -> usize {
        match (&self.context.environment_directions, self.context.settings.env_samples) {
            (None, _) => 0,
            (Some(_), EnvSamples::Auto) => MAX_LOOKUPS,
            (Some(_), EnvSamples::Fixed(rays)) => MAX_LOOKUPS * rays as usize,
        }
    }

    /// Adds the looked-up light of a surface that is shaded on its own: at once, or behind shadow rays.
    pub(super) fn add_lookups(&mut self, shading: &Shading<'_, '_>, lookups: &mut [EnvironmentLookup]) {
        let context = self.context;
        if context.environment_directions.is_none() {
            let media = &shading.transmission_side.media;
            return self.add_unshadowed(&shading.arrival(), media, lookups);
        }
        let brightest = join_faint(lookups, context.mean_radiance, |lookup| self.has_rays(lookup));
        let arrival = &shading.arrival();
        let directions = self.first_directions((shading.index, arrival), lookups);
        let lookups = JoinedLookups { lookups, brightest, directions: &directions };
        let media = &shading.transmission_side.media;
        self.add_joined_lookups(arrival, media, &lookups, shading.material.base_color);
    }

    /// Adds the looked-up light of a surface of `color`. `beyond` holds the volumes on the other side.
    pub(super) fn add_joined_lookups(
        &mut self,
        arrival: &Arrival<'_, '_>,
        beyond: &MediaStack,
        joined: &JoinedLookups<'_>,
        color: Vec3,
    ) {
        let JoinedLookups { lookups, brightest, directions } = *joined;
        let context = self.context;
        if context.environment_directions.is_none() {
            return self.add_unshadowed(arrival, beyond, lookups);
        }
        let Arrival { signature, state, light_pass, .. } = *arrival;
        let light_pass = light_pass.unwrap_or(LightPass::Environment);
        // Occluders are found for one lookup of a surface that a camera sees.
        let traces_occluders = context.bounce_share > 0.0 && state.depth == 0;
        let with_occluder = brightest.filter(|_| traces_occluders);
        let mut index = 0;
        for (number, (lookup, &direction)) in lookups.iter().zip(directions).enumerate() {
            if !lookup.looks_up() {
                continue;
            }
            let media = if lookup.is_outside { &state.media } else { beyond };
            if self.has_rays(lookup) {
                let queued = QueuedLookup {
                    lookup,
                    light_pass,
                    number: number_of(signature, index),
                    direction,
                    traces_occluder: with_occluder == Some(number),
                };
                self.add_lookup(arrival, &queued, media, color);
            } else {
                let through = self.untraced_transmittance(arrival.point, lookup, media);
                self.add(state.sample, light_pass, lookup.radiance * through);
            }
            index += 1;
        }
    }

    /// Adds looked-up light without shadow rays.
    fn add_unshadowed(
        &mut self,
        arrival: &Arrival<'_, '_>,
        beyond: &MediaStack,
        lookups: &[EnvironmentLookup],
    ) {
        let Arrival { state, light_pass, point, .. } = *arrival;
        for lookup in lookups {
            let media = if lookup.is_outside { &state.media } else { beyond };
            let through = self.untraced_transmittance(point, lookup, media);
            self.add(state.sample, light_pass.unwrap_or(LightPass::Environment), lookup.radiance * through);
        }
    }

    /// Whether a lookup has shadow rays: the far side of glass that casts full shadows would hide everything.
    fn has_rays(&self, lookup: &EnvironmentLookup) -> bool {
        lookup.is_outside || self.context.settings.glass_shadows == GlassShadows::Straight
    }

    /// Adds one lookup behind shadow rays that start in `media`.
    fn add_lookup(
        &mut self,
        arrival: &Arrival<'_, '_>,
        queued: &QueuedLookup<'_>,
        media: &MediaStack,
        color: Vec3,
    ) {
        let Arrival { signature, state, point, .. } = *arrival;
        let QueuedLookup { lookup, light_pass, number, direction: first, traces_occluder } = *queued;
        let EnvironmentLookup { radiance, albedo, lobe, is_outside } = *lookup;
        let context = self.context;
        let Some(directions) = &context.environment_directions else { return };
        let share = first.map_or(0.0, |_| context.occluded_share / context.traced_samples);
        if share < 1.0 {
            let through = self.untraced_transmittance(point, lookup, media);
            self.add(state.sample, light_pass, radiance * (1.0 - share) * through);
        }
        let Some(first) = first else { return };
        // What hides the environment reflects its light; a ray that arrives adds what is more, or takes away what is less. What tints the ray
        // reflects nothing.
        let reflected = albedo * context.mean_radiance * surrounding_light(color);
        if reflected != Vec3::ZERO {
            self.add(state.sample, light_pass, reflected * share);
        }
        let limited = reflected.min(radiance);
        let radiance = radiance - reflected;
        let rays = match context.settings.env_samples {
            EnvSamples::Fixed(rays) if state.depth == 0 => rays,
            EnvSamples::Fixed(_) | EnvSamples::Auto => 1,
        };
        let for_hidden = if context.may_dim_light { reflected * (share / rays as f32) } else { Vec3::ZERO };
        if radiance == Vec3::ZERO && for_hidden == Vec3::ZERO && !traces_occluder {
            return;
        }
        let end = if is_outside {
            point.shadow_end_outside(Vec3::ZERO)
        } else {
            point.shadow_end_inside(Vec3::ZERO)
        };
        let share = share / rays as f32;
        for ray in 0..rays {
            let direction = if ray == 0 {
                first
            } else {
                let sequence = self.sequences[state.sample as usize];
                lobe.sample(directions, self.point_of_ray(&sequence, number, ray))
            };
            let task = self.shadows.push(ShadowRay {
                signature,
                light: context.lights.len(),
                ray: Ray::new(end, on_side(direction, point.geometric_normal, is_outside)),
                sample: state.sample,
                light_pass,
                contribution: radiance * share,
                for_hidden,
                environment_clamp: None,
                media: SurfaceMedia::AtStart(media.clone()),
            });
            if traces_occluder {
                self.whitted.occluders.queued.push(OccluderTask {
                    task,
                    lookup: (number + MAX_NUMBERS) as u32,
                    ray,
                    albedo: albedo * share,
                    reflected: reflected * share,
                    limited: limited * share,
                });
            }
        }
    }
}

impl Tracer<'_, '_> {
    /// The sample point of a ray that rough reflection sends where nothing is looked up.
    pub(super) fn point_of_reflection(&mut self, signature: RaySignature, state: &RayState) -> Vec2 {
        let sequence = self.sequences[state.sample as usize];
        let ray = state.depth.saturating_sub(u32::from(BOUNCES));
        self.point_of_ray(&sequence, signature.index() * MAX_LOOKUPS, ray).0
    }

    /// The sample point of a ray through frosted glass, by the number of its lobe, and a random number. The lookups of such glass have no more
    /// numbers than are left.
    pub(super) fn point_of_frosted_glass(&mut self, shading: &Shading<'_, '_>, lobe: usize) -> (Vec2, f32) {
        let Shading { signature, state, .. } = shading;
        let sequence = self.sequences[state.sample as usize];
        let number = signature.index() * MAX_LOOKUPS + MAX_LOOKUPS - 1 - lobe;
        // Bounces that the signature forgets would repeat each other's choices.
        self.point_of_ray(&sequence, number, state.depth.saturating_sub(u32::from(BOUNCES)))
    }

    /// The directions of the first shadow rays of the lookups of a surface, which was sampled with this lane of its block.
    fn first_directions(
        &mut self,
        (lane, arrival): (usize, &Arrival<'_, '_>),
        lookups: &[EnvironmentLookup],
    ) -> [Option<Vec3>; MAX_LOOKUPS] {
        let mut found = [None; MAX_LOOKUPS];
        let Some(directions) = &self.context.environment_directions else { return found };
        let looked_up = lookups.iter().zip(&mut found).filter(|(lookup, _)| lookup.looks_up());
        for (index, (lookup, found)) in looked_up.enumerate() {
            if !self.has_rays(lookup) {
                continue;
            }
            let is_sampled = index == 0 && lookup.is_outside && self.whitted.sampled_lookups.contains(lane);
            *found = if is_sampled {
                self.whitted.sampled_lookups.direction(lane, directions, &lookup.lobe)
            } else {
                let sequence = self.sequences[arrival.state.sample as usize];
                let (u, random) = self.point_of_ray(&sequence, number_of(arrival.signature, index), 0);
                let u = traced_point(u, self.context.traced_samples);
                (u.x < 1.0).then(|| lookup.lobe.sample(directions, (u, random)))
            };
        }
        found
    }

    /// The sample point of a ray of a lookup, and a random number.
    fn point_of_ray(&mut self, sequence: &SampleSequence, number: usize, ray: u32) -> (Vec2, f32) {
        let [keys, _] = self.whitted.lookup_keys.get(sequence.seed(), number, ray);
        sequence.point_and_random_by(&keys)
    }
}

/// Number of the sample points of a surface's lookup with this index.
pub(super) fn number_of(signature: RaySignature, index: usize) -> usize {
    signature.index() * MAX_LOOKUPS + index
}

/// A direction on one side of a surface; those of the other side are mirrored by it.
pub(super) fn on_side(direction: Vec3, normal: Vec3, is_outside: bool) -> Vec3 {
    let height = direction.dot(normal);
    if (height > 0.0) == is_outside { direction } else { direction - normal * (2.0 * height) }
}

/// Light that comes from what hides the environment, over the mean radiance of the environment: surfaces that hide it may face any way.
///
/// What hides it is taken to have the colour of the surface and its openness V (Jiménez et al., "Practical Real-Time Strategies for Accurate
/// Indirect Occlusion", 2016). With all bounces, V / (1 − c (1 − V)) of the light of a uniform environment arrives at a surface of colour c. This
/// is the straight line in V that equals it for V = 1 and V = 1/2, so that single shadow rays estimate it; deeper shadows of bright surfaces get
/// more light. Peaks do not count: whether they reach what hides the environment is known only where that is found, and their light would be too much where not.
fn surrounding_light(color: Vec3) -> Vec3 {
    let color = color.clamp(Vec3::ZERO, Vec3::ONE);
    color / (Vec3::splat(2.0) - color)
}
