//! Shading of surfaces: emission, direct light, environment lookups and child rays.

use std::cell::OnceCell;

use glam::Vec3;

use super::coat::CoatShading;
use super::shading::Shading;
use super::traced_share::traced_share;
use crate::bsdf::{Albedos, Bsdf};
use crate::geometry::vectorized;
use crate::integrator::lights::IncidenceLanes;
use crate::integrator::local_frame::shading_frame;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::Tracer;
use crate::integrator::transmission_side::{TransmissionSide, ior_outside, ior_transmission_side};
use crate::integrator::wavefront::Wavefront;
use crate::integrator::{ColorChannels, LightPass, RayState};
use crate::interaction::{MaterialSample, SurfaceBlock, SurfacePoint};

impl<'a> Tracer<'_, 'a> {
    /// Shades the points of a block one by one.
    pub(in crate::integrator) fn shade_points(
        &mut self,
        wavefront: &Wavefront,
        hits: &[SurfaceHit],
        (block, materials): (&SurfaceBlock<'a>, &[MaterialSample]),
    ) {
        self.find_incidences(block);
        self.whitted.block_lookups.fill(self.context, block, materials);
        self.sample_first_lookups(wavefront, hits, block.normals());
        for (index, surface_hit) in hits.iter().enumerate() {
            self.shade(wavefront, surface_hit, (index, &block.points[index]), &materials[index]);
        }
    }

    /// Computes the light that arrives at the points of a block without occlusion.
    fn find_incidences(&mut self, block: &SurfaceBlock<'a>) {
        let (lights, level) = (&self.context.lights, self.context.view.bvh.simd_level());
        self.whitted.block_incidences.resize_with(lights.len(), IncidenceLanes::default);
        for (light, incidences) in lights.iter().zip(&mut self.whitted.block_incidences) {
            vectorized!(level, light.incidences(block.positions(), incidences));
        }
    }

    fn shade(
        &mut self,
        wavefront: &Wavefront,
        surface_hit: &SurfaceHit,
        (index, point): (usize, &SurfacePoint<'_>),
        material: &MaterialSample,
    ) {
        let state = wavefront.ray(surface_hit.slot).1;
        let transmission_side = self.transmission_side(state, (index, point));
        if !self.replace_by_touching(surface_hit, material, &transmission_side) {
            let state = state.arriving_at(&surface_hit.hit);
            self.shade_surface(&state, surface_hit, (index, point), (material, &transmission_side));
        }
    }

    fn shade_surface(
        &mut self,
        state: &RayState,
        surface_hit: &SurfaceHit,
        (index, point): (usize, &SurfacePoint<'_>),
        (material, transmission_side): (&MaterialSample, &TransmissionSide),
    ) {
        let &SurfaceHit { slot, hit, share, light_pass, .. } = surface_hit;

        // Emission
        let emission_pass = light_pass.unwrap_or(LightPass::Emission);
        let weight = state.weight * state.media.transmittance(hit.t) * share;
        if material.unlit {
            self.add(state.sample, emission_pass, weight * material.base_color);
            return;
        }
        let traces_lobes = self.context.settings.glossy_samples > 0;
        let coat = material.clear_coat.map(|coat| CoatShading::new(&coat, point, traces_lobes));
        let weight_below = weight * coat.as_ref().map_or(1.0, |coat| coat.transmittance);
        self.add(state.sample, emission_pass, weight_below * material.emission);

        // Lobes between the media on both sides, one set for each colour channel where these disperse
        let own_medium = self.context.interiors.medium(point.instance);
        let iors = |channels| {
            let outside = ior_outside(state, own_medium, point.facing, channels);
            (outside, ior_transmission_side(material, &transmission_side.media, channels))
        };
        let lobes_between = |(outside, inside)| Bsdf::new(material, outside, inside);
        let (outside, inside) = iors(state.channels);
        let albedo_slice = self.albedo_slices.between(outside, inside);
        let bsdf = Bsdf::with_albedos(material, outside, inside, albedo_slice);
        let is_dispersive = transmission_side.disperses(state, own_medium, material);
        let single_channels = || ColorChannels::SINGLE.map(|channels| lobes_between(iors(channels)));
        let dispersed = is_dispersive.then(single_channels);

        // Local frame
        let world_from_local = shading_frame(point.shading_normal, material.anisotropy.as_ref());
        let wo = world_from_local.transpose() * point.wo;
        let terms = bsdf.albedo_terms(wo);
        let traced_share_of = |roughness| if traces_lobes { 1.0 } else { traced_share(roughness) };
        let mut shading = Shading {
            signature: slot.signature,
            state,
            light_pass,
            index,
            point,
            albedos: dispersed
                .as_ref()
                .map_or_else(|| bsdf.albedos_by(wo, terms), |lobes| channel_albedos(lobes, wo)),
            material,
            bsdf: &bsdf,
            terms,
            scattering: OnceCell::new(),
            world_from_local,
            wo,
            weight,
            weight_below,
            coat: coat.as_ref(),
            dispersed: dispersed.as_ref(),
            transmission_side,
            iors: [outside, inside],
            traced_share: traced_share_of(bsdf.widest_roughness()),
            follows_transmission: self.follows_transmission(&bsdf, state),
            traced_share_transmitted: traced_share_of(bsdf.widest_transmission_roughness()),
            facet_share: 0.0,
        };
        shading.facet_share = self.facet_share(&shading);
        self.scatter(&shading);
    }

    /// Adds the light that a surface scatters towards the viewer, and sends the rays that find the rest of it.
    fn scatter(&mut self, shading: &Shading<'_, '_>) {
        self.queue_direct_light(shading);
        self.add_environment_light(shading);
        self.reflect(shading);
        self.refract(shading);
    }
}

/// The albedos of dispersed lobes: each colour channel from its own lobes.
fn channel_albedos(dispersed: &[Bsdf; 3], wo: Vec3) -> Albedos {
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
