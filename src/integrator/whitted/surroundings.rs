//! Light from the environment that a surface sends back by lobes, without rays.

use glam::Vec3;

use super::Tracer;
use super::shade::{Shading, mirror_direction};
use crate::integrator::LightPass;

impl Tracer<'_, '_> {
    /// Diffuse light from all around, and what rough lobes see of it; unoccluded but for the occlusion map.
    pub(super) fn environment(&mut self, shading: &Shading<'_, '_>) {
        let environment = self.world.environment;
        let Shading { point, material, albedos, .. } = shading;
        let normal = point.shading_normal;
        let mut diffuse = albedos.diffuse * environment.irradiance(normal);
        if albedos.sheen != Vec3::ZERO {
            diffuse += albedos.sheen * environment.irradiance(normal);
        }
        if albedos.diffuse_transmission != Vec3::ZERO {
            diffuse += albedos.diffuse_transmission * environment.irradiance(-normal);
        }
        let mut radiance = diffuse * std::f32::consts::FRAC_1_PI;
        let dull = 1.0 - shading.sharpness;
        if dull > 0.0 {
            radiance += self.dull_reflection(shading) * dull;
        }
        let dull_through = 1.0 - shading.sharpness_through;
        if dull_through > 0.0 && albedos.transmission != Vec3::ZERO {
            let roughness = shading.bsdf.roughness_through();
            for (spectrum, bsdf) in shading.ways_through() {
                let through = albedos.transmission * spectrum.mask();
                if through != Vec3::ZERO
                    && let Some(direction) = bsdf.refract(shading.wo)
                {
                    let direction = shading.world_from_local * direction;
                    radiance += through * environment.prefiltered(direction, roughness) * dull_through;
                }
            }
        }
        let part = shading.part.unwrap_or(LightPass::Environment);
        self.add(shading.path.sample, part, shading.weight_below * radiance * material.occlusion);
        if let Some(coat) = &shading.coat
            && coat.sharpness < 1.0
        {
            let seen = environment.prefiltered(coat.mirrored, coat.roughness);
            let weight = coat.albedo * (1.0 - coat.sharpness) * material.occlusion;
            self.add(shading.path.sample, part, shading.weight * seen * weight);
        }
    }

    /// What the specular lobe sees of the environment.
    fn dull_reflection(&self, shading: &Shading<'_, '_>) -> Vec3 {
        let (environment, roughness) = (self.world.environment, shading.material.roughness);
        if shading.material.anisotropy.is_none() {
            let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
            return shading.albedos.specular * environment.prefiltered(mirrored, roughness);
        }
        let (mut seen, mut shares) = (Vec3::ZERO, Vec3::ZERO);
        for (wi, share) in shading.bsdf.stretched_reflections(shading.wo) {
            seen += share * environment.prefiltered(shading.world_from_local * wi, roughness);
            shares += share;
        }
        // The mean of what is seen, by the lobe's exact albedo
        let scale = |albedo: f32, shares: f32| if shares > 0.0 { albedo / shares } else { 0.0 };
        let specular = shading.albedos.specular;
        seen * Vec3::new(
            scale(specular.x, shares.x),
            scale(specular.y, shares.y),
            scale(specular.z, shares.z),
        )
    }
}
