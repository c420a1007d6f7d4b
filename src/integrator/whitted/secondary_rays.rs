//! Child rays of a shaded surface: mirror rays and refraction rays.

use glam::Vec3;

use super::reflected_lobe::ReflectedLobe;
use super::shading::{Arrival, Shading};
use crate::geometry::Ray;
use crate::integrator::least_weights::MIN_WEIGHT;
use crate::integrator::light_set::LightSet;
use crate::integrator::local_frame::mirror_direction;
use crate::integrator::prefiltered_lobe::PrefilteredLobe;
use crate::integrator::random::Purpose;
use crate::integrator::ray_state::Touching;
use crate::integrator::tracing::Tracer;
use crate::integrator::{ColorChannels, LightPass, MediaStack, RayKind, RayState, Seed};
use crate::interaction::RayDifferential;

/// A child ray.
#[derive(Clone, Copy)]
pub(super) struct ChildRay {
    pub(super) ray: Ray,
    /// Multiplies the radiance that the ray finds.
    pub(super) weight: Vec3,
    /// Of the lobe that the ray stands for; 0 for a direction that was sampled.
    pub(super) roughness: f32,
    /// See [`RayState::environment_lobe`].
    pub(super) environment_lobe: Option<PrefilteredLobe>,
    pub(super) kind: RayKind,
    pub(super) channels: ColorChannels,
    pub(super) seed: Seed,
    /// Whether the direction was sampled from a rough lobe.
    pub(super) is_sampled: bool,
}

/// Where a child ray goes on.
struct Beyond {
    /// See [`RayState::media`].
    media: MediaStack,
    /// See [`RayState::touching`].
    touching: Option<Box<Touching>>,
    /// See [`RayState::sees_peaks`].
    sees_peaks: bool,
    /// See [`RayState::shown_lamps`].
    shown_lamps: LightSet,
}

impl ChildRay {
    /// The one ray that stands for a lobe of this roughness.
    fn of_lobe(
        (ray, roughness): (Ray, f32),
        weight: Vec3,
        kind: RayKind,
        (channels, seed): (ColorChannels, Seed),
    ) -> Self {
        Self { ray, weight, roughness, environment_lobe: None, kind, channels, seed, is_sampled: false }
    }

    /// A ray along a sampled direction.
    pub(super) fn sampled(
        ray: Ray,
        weight: Vec3,
        kind: RayKind,
        (channels, seed): (ColorChannels, Seed),
    ) -> Self {
        Self { is_sampled: true, ..Self::of_lobe((ray, 0.0), weight, kind, (channels, seed)) }
    }
}

impl Tracer<'_, '_> {
    /// Sends mirror rays for the specular lobe and for the coat; a single one where both have the same direction and roughness.
    pub(super) fn reflect(&mut self, shading: &Shading<'_, '_>) {
        let coat_is_scattered = self.scatter_coat(shading);
        // Facets send their reflected rays with the refracted ones; what they leave of the lobe is wide enough to be looked up.
        let is_scattered = shading.facet_share > 0.0 || self.scatter_reflection(shading);
        let followed = if is_scattered { 0.0 } else { self.follow_rough_reflection(shading) };
        let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
        let (mut roughness, mut weight) = (shading.bsdf.widest_roughness(), Vec3::ZERO);
        if !is_scattered {
            let mirrored_share = shading.traced_share * (1.0 - followed);
            weight = shading.weight_below * shading.albedos.specular * mirrored_share;
        }
        if let Some(coat) = &shading.coat
            && !coat_is_scattered
        {
            let coat_weight = shading.weight * (coat.albedo * coat.traced_share);
            let is_same = coat.mirrored == mirrored && coat.roughness == roughness;
            if is_same || weight == Vec3::ZERO && coat.mirrored == mirrored {
                (roughness, weight) = (coat.roughness, weight + coat_weight);
            } else {
                self.send_mirror_ray(&shading.arrival(), (coat.mirrored, coat.roughness), coat_weight);
            }
        }
        self.send_mirror_ray(&shading.arrival(), (mirrored, roughness), weight);
    }

    /// Follows the specular lobe by a sampled ray where a mirror ray does not do. Returns the share that it follows.
    fn follow_rough_reflection(&mut self, shading: &Shading<'_, '_>) -> f32 {
        let Shading { bsdf, terms, world_from_local, wo, .. } = *shading;
        let albedo = shading.albedos.specular;
        let share = self.followed_reflection(albedo, shading.traced_share);
        if share > 0.0 {
            let lobe = ReflectedLobe { bsdf, terms, world_from_local, wo, albedo };
            self.follow_reflection(&shading.arrival(), &lobe, shading.weight_below * share);
        }
        share
    }

    /// Sends the mirror ray of a lobe, unless it is too deep or too faint.
    pub(super) fn send_mirror_ray(
        &mut self,
        arrival: &Arrival<'_, '_>,
        (direction, roughness): (Vec3, f32),
        weight: Vec3,
    ) {
        let state = arrival.state;
        if self.may_send(state, weight) {
            let ray = Ray::new(arrival.point.origin_outside(), direction);
            let seed = state.seed.child(Purpose::Reflection, 0, 1);
            let kind = RayKind::Reflection;
            self.send_reflected(
                arrival,
                ChildRay::of_lobe((ray, roughness), weight, kind, (state.channels, seed)),
            );
        }
    }

    /// Sends refraction rays and sampled rays for each transmitting lobe.
    pub(super) fn refract(&mut self, shading: &Shading<'_, '_>) {
        if shading.facet_share > 0.0 {
            self.follow_facets(shading);
            if self.context.settings.glossy_samples > 0 {
                return;
            }
        }
        if shading.albedos.transmission == Vec3::ZERO || self.scatter_transmission(shading) {
            return;
        }
        if shading.follows_transmission {
            return self.sample_frosted_glass(shading);
        }
        for (channels, bsdf) in shading.transmission_lobes() {
            let transmitted = shading.albedos.transmission * shading.traced_share_transmitted;
            let weight = shading.weight_below * transmitted * channels.mask();
            if weight == Vec3::ZERO {
                continue;
            }
            let Some(direction) = bsdf.refract(shading.wo) else { continue };
            if !self.may_send(shading.state, weight) {
                continue;
            }
            // Thin walls and equal media leave the direction exactly as it was.
            let is_unbent = direction == -shading.wo;
            let direction = if is_unbent {
                -shading.point.wo
            } else {
                (shading.world_from_local * direction).normalize()
            };
            let ray = Ray::new(shading.point.origin_inside(), direction);
            let seed = shading.state.seed.child(Purpose::Refraction, 0, 1);
            let roughness = bsdf.transmission_roughness();
            let kind = RayKind::Refraction;
            self.send(shading, ChildRay::of_lobe((ray, roughness), weight, kind, (channels, seed)));
        }
    }

    /// Whether a child ray of `parent` is neither too deep nor too faint. The weight of a refused child is counted as dropped.
    pub(super) fn may_send(&mut self, parent: &RayState, weight: Vec3) -> bool {
        let largest = weight.max_element();
        if largest == 0.0 {
            return false;
        }
        // Each of several glossy samples has a small weight.
        let min = MIN_WEIGHT / self.context.settings.glossy_samples.max(1) as f32;
        if parent.depth >= self.context.settings.max_depth || largest < min {
            self.statistics.dropped_weight += f64::from(largest);
            return false;
        }
        true
    }

    /// Adds a child ray to the next wavefront.
    pub(super) fn send(&mut self, shading: &Shading<'_, '_>, child: ChildRay) {
        let arrival = shading.arrival();
        if child.kind != RayKind::Refraction {
            return self.send_reflected(&arrival, child);
        }
        let side = &shading.transmission_side;
        let arriving = &shading.state.differential;
        let differential = if shading.material.thin {
            shading.point.passed_differential(arriving)
        } else {
            let (frame, direction) = (self.context.view.frame, child.ray.direction);
            shading.point.refracted_differential(frame, arriving, direction, shading.relative_ior())
        };
        let beyond = Beyond {
            media: side.media.clone(),
            touching: side.touching.clone(),
            sees_peaks: self.transmits_peaks(shading),
            shown_lamps: self.shown_beyond(shading),
        };
        self.push_child(&arrival, child, differential, beyond);
    }

    /// Adds a reflected ray to the next wavefront.
    #[inline(always)]
    pub(super) fn send_reflected(&mut self, arrival: &Arrival<'_, '_>, child: ChildRay) {
        let state = arrival.state;
        let differential = arrival.point.reflected_differential(self.context.view.frame, &state.differential);
        let shown_lamps = self.shown_before(arrival, &child);
        let beyond = Beyond { media: state.media.clone(), touching: None, sees_peaks: false, shown_lamps };
        self.push_child(arrival, child, differential, beyond);
    }

    #[inline(always)]
    fn push_child(
        &mut self,
        arrival: &Arrival<'_, '_>,
        child: ChildRay,
        differential: RayDifferential,
        beyond: Beyond,
    ) {
        let Beyond { media, touching, sees_peaks, shown_lamps } = beyond;
        let ChildRay { ray, weight, roughness, environment_lobe, kind, channels, seed, is_sampled } = child;
        let light_pass = arrival.light_pass.or(match kind {
            RayKind::Camera => None,
            RayKind::Reflection | RayKind::GroundReflection => Some(LightPass::Reflection),
            RayKind::Refraction => Some(LightPass::Refraction),
        });
        let depth = arrival.state.depth + 1;
        let state = RayState {
            differential,
            media,
            touching,
            weight,
            kind,
            channels,
            light_pass,
            sees_peaks,
            is_sampled: is_sampled || arrival.state.is_sampled,
            shown_lamps,
            blur: arrival.state.blur + (roughness * roughness) * (roughness * roughness),
            environment_lobe,
            depth,
            seed,
            ..*arrival.state
        };
        self.children.push(arrival.signature.then(kind), ray, state);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::bvh::TraversalCounters;
    use crate::integrator::CameraSamples;
    use crate::integrator::tracing::tests::with_context;
    use crate::scene::{BuiltInLight, Environment};

    #[test]
    fn rays_through_thin_frosted_walls_are_as_wide_as_those_that_arrive() {
        let studio = Environment::BuiltIn(BuiltInLight::Studio);
        with_context("environment/frosted_glass", &studio, |context, camera| {
            let pixels: Vec<(u32, u32)> = (0..16 * 12).map(|pixel| (pixel % 16, pixel / 16)).collect();
            let offsets = [Vec2::splat(0.5)];
            let samples = CameraSamples { pixels: &pixels, offsets: &offsets, first_index: 0, may_hit: true };
            let mut tracer = Tracer::new(context);
            let wavefront = tracer.trace_camera(camera, &samples);
            let arriving: Vec<_> = tracer.surface_hits.iter().map(|hit| wavefront.ray(hit.slot)).collect();
            tracer.shade_surface_hits(&wavefront);
            tracer.children.find_hits(context.view.bvh, |_| true, &mut TraversalCounters::default());
            let mut scattered = 0;
            for &slot in tracer.children.in_order() {
                let (ray, state) = tracer.children.ray(slot);
                // The ball's rays are within its volume.
                if state.environment_lobe.is_none() || !state.media.is_empty() {
                    continue;
                }
                let of_sample = |(_, parent): &&(&Ray, &RayState)| parent.sample == state.sample;
                let (arrived, parent) = arriving.iter().find(of_sample).unwrap();
                assert_eq!(state.differential.direction, parent.differential.direction);
                scattered += u32::from(ray.direction.dot(arrived.direction) < 0.999);
            }
            assert!(scattered > 5, "{scattered}");
        });
    }
}
