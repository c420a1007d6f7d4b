//! Light of the environment that a surface scatters, by lookups instead of rays.

use glam::Vec3;

use super::local_frame::mirror_direction;
use super::shading::Shading;
use super::tracer::Tracer;
use crate::integrator::LightPass;

impl Tracer<'_, '_> {
    /// Adds diffuse light of the environment and the prefiltered share of rough lobes. Nothing but the occlusion map occludes it.
    pub(super) fn add_environment_light(&mut self, shading: &Shading<'_, '_>) {
        let environment = self.context.view.environment;
        let Shading { point, material, albedos, .. } = shading;

        // Diffuse lobes and sheen
        let normal = point.shading_normal;
        let mut diffuse = Vec3::ZERO;
        if albedos.diffuse != Vec3::ZERO {
            diffuse += albedos.diffuse * environment.irradiance(normal);
        }
        if albedos.sheen != Vec3::ZERO {
            diffuse += albedos.sheen * environment.irradiance(normal);
        }
        if albedos.diffuse_transmission != Vec3::ZERO {
            diffuse += albedos.diffuse_transmission * environment.irradiance(-normal);
        }
        let mut radiance = diffuse * std::f32::consts::FRAC_1_PI;

        // Specular lobes
        let prefiltered_share = 1.0 - shading.traced_share;
        if prefiltered_share > 0.0 {
            radiance += self.prefiltered_reflection(shading) * prefiltered_share;
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
                    radiance += albedo * environment.prefiltered(direction, roughness) * prefiltered_share;
                }
            }
        }
        let light_pass = shading.light_pass.unwrap_or(LightPass::Environment);
        self.add(shading.state.sample, light_pass, shading.weight_below * radiance * material.occlusion);

        // Coat
        if let Some(coat) = &shading.coat
            && coat.traced_share < 1.0
        {
            let seen = environment.prefiltered(coat.mirrored, coat.roughness);
            let weight = coat.albedo * (1.0 - coat.traced_share) * material.occlusion;
            self.add(shading.state.sample, light_pass, shading.weight * seen * weight);
        }
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
