//! What one surface sends back along a ray: its own light, lights, the environment, and the rays it sends on.

use glam::{Mat3, Vec3};

use super::coat::Coated;
use super::surface_hits::SurfaceHit;
use super::transmission_side::{TransmissionSide, ior_before, ior_behind};
use super::wavefront::{RaySignature, Wavefront};
use super::{LEAST_WEIGHT, Tracer};
use crate::bsdf::{Albedos, Bsdf};
use crate::geometry::{Ray, unit};
use crate::integrator::random::Purpose;
use crate::integrator::{ColorChannels, LightPass, MediaStack, RayKind, RayState, Seed};
use crate::interaction::{MaterialSample, SurfacePoint, surface_at};

/// Below this roughness a lobe is followed by rays only.
const TRACED_ROUGHNESS: f32 = 0.1;
/// Above this roughness a lobe only looks the environment up.
const PREFILTERED_ROUGHNESS: f32 = 0.4;

/// A surface with its lobes, seen by one ray.
pub(super) struct Shading<'p, 'a> {
    /// How the ray came about.
    pub(super) signature: RaySignature,
    pub(super) state: &'p RayState,
    /// See [`SurfaceHit::part`].
    pub(super) part: Option<LightPass>,
    pub(super) point: &'p SurfacePoint<'a>,
    pub(super) material: MaterialSample,
    pub(super) bsdf: Bsdf,
    /// Of the lobes, as seen by the ray.
    pub(super) albedos: Albedos,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    pub(super) wo: Vec3,
    /// What radiance that leaves towards the eye counts for.
    pub(super) weight: Vec3,
    /// The same for what leaves below the coat.
    pub(super) weight_below: Vec3,
    pub(super) coat: Option<Coated>,
    /// The lobes of single colours, where glass bends those differently.
    pub(super) dispersed: Option<[Bsdf; 3]>,
    /// What lies on the other side.
    behind: TransmissionSide,
    /// Index of refraction there by the one on this side.
    pub(super) relative_ior: f32,
    /// Share of what is reflected that rays follow; the environment lookup has the rest.
    pub(super) traced_share: f32,
    /// The same of what passes through.
    pub(super) traced_share_transmitted: f32,
}

/// A ray that a surface sends on.
#[derive(Clone, Copy)]
pub(super) struct Child {
    pub(super) ray: Ray,
    /// What the radiance that it finds counts for.
    pub(super) weight: Vec3,
    pub(super) kind: RayKind,
    pub(super) channels: ColorChannels,
    pub(super) seed: Seed,
}

impl Shading<'_, '_> {
    /// The lobes by which light goes through, each with the colours it is for.
    pub(super) fn transmission_lobes(&self) -> impl Iterator<Item = (ColorChannels, &Bsdf)> {
        let together = self.dispersed.is_none().then_some((self.state.channels, &self.bsdf));
        let apart =
            self.dispersed.iter().flat_map(|dispersed| ColorChannels::SINGLE.into_iter().zip(dispersed));
        together.into_iter().chain(apart)
    }
}

impl Tracer<'_, '_> {
    /// Shades everything that a generation sees, in order.
    pub(super) fn shade_surface_hits(&mut self, wavefront: &Wavefront) {
        let mut surface_hits = std::mem::take(&mut self.surface_hits);
        for surface_hit in surface_hits.drain(..) {
            self.shade(wavefront, &surface_hit);
        }
        self.surface_hits = surface_hits;
    }

    fn shade(&mut self, wavefront: &Wavefront, SurfaceHit { place, hit, share, part }: &SurfaceHit) {
        let view = self.context.view;
        let (ray, state) = wavefront.ray(*place);
        let (point, material) = surface_at(view, ray, hit, &state.differential);
        let weight = state.weight * state.media.transmittance(hit.t) * *share;
        if material.unlit {
            self.add(state.sample, part.unwrap_or(LightPass::Emission), weight * material.base_color);
            return;
        }
        let follows_rays = self.context.settings.glossy_samples > 0;
        let coat = material.clear_coat.map(|coat| Coated::new(&coat, &point, follows_rays));
        let weight_below = weight * coat.as_ref().map_or(1.0, |coat| coat.transmittance);
        self.add(state.sample, part.unwrap_or(LightPass::Emission), weight_below * material.emission);

        let behind = self.behind(state, &point, &material);
        let own_medium = self.context.interiors.medium(point.instance);
        let iors = |channels| {
            let before = ior_before(state, own_medium, point.facing, channels);
            (before, ior_behind(&material, &behind.media, channels))
        };
        let lobes_of = |channels| {
            let (before, behind) = iors(channels);
            Bsdf::new(&material, before, behind)
        };
        let (before, after) = iors(state.channels);
        let bsdf = lobes_of(state.channels);
        let disperses = state.media.disperses()
            || behind.media.disperses()
            || own_medium.is_some_and(|medium| medium.half_spread > 0.0);
        let parts = state.channels == ColorChannels::White && !material.thin && disperses;
        let dispersed = parts.then(|| ColorChannels::SINGLE.map(lobes_of));
        let world_from_local = match material.anisotropy {
            Some(anisotropy) => frame_along(point.shading_normal, anisotropy.direction),
            None => local_frame(point.shading_normal),
        };
        let wo = world_from_local.transpose() * point.wo;
        let sharpness_of = |roughness| if follows_rays { 1.0 } else { traced_share(roughness) };
        let shading = Shading {
            signature: place.signature,
            state,
            part: *part,
            point: &point,
            albedos: dispersed.as_ref().map_or_else(|| bsdf.albedos(wo), |dispersed| by_color(dispersed, wo)),
            material,
            bsdf,
            world_from_local,
            wo,
            weight,
            weight_below,
            coat,
            dispersed,
            behind,
            // An index of 0 bends nothing.
            relative_ior: if before > 0.0 && after > 0.0 { after / before } else { 1.0 },
            traced_share: sharpness_of(bsdf.widest_roughness()),
            traced_share_transmitted: sharpness_of(bsdf.widest_roughness_through()),
        };
        self.light(&shading);
        self.environment(&shading);
        self.mirror(&shading);
        self.refract(&shading);
    }

    /// Punctual lights, each behind a shadow ray.
    fn light(&mut self, shading: &Shading<'_, '_>) {
        for (subscript, light) in self.context.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(shading.point.position) else { continue };
            let wi = shading.world_from_local.transpose() * incidence.wi;
            let scattered = shading.bsdf.eval(shading.wo, wi) * wi.z.abs();
            let mut contribution = shading.weight_below * scattered * incidence.irradiance;
            let by_coat = shading.coat.as_ref().map_or(0.0, |coat| coat.scattered(incidence.wi));
            if by_coat > 0.0 {
                contribution += shading.weight * by_coat * incidence.irradiance;
            }
            if contribution.max_element() > 0.0 {
                let span = light.shadow_span(shading.point.position);
                let end = if wi.z > 0.0 || by_coat > 0.0 {
                    shading.point.shadow_end_outside(span)
                } else {
                    shading.point.shadow_end_inside(span)
                };
                let ray = light.shadow_ray(end, shading.state.seed, subscript);
                // The volumes around a lamp are not known; those around a lit surface are.
                let media =
                    if span == Vec3::ZERO { shading.state.media.clone() } else { MediaStack::default() };
                let source = (shading.signature, subscript);
                let part = shading.part.unwrap_or(LightPass::Direct);
                self.shadows.push(source, ray, (shading.state.sample, part), (contribution, media));
            }
        }
    }

    /// Mirror rays of the specular lobe and of the coat; one for both where they run the same way.
    fn mirror(&mut self, shading: &Shading<'_, '_>) {
        let scatters_coat = self.scatter_coat(shading);
        let scatters = self.scatter_reflection(shading);
        let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
        let mut weight = Vec3::ZERO;
        if !scatters {
            weight = shading.weight_below * shading.albedos.specular * shading.traced_share;
        }
        if let Some(coat) = &shading.coat
            && !scatters_coat
        {
            let weight_of_coat = shading.weight * (coat.albedo * coat.traced_share);
            if coat.mirrored == mirrored {
                weight += weight_of_coat;
            } else {
                self.send_mirrored(shading, coat.mirrored, weight_of_coat);
            }
        }
        self.send_mirrored(shading, mirrored, weight);
    }

    fn send_mirrored(&mut self, shading: &Shading<'_, '_>, direction: Vec3, weight: Vec3) {
        if self.may_send(shading.state, weight) {
            let ray = Ray::new(shading.point.origin_outside(), direction);
            let seed = shading.state.seed.child(Purpose::Reflection, 0, 1);
            let channels = shading.state.channels;
            self.send(shading, Child { ray, weight, kind: RayKind::Reflection, channels, seed });
        }
    }

    fn refract(&mut self, shading: &Shading<'_, '_>) {
        if shading.albedos.transmission == Vec3::ZERO || self.scatter_transmission(shading) {
            return;
        }
        for (channels, bsdf) in shading.transmission_lobes() {
            let weight = shading.weight_below
                * shading.albedos.transmission
                * shading.traced_share_transmitted
                * channels.mask();
            if weight == Vec3::ZERO {
                continue;
            }
            let Some(direction) = bsdf.refract(shading.wo) else { continue };
            if !self.may_send(shading.state, weight) {
                continue;
            }
            // Thin walls and equal media leave the direction exactly as it was.
            let unbent = direction == -shading.wo;
            let direction =
                if unbent { -shading.point.wo } else { (shading.world_from_local * direction).normalize() };
            let ray = Ray::new(shading.point.origin_inside(), direction);
            let seed = shading.state.seed.child(Purpose::Refraction, 0, 1);
            self.send(shading, Child { ray, weight, kind: RayKind::Refraction, channels, seed });
        }
    }

    /// Whether a child of `parent` would count, and is neither too deep nor too faint; else its weight is lost.
    pub(super) fn may_send(&mut self, parent: &RayState, weight: Vec3) -> bool {
        let largest = weight.max_element();
        if largest == 0.0 {
            return false;
        }
        // Of many rays each counts little.
        let least = LEAST_WEIGHT / self.context.settings.glossy_samples.max(1) as f32;
        if parent.depth >= self.context.settings.max_depth || largest < least {
            self.statistics.dropped_weight += f64::from(largest);
            return false;
        }
        true
    }

    /// Makes a child ray.
    pub(super) fn send(&mut self, shading: &Shading<'_, '_>, child: Child) {
        let Child { ray, weight, kind, channels, seed } = child;
        let parent = shading.state;
        let (view, point) = (self.context.view, shading.point);
        let (media, touching, differential) = match kind {
            RayKind::Refraction => (
                shading.behind.media.clone(),
                shading.behind.touching,
                point.refracted_differential(view, &parent.differential, ray.direction, shading.relative_ior),
            ),
            RayKind::Camera | RayKind::Reflection => {
                (parent.media.clone(), None, point.reflected_differential(view, &parent.differential))
            }
        };
        let part = shading.part.or(match kind {
            RayKind::Camera => None,
            RayKind::Reflection => Some(LightPass::Reflection),
            RayKind::Refraction => Some(LightPass::Refraction),
        });
        let depth = parent.depth + 1;
        let state =
            RayState { differential, media, touching, weight, kind, channels, part, depth, seed, ..*parent };
        self.children.push(shading.signature.then(kind), ray, state);
    }
}

/// The mirror ray, geometrically above the surface thanks to the bent normal.
pub(super) fn mirror_direction(wo: Vec3, normal: Vec3) -> Vec3 {
    (normal * (2.0 * wo.dot(normal)) - wo).normalize()
}

/// An orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
pub(super) fn local_frame(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

/// A frame around a unit normal whose first axis runs along a direction as far as it can.
fn frame_along(normal: Vec3, direction: Vec3) -> Mat3 {
    match unit(direction - normal * normal.dot(direction)) {
        Some(tangent) => Mat3::from_cols(tangent, normal.cross(tangent), normal),
        None => local_frame(normal),
    }
}

/// Share of a lobe that rays follow.
pub(super) fn traced_share(roughness: f32) -> f32 {
    1.0 - smoothstep(TRACED_ROUGHNESS, PREFILTERED_ROUGHNESS, roughness)
}

/// The albedos of each colour's own lobes.
fn by_color(dispersed: &[Bsdf; 3], wo: Vec3) -> Albedos {
    let mut sum = Albedos::default();
    for (bsdf, channels) in dispersed.iter().zip(ColorChannels::SINGLE) {
        let (albedos, mask) = (bsdf.albedos(wo), channels.mask());
        sum.specular += albedos.specular * mask;
        sum.diffuse += albedos.diffuse * mask;
        sum.transmission += albedos.transmission * mask;
        sum.diffuse_transmission += albedos.diffuse_transmission * mask;
        sum.sheen += albedos.sheen * mask;
    }
    sum
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let s = ((x - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
