//! Surfaces that a wavefront sees, by material and block by block, and what an integrator shades of them.

use super::shading_order::RunKey;
use super::tracer::Tracer;
use crate::geometry::LANES;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::wavefront::Wavefront;
use crate::integrator::{Integrator, LightPass};
use crate::interaction::{MaterialSample, SurfaceBlock, untextured_color};
use crate::scene::Material;

impl<'a> Tracer<'_, 'a> {
    /// Shades all surfaces that a wavefront sees, and adds the light of their shadow rays.
    pub(in crate::integrator) fn shade_surface_hits(&mut self, wavefront: &Wavefront) {
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
        // Paths choose among lights.
        if context.settings.integrator == Integrator::Path {
            return usize::MAX;
        }
        let lookups = self.most_lookup_rays();
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
            let needs_points = !opaque[material] || !in_vacuum || traces_lobes || is_path;
            RunKey { needs_points, material: material as u32 }
        });
        self.surface_hits.clear();
        for (RunKey { needs_points, material }, hits) in order.runs() {
            let material = &frame.materials[material as usize];
            // Guides of denoising need points.
            if material.unlit && material.texture_refs().next().is_none() && !self.aovs.has_guides() {
                self.shade_unlit(wavefront, hits);
                continue;
            }
            for hits in hits.chunks(LANES) {
                if needs_points {
                    self.shade_block_points(wavefront, material, hits);
                } else {
                    self.shade_opaque_block(wavefront, material, hits);
                }
            }
        }
        self.shading_order = order;
    }

    /// Shades hits on a surface without light and textures.
    fn shade_unlit(&mut self, wavefront: &Wavefront, hits: &[SurfaceHit]) {
        for SurfaceHit { slot, hit, share, light_pass, .. } in hits {
            let (_, state) = wavefront.ray(*slot);
            let weight = state.weight * state.media.transmittance(hit.t) * *share;
            let radiance = weight * untextured_color(self.context.view, hit);
            self.add_to_path(state, None, light_pass.unwrap_or(LightPass::Emission), radiance);
        }
    }

    /// Shades up to [`LANES`] hits on one material by their points, which are computed together.
    fn shade_block_points(&mut self, wavefront: &Wavefront, material: &Material, hits: &[SurfaceHit]) {
        let Some(mut block) = self.surface_block.take() else { return };
        let view = self.context.view;
        block.fill(view, material, hits.iter().map(|hit| hit.ray_hit(wavefront)));
        block.compute_normal_steps(view, material);
        let mut materials = std::mem::take(&mut self.block_materials);
        self.find_materials(&block, &mut materials);
        self.probe_transmission_sides(&block.points, &materials);
        match self.context.settings.integrator {
            Integrator::Whitted => self.shade_points(wavefront, hits, (&block, &materials)),
            Integrator::Path => self.shade_paths(wavefront, (material, hits), (&block, &materials)),
        }
        self.block_materials = materials;
        self.surface_block = Some(block);
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
}
