//! The environment at the points of a block whose surfaces are shaded one by one: the lookups that most of them need, in lanes.

use glam::Vec3;

use super::traced_share::traced_share;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec3Lanes, vectorized};
use crate::integrator::IntegratorContext;
use crate::integrator::local_frame::mirror_direction;
use crate::integrator::prefiltered_lobe::{PrefilteredLobe, RoughLobe, has_broad_part};
use crate::interaction::{MaterialSample, SurfaceBlock};
use crate::scene::LookupLanes;

/// Irradiance and prefiltered radiance at the points of a block.
#[derive(Debug, Default)]
pub(super) struct BlockLookups {
    /// Lanes with a lookup along the shading normal.
    diffuse: ActiveLanes,
    /// Those of them that need the irradiance: all but metals without sheen.
    irradiated: ActiveLanes,
    irradiance: Vec3Lanes,
    /// Lanes with a lobe.
    specular: ActiveLanes,
    /// Those of them that are metallic.
    metallic: ActiveLanes,
    broad: Vec3Lanes,
    lobe_direction: Vec3Lanes,
    lobe_roughness: F32Lanes,
    prefiltered: Vec3Lanes,
}

impl BlockLookups {
    /// Looks up what the reflection of the surfaces with these materials is likely to need. Anisotropic lobes look up several directions
    /// and are left out, as are lobes that rays follow.
    pub(super) fn fill(
        &mut self,
        context: &IntegratorContext<'_>,
        block: &SurfaceBlock<'_>,
        materials: &[MaterialSample],
    ) {
        let (environment, positions) = (&context.lookups, block.positions());
        (self.diffuse, self.irradiated, self.specular, self.metallic) = Default::default();
        if environment.is_uniform() {
            return;
        }
        let level = context.view.bvh.simd_level();
        let lanes = ActiveLanes::first(materials.len());
        let reflects_diffusely = |material: &MaterialSample| {
            material.sheen.is_some() || (material.metallic < 1.0 && material.transmission < 1.0)
        };
        let normals = block.normals();
        let looks_up = |material: &MaterialSample| {
            context.settings.glossy_samples == 0
                && material.anisotropy.is_none()
                && traced_share(material.roughness) < 1.0
        };
        self.diffuse = lanes.filtered(|lane| {
            let material = &materials[lane];
            !material.unlit
                && (reflects_diffusely(material) || (looks_up(material) && has_broad_part(material)))
        });
        self.irradiated = self.diffuse.filtered(|lane| {
            let material = &materials[lane];
            material.metallic <= 0.0 || reflects_diffusely(material)
        });
        if !self.irradiated.is_empty() {
            let lookups = LookupLanes { level, directions: normals, lanes: self.irradiated };
            environment.irradiances(positions, &lookups, &mut self.irradiance);
        }

        self.specular = lanes.filtered(|lane| !materials[lane].unlit && looks_up(&materials[lane]));
        if self.specular.is_empty() {
            return;
        }
        let viewers = block.viewers();
        let Self { lobe_direction, lobe_roughness, .. } = self;
        vectorized!(level, {
            for (lane, material) in materials.iter().enumerate() {
                let (normal, wo) = (normals.get(lane), viewers.get(lane));
                let directions = (mirror_direction(wo, normal), normal);
                let lobe = RoughLobe::of(material, directions, normal.dot(wo)).narrow;
                lobe_direction.set(lane, lobe.direction);
                lobe_roughness[lane] = lobe.roughness;
            }
        });
        let lookups = LookupLanes { level, directions: &self.lobe_direction, lanes: self.specular };
        environment.prefiltered_lanes(positions, &lookups, &self.lobe_roughness, &mut self.prefiltered);
        self.metallic = self.specular.filtered(|lane| materials[lane].metallic > 0.0);
        if !self.metallic.is_empty() {
            let lookups = LookupLanes { level, directions: normals, lanes: self.metallic };
            environment.prefiltered_lanes(positions, &lookups, &[1.0; LANES], &mut self.broad);
        }
    }

    /// The lanes with a lookup along the shading normal.
    pub(super) fn diffuse(&self) -> ActiveLanes {
        self.diffuse
    }

    /// Whether any surface was looked up for.
    pub(super) fn is_empty(&self) -> bool {
        self.diffuse.is_empty() && self.specular.is_empty()
    }

    /// The irradiance along the shading normal of a surface, where it was looked up.
    pub(super) fn irradiance(&self, lane: usize) -> Option<Vec3> {
        self.irradiated.contains(lane).then(|| self.irradiance.get(lane))
    }

    /// The prefiltered radiance of roughness 1 along the shading normal of a metallic surface, where it was looked up.
    pub(super) fn broad(&self, lane: usize) -> Option<Vec3> {
        self.metallic.contains(lane).then(|| self.broad.get(lane))
    }

    /// The prefiltered radiance of the reflection of a surface and its lobe, where it was looked up.
    pub(super) fn reflection(&self, lane: usize) -> Option<(Vec3, PrefilteredLobe)> {
        let lobe = || PrefilteredLobe {
            direction: self.lobe_direction.get(lane),
            roughness: self.lobe_roughness[lane],
        };
        self.specular.contains(lane).then(|| (self.prefiltered.get(lane), lobe()))
    }
}
