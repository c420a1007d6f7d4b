//! Shading of a surface of a path.

use arrayvec::ArrayVec;
use glam::{Mat3, Vec3};

use super::VisibleEntry;
use super::dimensions::{BounceKeys, BounceSamples};
use super::guiding::Guidance;
use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::bsdf::{Bsdf, Coat, OrientedCoat, Scattering};
use crate::geometry::LANES;
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::local_frame::{local_frame, shading_frame};
use crate::integrator::opaque_materials::is_opaque;
use crate::integrator::ray_state::ArrivingState;
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::tracing::Tracer;
use crate::integrator::transmission_side::{TransmissionSide, ior_outside, ior_transmission_side};
use crate::integrator::wavefront::{RaySignature, Wavefront};
use crate::integrator::{GuideSample, LightPass, RayState};
use crate::interaction::{MaterialSample, SurfaceBlock, SurfacePoint};
use crate::scene::Material;

/// A path where it arrives at a surface.
struct PathArrival<'s> {
    /// Lane of the surface in its block.
    lane: usize,
    /// Signature of its ray.
    signature: RaySignature,
    state: ArrivingState<'s>,
    transmission_side: TransmissionSide,
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

impl<'w, 'a> Tracer<'w, 'a> {
    /// Adds the light of the surfaces of a block to their paths, and sends the rays that go on.
    pub(in crate::integrator) fn shade_paths(
        &mut self,
        wavefront: &Wavefront,
        (material, hits): (&Material, &[SurfaceHit]),
        (points, materials): (&SurfaceBlock<'a>, &[MaterialSample]),
    ) {
        let Some(mut block) = self.path.block.take() else { return };
        let context = self.context;
        let level = context.view.bvh.simd_level();
        let in_vacuum = |hit: &SurfaceHit| wavefront.ray(hit.slot).1.is_in_vacuum();
        let table = context.opaque_albedos.table(material).filter(|_| is_opaque(material));
        block.begin(table.is_some() && hits.iter().all(in_vacuum), hits.len());
        // Lobes that are not in lanes gain nothing from stages.
        let together = if block.is_in_lanes() { hits.len() } else { 1 };
        let mut surfaces = ArrayVec::<_, LANES>::new();
        for (stage, hits) in hits.chunks(together.max(1)).enumerate() {
            surfaces.clear();
            for (lane, hit) in (stage * together..).zip(hits) {
                let of_point = (lane, &points.points[lane]);
                let surface = self.shade_path(wavefront, hit, of_point, &materials[lane], &mut block);
                if let Some(surface) = surface {
                    surfaces.push(surface);
                }
            }
            block.fill(level, (material, table), &surfaces, points.viewers());
            if self.path.photon_store.is_some() {
                surfaces.retain(|surface| self.store_photon(surface, &block));
            } else {
                for surface in &mut surfaces {
                    surface.guidance = self.guidance(surface, &block);
                }
                self.queue_lights(&surfaces, &mut block, points.positions());
            }
            self.send_paths(&surfaces, &mut block);
        }
        self.path.block = Some(block);
    }

    /// Adds the light of a surface to its path, and prepares the surface for scattering; `None` where the path ends.
    #[inline(always)]
    fn shade_path<'p>(
        &mut self,
        wavefront: &'p Wavefront,
        surface_hit: &SurfaceHit,
        (lane, point): (usize, &'p SurfacePoint<'a>),
        material: &'p MaterialSample,
        block: &mut PathBlock,
    ) -> Option<ShadedPoint<'p, 'a>>
    where
        'w: 'p,
    {
        let SurfaceHit { slot, hit, share, light_pass, .. } = *surface_hit;
        let ray_state = wavefront.ray(slot).1;
        let transmission_side = self.transmission_side(ray_state, (lane, point));
        if self.replace_by_touching(surface_hit, material, &transmission_side) {
            return None;
        }
        let state = ray_state.arriving_at(&hit);
        let last = wavefront.last_scatter(slot).copied();
        let weight = state.weight * state.media.transmittance(hit.t) * share;

        // Emission
        if material.unlit {
            let radiance = weight * material.base_color;
            self.add_guide((&state, share), (material, point));
            self.add_to_path(&state, None, light_pass.unwrap_or(LightPass::Emission), radiance);
            return None;
        }
        let coat = material.clear_coat.map(|sample| {
            let world_from_coat = local_frame(sample.normal);
            (Coat::new(sample.factor, sample.roughness), world_from_coat, point.wo.dot(sample.normal))
        });
        let below = coat.as_ref().map_or(1.0, |(coat, _, cosine)| coat.transmittance(*cosine));
        let emitted = weight * material.emission * below;
        if self.path.photon_store.is_none() {
            self.add_path_emission(&state, last.as_ref(), (surface_hit, point), emitted);
        }
        let coat = coat.map(|(coat, world_from_coat, _)| (coat, world_from_coat));
        let is_too_deep = state.depth > self.context.settings.max_depth;
        let signature = slot.signature;
        let arrival =
            PathArrival { lane, signature, state, transmission_side, light_pass, last, weight, share, coat };
        if is_too_deep {
            self.end_path(arrival, (point, material), block);
            return None;
        }
        Some(self.prepare_surface(arrival, point, material, block))
    }

    /// Ends a path beyond its deepest surface. The ray from there finds lights alone, also through clear thin walls, so that both ways
    /// to find them go equally far.
    fn end_path(
        &mut self,
        arrival: PathArrival<'_>,
        (point, material): (&SurfacePoint<'a>, &MaterialSample),
        block: &mut PathBlock,
    ) {
        let (lane, weight) = (arrival.lane, arrival.weight);
        self.add_guide((&arrival.state, arrival.share), (material, point));
        let may_pass = arrival.last.is_some() && material.thin && material.transmission > 0.0;
        let mut passed = Vec3::ZERO;
        if may_pass {
            let wall = self.prepare_surface(arrival, point, material, block);
            if let Some(transmittance) = block.clear_wall_transmittance(lane) {
                passed = self.pass_wall(&wall, transmittance);
            }
        }
        self.statistics.dropped_weight += f64::from((weight - passed).max_element());
    }

    /// The surface with its lobes.
    #[inline(always)]
    fn prepare_surface<'p>(
        &mut self,
        arrival: PathArrival<'p>,
        point: &'p SurfacePoint<'a>,
        material: &'p MaterialSample,
        block: &mut PathBlock,
    ) -> ShadedPoint<'p, 'a>
    where
        'w: 'p,
    {
        let PathArrival {
            lane,
            signature,
            state,
            transmission_side,
            light_pass,
            last,
            mut weight,
            share,
            coat,
        } = arrival;
        // Regularisation
        let regularized = self.regularized(last.as_ref(), material);
        let lobe_material = regularized.as_ref().unwrap_or(material);

        // One colour channel of three where the surface disperses light
        let own_medium = self.context.interiors.medium(point.instance);
        let is_dispersive = transmission_side.disperses(&state, own_medium, material);
        let sequence = self.sequences[state.sample as usize];
        let keys = BounceKeys::shared(&mut self.path.bounce_keys, &sequence, state.depth);
        let samples = BounceSamples { sequence, keys };
        let channels = if is_dispersive { samples.single_channel() } else { state.channels };
        if is_dispersive {
            weight *= channels.mask() * channels.gain();
        }

        // Lobes
        let outside = ior_outside(&state, own_medium, point.facing, channels);
        let inside = ior_transmission_side(material, &transmission_side.media, channels);
        let world_from_local = shading_frame(point.shading_normal, material.anisotropy.as_ref());
        if block.is_in_lanes() {
            block.set_material(lane, lobe_material);
        } else {
            let albedo_slice = self.albedo_slices.between(outside, inside);
            let bsdf = Bsdf::with_albedos(lobe_material, outside, inside, albedo_slice);
            block.set_lobes(lane, &scattering_at(point, &world_from_local, bsdf, coat));
        }
        let transmits = material.transmission > 0.0 || material.diffuse_transmission > 0.0;
        ShadedPoint {
            lane,
            signature,
            state,
            light_pass,
            share,
            point,
            material,
            world_from_local,
            weight,
            channels,
            hides_lamps: transmission_side.stops_lamps(self.context),
            transmission_side,
            relative_ior: if outside > 0.0 && inside > 0.0 { inside / outside } else { 1.0 },
            transmits,
            guidance: None,
            visible: self.visible_entry(point).filter(|_| !transmits),
            samples,
            last,
        }
    }

    /// What a surface sees of the environment that scatters light of its own side.
    fn visible_entry(&self, point: &SurfacePoint<'_>) -> Option<VisibleEntry> {
        let visible = self.context.visible_environment.as_ref()?;
        visible.entry(point.position, point.geometric_normal)
    }

    /// How a surface guides its rays.
    fn guidance<'p>(&self, surface: &ShadedPoint<'p, 'a>, block: &PathBlock) -> Option<Guidance<'p>>
    where
        'w: 'p,
    {
        let guide = self.context.path_guide.as_ref().filter(|_| !surface.transmits)?;
        let at = (surface.point.position, surface.point.geometric_normal);
        guide.guidance(at, block.diffuse_probability(surface.lane))
    }

    /// The material, rougher where a ray that a rough surface sampled finds it: such rays hardly ever find what a smooth one focuses.
    /// `None` where it stays as it is.
    fn regularized(&self, last: Option<&LastScatter>, material: &MaterialSample) -> Option<MaterialSample> {
        // Shadow rays pass clear thin walls straight.
        let is_clear_wall = material.thin && material.transmission > 0.0;
        let is_regularized = self.context.settings.path.regularize && last.is_some() && !is_clear_wall;
        is_regularized.then(|| material.regularized())
    }

    /// Adds what guides the denoising, of a surface at which `share` of a ray stays.
    pub(super) fn add_guide(
        &mut self,
        (state, share): (&RayState, f32),
        (material, point): (&MaterialSample, &SurfacePoint<'_>),
    ) {
        let albedo = material.base_color.max(material.emission).min(Vec3::ONE);
        let guide = GuideSample { albedo, normal: point.shading_normal };
        self.aovs.add_guide(state.sample, state.guide_share * share, guide);
    }
}

/// The lobes of a surface towards the viewer of a point, below its coat with the coat's frame.
#[inline(always)]
fn scattering_at(
    point: &SurfacePoint<'_>,
    world_from_local: &Mat3,
    bsdf: Bsdf,
    coat: Option<(Coat, Mat3)>,
) -> Scattering {
    let local_from_world = world_from_local.transpose();
    let coat = coat.map(|(coat, world_from_coat)| OrientedCoat {
        coat,
        coat_from_local: world_from_coat.transpose() * *world_from_local,
        geometric_normal: local_from_world * point.geometric_normal,
    });
    Scattering::new(bsdf, local_from_world * point.wo, coat)
}
