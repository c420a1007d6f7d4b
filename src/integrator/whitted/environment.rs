//! Light from the environment that a surface sends back by lobes, without rays.

use glam::Vec3;

use super::Tracer;
use super::shading::{Shading, mirror_direction};
use crate::integrator::LightPass;

impl Tracer<'_, '_> {
    /// Diffuse light from all around, and what rough lobes see of it; unoccluded but for the occlusion map.
    pub(super) fn environment(&mut self, shading: &Shading<'_, '_>) {
        let environment = self.context.view.environment;
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
        let prefiltered_share = 1.0 - shading.traced_share;
        if prefiltered_share > 0.0 {
            radiance += self.prefiltered_reflection(shading) * prefiltered_share;
        }
        let prefiltered_share_transmitted = 1.0 - shading.traced_share_transmitted;
        if prefiltered_share_transmitted > 0.0 && albedos.transmission != Vec3::ZERO {
            let roughness = shading.bsdf.roughness_through();
            for (channels, bsdf) in shading.transmission_lobes() {
                let through = albedos.transmission * channels.mask();
                if through != Vec3::ZERO
                    && let Some(direction) = bsdf.refract(shading.wo)
                {
                    let direction = shading.world_from_local * direction;
                    radiance += through
                        * environment.prefiltered(direction, roughness)
                        * prefiltered_share_transmitted;
                }
            }
        }
        let part = shading.part.unwrap_or(LightPass::Environment);
        self.add(shading.state.sample, part, shading.weight_below * radiance * material.occlusion);
        if let Some(coat) = &shading.coat
            && coat.traced_share < 1.0
        {
            let seen = environment.prefiltered(coat.mirrored, coat.roughness);
            let weight = coat.albedo * (1.0 - coat.traced_share) * material.occlusion;
            self.add(shading.state.sample, part, shading.weight * seen * weight);
        }
    }

    /// What the specular lobe sees of the environment.
    fn prefiltered_reflection(&self, shading: &Shading<'_, '_>) -> Vec3 {
        let (environment, roughness) = (self.context.view.environment, shading.material.roughness);
        if shading.material.anisotropy.is_none() {
            let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
            return shading.albedos.specular * environment.prefiltered(mirrored, roughness);
        }
        let (mut seen, mut shares) = (Vec3::ZERO, Vec3::ZERO);
        for (wi, share) in shading.bsdf.anisotropic_reflections(shading.wo) {
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
