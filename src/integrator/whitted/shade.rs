//! Shading of surfaces: emission, direct light, environment lookups and child rays.

use glam::Vec3;

use super::coat::CoatShading;
use super::environment_lookup::MAX_LOOKUPS;
use super::shading::Shading;
use super::shading_order::RunKey;
use super::traced_share::traced_share;
use super::tracer::Tracer;
use crate::bsdf::{Albedos, Bsdf};
use crate::geometry::{LANES, vectorized};
use crate::integrator::lights::IncidenceLanes;
use crate::integrator::local_frame::shading_frame;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::transmission_side::{TransmissionSide, ior_outside, ior_transmission_side};
use crate::integrator::wavefront::Wavefront;
use crate::integrator::{ColorChannels, EnvSamples, Integrator, LightPass, RayState};
use crate::interaction::{MaterialSample, SurfaceBlock, SurfacePoint, untextured_color};
use crate::scene::Material;

impl<'a> Tracer<'_, 'a> {
    /// Shades all surfaces that a wavefront sees, and adds the light of their shadow rays.
    pub(super) fn shade_surface_hits(&mut self, wavefront: &Wavefront) {
        let most_hits = self.hits_together();
        if self.surface_hits.len() > most_hits {
            self.shade_by_samples(wavefront, most_hits);
        } else {
            self.shade_together(wavefront);
        }
    }

    /// The same for `most_hits` hits at a time. All hits of a sample are shaded together, since the light behind its shadow rays is added after
    /// all other light: its sum is the same in every order of samples.
    fn shade_by_samples(&mut self, wavefront: &Wavefront, most_hits: usize) {
        let sample = |hit: &SurfaceHit| wavefront.ray(hit.slot).1.sample;
        let mut hits = std::mem::take(&mut self.surface_hits);
        hits.sort_by_key(sample);
        for of_sample in hits.chunk_by(|a, b| sample(a) == sample(b)) {
            if self.surface_hits.len() + of_sample.len() > most_hits {
                self.shade_together(wavefront);
            }
            self.surface_hits.extend_from_slice(of_sample);
        }
        self.shade_together(wavefront);
    }

    fn shade_together(&mut self, wavefront: &Wavefront) {
        // Surfaces may have others shaded in their place.
        while !self.surface_hits.is_empty() {
            self.shade_found_surfaces(wavefront);
        }
        self.trace_shadows();
    }

    /// Hits whose shadow rays the queue holds together.
    fn hits_together(&self) -> usize {
        let context = self.context;
        let lookups = match (&context.environment_directions, context.settings.env_samples) {
            // Paths choose among lights.
            _ if context.settings.integrator == Integrator::Path => return usize::MAX,
            (None, _) => 0,
            (Some(_), EnvSamples::Auto) => MAX_LOOKUPS,
            (Some(_), EnvSamples::Fixed(rays)) => MAX_LOOKUPS * rays as usize,
        };
        let rays_a_hit = context.lights.len() + lookups;
        (self.shadows.most_tasks / rays_a_hit.max(1)).max(1)
    }

    fn shade_found_surfaces(&mut self, wavefront: &Wavefront) {
        let (frame, opaque) = (self.context.view.frame, &self.context.opaque_materials);
        let traces_lobes = self.context.settings.glossy_samples > 0;
        let is_path = self.context.settings.integrator == Integrator::Path;
        let mut order = std::mem::take(&mut self.shading_order);
        order.sort(&self.surface_hits, |surface_hit| {
            let material = frame.instance(surface_hit.hit.triangle).material.index();
            let in_vacuum = wavefront.ray(surface_hit.slot).1.is_in_vacuum();
            let is_layered = !opaque[material] || !in_vacuum || traces_lobes || is_path;
            RunKey { is_layered, material: material as u32 }
        });
        self.surface_hits.clear();
        for (RunKey { is_layered, material }, hits) in order.runs() {
            let material = &frame.materials[material as usize];
            // Guides of denoising need points.
            if material.unlit && material.texture_refs().next().is_none() && !self.aovs.has_guides() {
                self.shade_unlit(wavefront, hits);
                continue;
            }
            for hits in hits.chunks(LANES) {
                if is_layered {
                    self.shade_one_by_one(wavefront, material, hits);
                } else {
                    self.shade_opaque_block(wavefront, material, hits);
                }
            }
        }
        self.shading_order = order;
    }

    /// Shades hits on a surface without light and textures.
    fn shade_unlit(&mut self, wavefront: &Wavefront, hits: &[SurfaceHit]) {
        for SurfaceHit { slot, hit, share, light_pass } in hits {
            let (_, state) = wavefront.ray(*slot);
            let weight = state.weight * state.media.transmittance(hit.t) * *share;
            let radiance = weight * untextured_color(self.context.view, hit);
            self.add_to_path(state, None, light_pass.unwrap_or(LightPass::Emission), radiance);
        }
    }

    /// Shades up to [`LANES`] hits on one material, after their points were computed together.
    fn shade_one_by_one(&mut self, wavefront: &Wavefront, material: &Material, hits: &[SurfaceHit]) {
        let Some(mut block) = self.surface_block.take() else { return };
        let view = self.context.view;
        block.fill(view, material, hits.iter().map(|hit| hit.ray_hit(wavefront)));
        block.compute_normal_steps(view, material);
        let mut materials = std::mem::take(&mut self.block_materials);
        self.find_materials(&block, &mut materials);
        self.probe_transmission_sides(&block.points, &materials);
        match self.context.settings.integrator {
            Integrator::Whitted => {
                self.find_incidences(&block);
                self.block_lookups.fill(self.context, &block, &materials);
                for (index, surface_hit) in hits.iter().enumerate() {
                    self.shade(wavefront, surface_hit, (index, &block.points[index]), &materials[index]);
                }
            }
            Integrator::Path => self.shade_paths(wavefront, (material, hits), (&block, &materials)),
        }
        self.block_materials = materials;
        self.surface_block = Some(block);
    }

    /// Computes the light that arrives at the points of a block without occlusion.
    fn find_incidences(&mut self, block: &SurfaceBlock<'a>) {
        let (lights, level) = (&self.context.lights, self.context.view.bvh.simd_level());
        self.block_incidences.resize_with(lights.len(), IncidenceLanes::default);
        for (light, incidences) in lights.iter().zip(&mut self.block_incidences) {
            vectorized!(level, light.incidences(block.positions(), incidences));
        }
    }

    /// Replaces `materials` by the material values at the points of a block.
    fn find_materials(&self, block: &SurfaceBlock<'a>, materials: &mut Vec<MaterialSample>) {
        let view = self.context.view;
        materials.clear();
        // The block has one material: a constant sample is that of all its instances without vertex colours.
        let mut constant = None;
        for (lane, point) in block.points.iter().enumerate() {
            let is_constant = self.context.constant_materials[point.instance.material.index()]
                && !block.has_vertex_colors(view, lane);
            match constant.filter(|_| is_constant) {
                Some(same) => materials.extend_from_within(same..=same),
                None => materials.push(block.material(view, lane)),
            }
            if is_constant {
                constant = constant.or(Some(lane));
            }
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
        let &SurfaceHit { slot, hit, share, light_pass } = surface_hit;

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
