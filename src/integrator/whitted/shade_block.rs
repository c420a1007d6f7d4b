//! Shading of hits on opaque surfaces, block by block.

use glam::Vec3;

use super::environment_shadows::JoinedLookups;
use super::opaque_block::{BLOCK_LOOKUPS, OpaqueBlock};
use super::shading::Arrival;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::{ShadowRay, Tracer};
use crate::integrator::wavefront::Wavefront;
use crate::integrator::{LightPass, MediaStack};
use crate::scene::Material;

impl Tracer<'_, '_> {
    /// Shades up to [`crate::geometry::LANES`] hits on one opaque material whose rays run through vacuum.
    pub(in crate::integrator) fn shade_opaque_block(
        &mut self,
        wavefront: &Wavefront,
        material: &Material,
        hits: &[SurfaceHit],
    ) {
        let Some(mut block) = self.whitted.opaque_block.take() else { return };
        block.compute(self.context, wavefront, (material, hits));
        let directions = self.lookup_directions(&block, wavefront, hits);
        for (lane, (hit, directions)) in hits.iter().zip(&directions).enumerate() {
            self.finish_hit((&block, lane), wavefront, (material, hit), directions);
        }
        self.whitted.opaque_block = Some(block);
    }

    /// Adds the light of a hit to its sample, queues its shadow rays and sends its mirror ray. `directions` are those of its lookups.
    fn finish_hit(
        &mut self,
        (block, lane): (&OpaqueBlock<'_>, usize),
        wavefront: &Wavefront,
        (material, surface_hit): (&Material, &SurfaceHit),
        directions: &[Option<Vec3>; BLOCK_LOOKUPS],
    ) {
        let SurfaceHit { slot, light_pass, .. } = *surface_hit;
        let (_, state) = wavefront.ray(slot);
        let emission = block.materials.weight.get(lane) * block.materials.emission.get(lane);
        self.add(state.sample, light_pass.unwrap_or(LightPass::Emission), emission);
        for (index, direct) in block.direct.iter().enumerate() {
            let contribution = direct.contribution.get(lane);
            if contribution.max_element() > 0.0 {
                let (light, end) = (&self.context.lights[index], direct.shadow_end.get(lane));
                self.shadows.push(ShadowRay {
                    signature: slot.signature,
                    light: index,
                    ray: light.shadow_ray(end, state.seed, index),
                    sample: state.sample,
                    light_pass: light_pass.unwrap_or(light.light_pass()),
                    contribution,
                    for_hidden: Vec3::ZERO,
                    environment_clamp: None,
                    // Blocks are in vacuum.
                    media: SurfaceMedia::of_lamp(light.position().is_none(), MediaStack::default()),
                });
            }
        }
        let point = &block.surfaces.points[lane];
        let arrival = Arrival { signature: slot.signature, state, light_pass, point };
        let direction = block.reflected.mirrored.get(lane);
        let (lookups, brighter) = block.reflected.lookups(lane, point.shading_normal);
        let color = block.materials.base.base_color(lane);
        let lookups = JoinedLookups { lookups: &lookups, brightest: Some(brighter), directions };
        self.add_joined_lookups(&arrival, &MediaStack::default(), &lookups, color);
        let weight = block.reflected.specular.get(lane);
        let roughness = block.reflected.lobe_roughness[lane];
        let (albedo, traced_share) = block.reflected.specular_albedo(lane);
        let followed = self.followed_reflection(albedo, traced_share);
        self.send_mirror_ray(&arrival, (direction, roughness), weight * (1.0 - followed));
        if followed > 0.0
            && let Some(bsdf) = block.bsdf(self.context, material, lane)
        {
            let lobe = block.reflected.lobe(&bsdf, lane);
            self.follow_reflection(&arrival, &lobe, block.materials.weight.get(lane) * followed);
        }
    }
}
