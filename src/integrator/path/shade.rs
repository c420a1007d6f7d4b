//! Shading of a surface of a path.

use std::rc::Rc;

use glam::{Mat3, Vec3};

use super::dimensions::{BounceSamples, Decision};
use super::mis::LastScatter;
use super::shaded_point::ShadedPoint;
use crate::bsdf::{Bsdf, Coat, Scattering};
use crate::integrator::whitted::{
    RaySignature, SurfaceHit, Tracer, Wavefront, ior_outside, ior_transmission_side, local_frame,
    shading_frame,
};
use crate::integrator::{ColorChannels, GuideSample, LightPass, RayState};
use crate::interaction::{MaterialSample, SurfacePoint};

/// A path where it arrives at a surface.
struct PathArrival<'s> {
    /// Signature of its ray.
    signature: RaySignature,
    state: &'s RayState,
    /// See [`SurfaceHit::light_pass`].
    light_pass: Option<LightPass>,
    /// The surface that sampled its ray.
    last: Option<LastScatter>,
    /// Multiplies radiance that leaves the surface.
    weight: Vec3,
    /// See [`SurfaceHit::share`].
    share: f32,
    /// The coat of the surface with its frame.
    coat: Option<(Coat, Mat3)>,
}

impl Tracer<'_, '_> {
    /// Adds the light of a surface to its path, and sends the ray that goes on.
    pub(in crate::integrator) fn shade_path(
        &mut self,
        wavefront: &Wavefront,
        surface_hit: &SurfaceHit,
        (index, point): (usize, &SurfacePoint<'_>),
        material: &MaterialSample,
    ) {
        let SurfaceHit { slot, hit, share, light_pass } = *surface_hit;
        let (_, state) = wavefront.ray(slot);
        let last = wavefront.last_scatter(slot).copied();
        let weight = state.weight * state.media.transmittance(hit.t) * share;

        // Emission
        if material.unlit {
            let radiance = weight * material.base_color;
            self.add_guide(state, share, (material, point));
            return self.add_to_path(state, light_pass.unwrap_or(LightPass::Emission), radiance);
        }
        let coat = material.clear_coat.map(|sample| {
            let world_from_coat = local_frame(sample.normal);
            (Coat::new(sample.factor, sample.roughness), world_from_coat, point.wo.dot(sample.normal))
        });
        let below = coat.as_ref().map_or(1.0, |(coat, _, cosine)| coat.transmittance(*cosine));
        let emitted = weight * material.emission * below;
        if self.photon_store.is_none() {
            self.add_path_emission(state, (&hit, point), (light_pass, last.as_ref()), emitted);
        }
        // The ray that the deepest surface sent finds lights alone, so that both ways to find them go equally far.
        if state.depth > self.context.settings.max_depth {
            self.statistics.dropped_weight += f64::from(weight.max_element());
            self.add_guide(state, share, (material, point));
            return;
        }

        let regularized = self.regularized(last.as_ref(), material);
        let material = regularized.as_ref().unwrap_or(material);
        let coat = coat.map(|(coat, world_from_coat, _)| (coat, world_from_coat));
        let arrival = PathArrival { signature: slot.signature, state, light_pass, last, weight, share, coat };
        self.scatter_path(&arrival, (index, point), material);
    }

    /// Sends the shadow rays of a surface, and the ray that goes on.
    fn scatter_path(
        &mut self,
        arrival: &PathArrival<'_>,
        (index, point): (usize, &SurfacePoint<'_>),
        material: &MaterialSample,
    ) {
        let PathArrival { signature, state, light_pass, last, mut weight, share, coat } = *arrival;

        // One colour channel of three where the surface disperses light
        let transmission_side = self.transmission_side(state, (index, point));
        let own_medium = self.context.interiors.medium(point.instance);
        let is_dispersive = transmission_side.disperses(state, own_medium, material);
        let sequence = self.sequences[state.sample as usize];
        Rc::make_mut(&mut self.bounce_keys).prepare(&sequence, state.depth);
        let keys = Rc::clone(&self.bounce_keys);
        let samples = BounceSamples { sequence, keys: &keys };
        let mut channels = state.channels;
        if is_dispersive {
            let u = samples.number(Decision::Channel);
            channels = ColorChannels::SINGLE[((u * 3.0) as usize).min(2)];
            weight *= channels.mask() * 3.0;
        }

        // Lobes
        let outside = ior_outside(state, own_medium, point.facing, channels);
        let inside = ior_transmission_side(material, &transmission_side.media, channels);
        let albedo_slice = self.albedo_slices.between(outside, inside);
        let bsdf = Bsdf::with_albedos(material, outside, inside, albedo_slice);
        let world_from_local = shading_frame(point.shading_normal, material.anisotropy.as_ref());
        let local_from_world = world_from_local.transpose();
        let coat = coat.map(|(coat, world_from_coat)| (coat, world_from_coat.transpose() * world_from_local));
        let scattering = Scattering::new(bsdf, local_from_world * point.wo, coat);
        let transmits = material.transmission > 0.0 || material.diffuse_transmission > 0.0;
        let visible = self.context.visible_environment.as_ref().filter(|_| !transmits);
        let visible = visible.and_then(|visible| visible.entry(point.position, point.geometric_normal));
        let guide = self.context.path_guide.as_ref().filter(|_| !transmits);
        let guidance = guide.and_then(|guide| {
            guide.guidance((point.position, point.geometric_normal), scattering.diffuse_probability())
        });
        let shaded = ShadedPoint {
            signature,
            state,
            light_pass,
            point,
            scattering: &scattering,
            world_from_local,
            weight,
            channels,
            transmission_side,
            relative_ior: if outside > 0.0 && inside > 0.0 { inside / outside } else { 1.0 },
            is_glass: material.transmission > 0.0,
            is_thin: material.thin,
            transmits,
            guidance,
            visible,
            samples,
            last,
        };
        if self.photon_store.is_none() {
            self.queue_lights(&shaded);
        } else if !self.store_photon(&shaded) {
            return;
        }
        // Mirrors and clear glass show what guides the denoising.
        if !self.send_path(&shaded, share) {
            self.add_guide(state, share, (material, point));
        }
    }

    /// The material, rougher where a ray that a rough surface sampled finds it: such rays hardly ever find what a smooth one focuses.
    /// `None` where it stays as it is.
    fn regularized(&self, last: Option<&LastScatter>, material: &MaterialSample) -> Option<MaterialSample> {
        // Shadow rays pass clear thin walls straight.
        let is_clear_wall = material.thin && material.transmission > 0.0;
        let is_regularized = self.context.settings.path.regularize && last.is_some() && !is_clear_wall;
        is_regularized.then(|| material.regularized())
    }

    fn add_guide(
        &mut self,
        state: &RayState,
        share: f32,
        (material, point): (&MaterialSample, &SurfacePoint<'_>),
    ) {
        let albedo = material.base_color.max(material.emission).min(Vec3::ONE);
        let guide = GuideSample { albedo, normal: point.shading_normal };
        self.aovs.add_guide(state.sample, state.guide_share * share, guide);
    }
}
