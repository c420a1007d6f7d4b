//! Light of the environment that a surface scatters, by lookups instead of rays. [`super::environment_shadows`] finds what occludes it.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::environment_shadows::{EnvironmentLookup, EnvironmentLookups, LookupLobe};
use super::local_frame::mirror_direction;
use super::shading::Shading;
use super::tracer::Tracer;
use crate::scene::KeyLight;

/// Least square of the lobe's width, so that narrow lobes stay finite.
const MIN_ALPHA_SQUARED: f32 = 1e-6;

impl Tracer<'_, '_> {
    /// Adds diffuse light of the environment and the prefiltered share of rough lobes.
    pub(super) fn add_environment_light(&mut self, shading: &Shading<'_, '_>) {
        let occlusion = self.context.untraced_occlusion(shading.material.occlusion);
        let reached = shading.weight_below * occlusion;
        let mut lookups = EnvironmentLookups::new();
        self.look_up_diffuse(shading, reached, &mut lookups);
        self.look_up_specular(shading, reached, &mut lookups);
        if let Some(coat) = &shading.coat
            && coat.traced_share < 1.0
        {
            let seen = self.context.view.environment.prefiltered(coat.mirrored, coat.roughness);
            let weight = shading.weight * (coat.albedo * (1.0 - coat.traced_share) * occlusion);
            let lobe = LookupLobe::Glossy { direction: coat.mirrored, roughness: coat.roughness };
            lookups.push(EnvironmentLookup { radiance: weight * seen, lobe, is_outside: true });
        }
        let media = &shading.transmission_side.media;
        self.add_lookups(&shading.arrival(), media, &mut lookups, shading.material.base_color);
    }

    /// Diffuse lobes and sheen. `reached` multiplies light that leaves from below the coat.
    fn look_up_diffuse(&self, shading: &Shading<'_, '_>, reached: Vec3, lookups: &mut EnvironmentLookups) {
        let environment = self.context.view.environment;
        let Shading { point, albedos, .. } = shading;
        let normal = point.shading_normal;
        for (albedo, normal, is_outside) in
            [(albedos.diffuse + albedos.sheen, normal, true), (albedos.diffuse_transmission, -normal, false)]
        {
            if albedo != Vec3::ZERO {
                let radiance = reached * (albedo * environment.irradiance(normal) * FRAC_1_PI);
                lookups.push(EnvironmentLookup {
                    radiance,
                    lobe: LookupLobe::Diffuse { normal },
                    is_outside,
                });
            }
        }
    }

    /// Reflected and transmitted specular lobes.
    fn look_up_specular(&self, shading: &Shading<'_, '_>, reached: Vec3, lookups: &mut EnvironmentLookups) {
        let environment = self.context.view.environment;
        let Shading { point, albedos, .. } = shading;
        let prefiltered_share = 1.0 - shading.traced_share;
        if prefiltered_share > 0.0 {
            let radiance = reached * (self.prefiltered_reflection(shading) * prefiltered_share);
            let direction = mirror_direction(point.wo, point.shading_normal);
            // One lobe as wide as the widest stands for an anisotropic one.
            let is_anisotropic = shading.material.anisotropy.is_some();
            let roughness =
                if is_anisotropic { shading.bsdf.widest_roughness() } else { shading.material.roughness };
            let lobe = LookupLobe::Glossy { direction, roughness };
            lookups.push(EnvironmentLookup { radiance, lobe, is_outside: true });
        }
        let prefiltered_share = 1.0 - shading.traced_share_transmitted;
        if prefiltered_share > 0.0 && albedos.transmission != Vec3::ZERO {
            let roughness = shading.bsdf.transmission_roughness();
            for (channels, bsdf) in shading.transmission_lobes() {
                let albedo = albedos.transmission * channels.mask();
                if albedo != Vec3::ZERO
                    && let Some(direction) = bsdf.refract(shading.wo)
                {
                    let direction = shading.world_from_local * direction;
                    let mut seen = environment.prefiltered(direction, roughness);
                    // Thin walls show the peaks as highlights, volumes do not.
                    if !shading.material.thin {
                        seen += self.peaks_in_lobe(direction, roughness);
                    }
                    let radiance = reached * (albedo * seen * prefiltered_share);
                    let lobe = LookupLobe::Glossy { direction, roughness };
                    lookups.push(EnvironmentLookup { radiance, lobe, is_outside: false });
                }
            }
        }
    }

    /// Light of the environment's peaks in the lobe of a prefiltered lookup: GGX around `direction`, for a view along the normal.
    fn peaks_in_lobe(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let alpha = roughness * roughness;
        let alpha_squared = (alpha * alpha).max(MIN_ALPHA_SQUARED);
        let seen = |peak: &KeyLight| {
            // The half vector's cosine with both directions
            let cosine_squared = (1.0 + direction.dot(peak.direction_to_light)) * 0.5;
            let denominator = 1.0 - cosine_squared * (1.0 - alpha_squared);
            // The density of mirrored directions is a quarter of that of normals.
            peak.irradiance * (alpha_squared * FRAC_1_PI * 0.25 / (denominator * denominator))
        };
        self.context.peaks.iter().map(seen).sum()
    }

    /// Prefiltered radiance of the specular lobe.
    fn prefiltered_reflection(&self, shading: &Shading<'_, '_>) -> Vec3 {
        let (environment, roughness) = (self.context.view.environment, shading.material.roughness);
        if shading.material.anisotropy.is_none() {
            let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
            return shading.albedos.specular * environment.prefiltered(mirrored, roughness);
        }
        let (mut seen, mut shares) = (Vec3::ZERO, Vec3::ZERO);
        for (wi, share) in shading.bsdf.anisotropic_reflections(shading.wo, shading.terms) {
            seen += share * environment.prefiltered(shading.world_from_local * wi, roughness);
            shares += share;
        }
        // The mean over the directions, times the exact albedo of the lobe
        let scale = |albedo: f32, shares: f32| if shares > 0.0 { albedo / shares } else { 0.0 };
        let specular = shading.albedos.specular;
        seen * Vec3::new(
            scale(specular.x, shares.x),
            scale(specular.y, shares.y),
            scale(specular.z, shares.z),
        )
    }
}
