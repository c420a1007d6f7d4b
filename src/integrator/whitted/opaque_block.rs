//! Shading of blocks of hits on opaque metallic-roughness surfaces: the material model without the lobes of extensions.
//!
//! Every value is that of [`super::shade`], by the same functions, but computed for all lanes of a block at once. Only lookups in tables and
//! images are left to each hit. [`super::shade_block`] adds the values to samples and sends the rays that leave the surfaces.

use std::f32::consts::FRAC_1_PI;

use fearless_simd::Level;
use glam::{Mat3, Vec3};

use super::environment_lookup::{EnvironmentLookup, LookupLobe, join_faint_pair};
use super::reflected_lobe::ReflectedLobe;
use super::traced_share::traced_share;
use crate::bsdf::{AlbedoSlice, AlbedoTable, AlbedoTermLanes, Bsdf};
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec3Lanes, vectorized};
use crate::integrator::IntegratorContext;
use crate::integrator::least_weights::MIN_SCATTERED;
use crate::integrator::lights::{Incidence, IncidenceLanes};
use crate::integrator::local_frame::{local_frame, mirror_direction};
use crate::integrator::lookup_environment::LookupEnvironment;
use crate::integrator::prefiltered_lobe::{PrefilteredLobe, RoughLobe};
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::wavefront::Wavefront;
use crate::interaction::{BaseMaterialLanes, MaterialSample, SurfaceBlock};
use crate::scene::{LookupLanes, Material};

/// Lookups of a surface of a block: of its diffuse and of its specular lobe.
pub(super) const BLOCK_LOOKUPS: usize = 2;

/// The material of a block.
#[derive(Clone, Copy)]
struct BlockMaterial<'m> {
    material: &'m Material,
    /// Albedos between vacuum and the material.
    albedos: AlbedoSlice,
}

impl BlockMaterial<'_> {
    /// The lobes of a lane.
    #[inline(always)]
    fn bsdf(self, materials: &MaterialLanes, lane: usize) -> Bsdf {
        let ior = self.material.ior;
        Bsdf::in_lane(&materials.base.get(lane, ior), 1.0, ior, self.albedos)
    }
}

/// The values of a block. Keeps its memory from block to block.
#[derive(Debug, Default)]
pub(super) struct OpaqueBlock<'a> {
    pub(super) surfaces: SurfaceBlock<'a>,
    pub(super) materials: MaterialLanes,
    pub(super) reflected: ReflectedLanes,
    incidences: IncidenceLanes,
    /// For each light.
    pub(super) direct: Vec<DirectLanes>,
}

/// Material values and the weights of the rays.
#[derive(Debug, Default)]
pub(super) struct MaterialLanes {
    pub(super) base: BaseMaterialLanes,
    occlusion: F32Lanes,
    pub(super) emission: Vec3Lanes,
    /// Multiplies the radiance that leaves the surface.
    pub(super) weight: Vec3Lanes,
}

/// Directions and albedos.
#[derive(Debug, Default)]
pub(super) struct ReflectedLanes {
    /// Axes of the local frame; the third is the shading normal.
    axes: [Vec3Lanes; 3],
    /// Direction to the viewer in the local frame.
    wo: Vec3Lanes,
    cos_o: F32Lanes,
    pub(super) mirrored: Vec3Lanes,
    pub(super) lobe_roughness: F32Lanes,
    /// Axis and roughness of the narrow lobe that is looked up for the specular one.
    looked_up: (Vec3Lanes, F32Lanes),
    /// Share of the specular lobe that rays follow.
    traced_share: F32Lanes,
    albedos: AlbedoTermLanes,
    /// Albedo of the specular lobe.
    specular_albedo: Vec3Lanes,
    /// Weight of the mirror ray.
    pub(super) specular: Vec3Lanes,
    /// Irradiance of the environment, then the light of it that leaves the surface: diffuse light, and that of the broad part of the specular lobe.
    diffuse: Vec3Lanes,
    /// Prefiltered radiance of the broad part of the specular lobe.
    broad: Vec3Lanes,
    /// Prefiltered radiance of the narrow lobe, then the light of it that leaves the surface.
    prefiltered: Vec3Lanes,
    /// What both would be in light of radiance 1 from everywhere.
    diffuse_albedo: Vec3Lanes,
    prefiltered_albedo: Vec3Lanes,
    /// 1 where the second is the brighter one, else 0.
    is_prefiltered_brighter: F32Lanes,
}

/// Light of one light that leaves the surfaces, and the ends of the shadow rays that decide about it.
#[derive(Debug, Default)]
pub(super) struct DirectLanes {
    pub(super) contribution: Vec3Lanes,
    pub(super) shadow_end: Vec3Lanes,
}

impl OpaqueBlock<'_> {
    /// A block for scenes with `lights` lights.
    pub(super) fn new(lights: usize) -> Self {
        let direct = std::iter::repeat_with(DirectLanes::default).take(lights).collect();
        Self { direct, ..Self::default() }
    }
}

impl<'a> OpaqueBlock<'a> {
    /// Computes everything that neither adds to samples nor sends rays.
    pub(super) fn compute(
        &mut self,
        context: &IntegratorContext<'a>,
        wavefront: &Wavefront,
        (material, hits): (&Material, &[SurfaceHit]),
    ) {
        let Some(table) = context.opaque_albedos.table(material) else { return };
        let view = context.view;
        let block_material = BlockMaterial { material, albedos: table.slice() };
        self.surfaces.fill(view, material, hits.iter().map(|hit| hit.ray_hit(wavefront)));

        // Material values
        let is_textured = material.texture_refs().next().is_some();
        let mut constant: Option<MaterialSample> = None;
        for (lane, surface_hit) in hits.iter().enumerate() {
            let weight = wavefront.ray(surface_hit.slot).1.weight * surface_hit.share;
            let is_constant = !is_textured && !self.surfaces.has_vertex_colors(view, lane);
            if is_constant && let Some(sample) = &constant {
                self.materials.set(lane, sample, weight);
            } else {
                let sample = self.surfaces.material(view, lane);
                self.materials.set(lane, &sample, weight);
                constant = is_constant.then_some(sample);
            }
        }
        // An occlusion map stands for what is not traced.
        for occlusion in &mut self.materials.occlusion {
            *occlusion = context.untraced_occlusion(*occlusion);
        }

        // Directions, albedos and the environment
        let Self { surfaces, materials, reflected, incidences, .. } = self;
        let points = &surfaces.points;
        let level = view.bvh.simd_level();
        vectorized!(level, reflected.orient(surfaces.normals(), surfaces.viewers(), materials));
        reflected.look_up(
            (level, ActiveLanes::first(hits.len())),
            &context.lookups,
            (surfaces.positions(), surfaces.normals()),
            (&materials.base, table),
        );
        vectorized!(level, reflected.reflect(materials, block_material));
        if context.environment_directions.is_some() {
            vectorized!(level, reflected.join_faint(context.mean_radiance));
        }

        // Lights
        for (light, direct) in context.lights.iter().zip(&mut self.direct) {
            vectorized!(level, {
                light.incidences(surfaces.positions(), incidences);
                direct.scatter(incidences, (materials, block_material), reflected);
            });
            for (lane, point) in points.iter().enumerate() {
                let span = incidences.get(lane).span;
                direct.shadow_end.set(lane, point.shadow_end_outside(span));
            }
        }
    }
}

impl OpaqueBlock<'_> {
    /// The lobes of a lane.
    pub(super) fn bsdf(
        &self,
        context: &IntegratorContext<'_>,
        material: &Material,
        lane: usize,
    ) -> Option<Bsdf> {
        let albedos = context.opaque_albedos.table(material)?.slice();
        Some(BlockMaterial { material, albedos }.bsdf(&self.materials, lane))
    }
}

impl MaterialLanes {
    #[inline(always)]
    fn set(&mut self, lane: usize, sample: &MaterialSample, weight: Vec3) {
        self.base.set(lane, sample);
        self.occlusion[lane] = sample.occlusion;
        self.emission.set(lane, sample.emission);
        self.weight.set(lane, weight);
    }
}

impl ReflectedLanes {
    /// Local frames and mirror directions.
    #[inline(always)]
    fn orient(&mut self, normals: &Vec3Lanes, viewers: &Vec3Lanes, materials: &MaterialLanes) {
        for lane in 0..LANES {
            let (normal, wo) = (normals.get(lane), viewers.get(lane));
            let world_from_local = local_frame(normal);
            self.axes[0].set(lane, world_from_local.x_axis);
            self.axes[1].set(lane, world_from_local.y_axis);
            self.axes[2].set(lane, normal);
            let local_wo = world_from_local.transpose() * wo;
            self.wo.set(lane, local_wo);
            self.cos_o[lane] = local_wo.z;
            let mirrored = mirror_direction(wo, normal);
            self.mirrored.set(lane, mirrored);
            let roughness = materials.base.roughness()[lane].clamp(0.0, 1.0);
            let looked_up = RoughLobe::new(mirrored, normal, local_wo.z, roughness).narrow;
            self.looked_up.0.set(lane, looked_up.direction);
            self.looked_up.1[lane] = looked_up.roughness;
            self.lobe_roughness[lane] = roughness;
            self.traced_share[lane] = traced_share(roughness);
        }
    }

    /// Looks up albedos and the environment.
    fn look_up(
        &mut self,
        (level, lanes): (Level, ActiveLanes),
        environment: &LookupEnvironment<'_>,
        (positions, normals): (&Vec3Lanes, &Vec3Lanes),
        (materials, table): (&BaseMaterialLanes, &AlbedoTable),
    ) {
        table.terms((level, lanes), &self.cos_o, &self.lobe_roughness, &mut self.albedos);
        let normals = LookupLanes { level, directions: normals, lanes };
        environment.irradiances(positions, &normals, &mut self.diffuse);
        let lanes = lanes.filtered(|lane| self.traced_share[lane] < 1.0);
        if !lanes.is_empty() {
            let (directions, roughness) = &self.looked_up;
            let directions = LookupLanes { level, directions, lanes };
            environment.prefiltered_lanes(positions, &directions, roughness, &mut self.prefiltered);
        }
        // Irradiance stands for the broad part of the faint lobes of dielectrics.
        let lanes = lanes.filtered(|lane| materials.metallic()[lane] > 0.0);
        if !lanes.is_empty() {
            let normals = LookupLanes { lanes, ..normals };
            environment.prefiltered_lanes(positions, &normals, &[1.0; LANES], &mut self.broad);
        }
    }

    /// The lobe of a lane that is looked up for the specular one.
    #[inline(always)]
    fn looked_up(&self, lane: usize) -> PrefilteredLobe {
        let (directions, roughness) = &self.looked_up;
        PrefilteredLobe { direction: directions.get(lane), roughness: roughness[lane] }
    }

    /// Albedos, and the light of the environment that leaves the surfaces.
    #[inline(always)]
    fn reflect(&mut self, materials: &MaterialLanes, material: BlockMaterial<'_>) {
        for lane in 0..LANES {
            let bsdf = material.bsdf(materials, lane);
            let albedos = bsdf.albedos_by(self.wo.get(lane), self.albedos.get(lane));
            let prefiltered_share = 1.0 - self.traced_share[lane];
            let weight = materials.weight.get(lane);
            let reached = weight * materials.occlusion[lane];
            let specular = albedos.specular * prefiltered_share;
            // The broad part of the rough lobe is looked up with the diffuse one.
            let broad_share = RoughLobe::broad_share(self.lobe_roughness[lane]);
            let (diffuse, broad) = (reached * albedos.diffuse, reached * (specular * broad_share));
            let mean = self.diffuse.get(lane) * FRAC_1_PI;
            let is_metallic = materials.base.metallic()[lane] > 0.0;
            let seen = if is_metallic { self.broad.get(lane) } else { mean };
            self.diffuse_albedo.set(lane, diffuse + broad);
            self.diffuse.set(lane, diffuse * mean + broad * seen);
            let prefiltered = reached * (specular * (1.0 - broad_share));
            self.prefiltered_albedo.set(lane, prefiltered);
            let seen = prefiltered * self.prefiltered.get(lane);
            self.prefiltered.set(lane, if prefiltered_share > 0.0 { seen } else { Vec3::ZERO });
            self.specular_albedo.set(lane, albedos.specular);
            self.specular.set(lane, weight * albedos.specular * self.traced_share[lane]);
        }
    }

    /// Adds the fainter of both lights of the environment to the brighter one, where the difference is large.
    #[inline(always)]
    fn join_faint(&mut self, mean_radiance: Vec3) {
        for lane in 0..LANES {
            let mut lights = [
                [self.diffuse.get(lane), self.diffuse_albedo.get(lane)],
                [self.prefiltered.get(lane), self.prefiltered_albedo.get(lane)],
            ];
            let is_second = join_faint_pair(&mut lights, mean_radiance);
            let [[diffuse, diffuse_albedo], [prefiltered, prefiltered_albedo]] = lights;
            self.diffuse.set(lane, diffuse);
            self.diffuse_albedo.set(lane, diffuse_albedo);
            self.prefiltered.set(lane, prefiltered);
            self.prefiltered_albedo.set(lane, prefiltered_albedo);
            self.is_prefiltered_brighter[lane] = if is_second { 1.0 } else { 0.0 };
        }
    }

    /// What a surface with this shading normal looks up, and the index of the brighter lookup.
    pub(super) fn lookups(&self, lane: usize, normal: Vec3) -> ([EnvironmentLookup; BLOCK_LOOKUPS], usize) {
        let [diffuse, glossy] =
            [[&self.diffuse, &self.diffuse_albedo], [&self.prefiltered, &self.prefiltered_albedo]]
                .map(|values| values.map(|lanes| lanes.get(lane)));
        let lookup = |[radiance, albedo]: [Vec3; 2], lookup| EnvironmentLookup {
            radiance,
            albedo,
            lobe: self.looked_up_lobe(lane, lookup, normal),
            is_outside: true,
        };
        let lookups = [lookup(diffuse, 0), lookup(glossy, 1)];
        (lookups, usize::from(self.is_prefiltered_brighter[lane] > 0.0))
    }

    /// Whether one of [`ReflectedLanes::lookups`] looks anything up.
    pub(super) fn looks_up(&self, lane: usize, lookup: usize) -> bool {
        let albedos = [&self.diffuse_albedo, &self.prefiltered_albedo][lookup];
        albedos.get(lane).max_element() > 0.0
    }

    /// The lobe of one of [`ReflectedLanes::lookups`].
    pub(super) fn looked_up_lobe(&self, lane: usize, lookup: usize, normal: Vec3) -> LookupLobe {
        if lookup == 0 { LookupLobe::Diffuse { normal } } else { LookupLobe::Glossy(self.looked_up(lane)) }
    }

    /// The albedo of the specular lobe, and the share of it that the mirror ray follows.
    pub(super) fn specular_albedo(&self, lane: usize) -> (Vec3, f32) {
        (self.specular_albedo.get(lane), self.traced_share[lane])
    }

    /// The specular lobe of a lane.
    pub(super) fn lobe<'b>(&self, bsdf: &'b Bsdf, lane: usize) -> ReflectedLobe<'b> {
        ReflectedLobe {
            bsdf,
            terms: self.albedos.get(lane),
            world_from_local: self.world_from_local(lane),
            wo: self.wo.get(lane),
            albedo: self.specular_albedo.get(lane),
        }
    }

    /// The local frame of a lane; its columns are tangent, bitangent and normal.
    #[inline(always)]
    fn world_from_local(&self, lane: usize) -> Mat3 {
        let [tangent, bitangent, normal] = &self.axes;
        Mat3::from_cols(tangent.get(lane), bitangent.get(lane), normal.get(lane))
    }
}

impl DirectLanes {
    /// The light that the surfaces scatter towards the viewer.
    #[inline(always)]
    fn scatter(
        &mut self,
        incidences: &IncidenceLanes,
        (materials, material): (&MaterialLanes, BlockMaterial<'_>),
        reflected: &ReflectedLanes,
    ) {
        for lane in 0..LANES {
            let Incidence { wi, irradiance, .. } = incidences.get(lane);
            let bsdf = material.bsdf(materials, lane);
            let wi = reflected.world_from_local(lane).transpose() * wi;
            let scattered =
                bsdf.eval_by(reflected.wo.get(lane), wi, reflected.albedos.get(lane)) * wi.z.abs();
            let scattered = materials.weight.get(lane) * scattered;
            let is_lit = irradiance.max_element() > 0.0 && scattered.max_element() > MIN_SCATTERED;
            self.contribution.set(lane, if is_lit { scattered * irradiance } else { Vec3::ZERO });
        }
    }
}
