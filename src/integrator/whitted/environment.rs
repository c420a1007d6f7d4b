//! Light of the environment that a surface scatters, by lookups instead of rays. [`super::environment_shadows`] finds what occludes it.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::environment_lookup::{EnvironmentLookup, EnvironmentLookups, LookupLobe};
use super::shading::Shading;
use crate::bsdf::Bsdf;
use crate::integrator::local_frame::mirror_direction;
use crate::integrator::prefiltered_lobe::{PrefilteredLobe, RoughLobe, has_broad_part};
use crate::integrator::tracing::Tracer;
use crate::interaction::is_opaque_at;
use crate::scene::KeyLight;

impl Tracer<'_, '_> {
    /// Adds diffuse light of the environment and the prefiltered share of rough lobes.
    pub(super) fn add_environment_light(&mut self, shading: &Shading<'_, '_>) {
        let occlusion = self.context.untraced_occlusion(shading.material.occlusion);
        let reached = shading.weight_below * occlusion;
        let mut lookups = EnvironmentLookups::new();
        self.look_up_diffuse(shading, reached, &mut lookups);
        self.look_up_specular(shading, reached, &mut lookups);
        self.look_up_transmitted(shading, reached, &mut lookups);
        if let Some(coat) = &shading.coat
            && coat.traced_share < 1.0
        {
            let PrefilteredLobe { direction, roughness } = coat.looked_up;
            let seen = self.context.lookups.prefiltered(shading.point.position, direction, roughness);
            let albedo = shading.weight * (coat.albedo * (1.0 - coat.traced_share) * occlusion);
            let lobe = LookupLobe::Glossy(coat.looked_up);
            lookups.push(EnvironmentLookup { radiance: albedo * seen, albedo, lobe, is_outside: true });
        }
        self.add_lookups(shading, &mut lookups);
    }

    /// Diffuse lobes, sheen, and the broad part of the reflected specular lobe. `reached` multiplies light that leaves from below the coat.
    fn look_up_diffuse(&self, shading: &Shading<'_, '_>, reached: Vec3, lookups: &mut EnvironmentLookups) {
        let environment = &self.context.lookups;
        let Shading { point, albedos, .. } = shading;
        let normal = point.shading_normal;
        let broad = prefiltered_albedo(shading) * broad_share(shading);
        for (diffuse, broad, normal, is_outside) in [
            (albedos.diffuse + albedos.sheen, broad, normal, true),
            (albedos.diffuse_transmission, Vec3::ZERO, -normal, false),
        ] {
            if diffuse + broad != Vec3::ZERO && (is_outside || !self.is_covered(shading)) {
                let (diffuse, broad) = (reached * diffuse, reached * broad);
                let block = &self.whitted.block_lookups;
                let mean = || {
                    let looked_up = block.irradiance(shading.index).filter(|_| is_outside);
                    looked_up.unwrap_or_else(|| environment.irradiance(point.position, normal)) * FRAC_1_PI
                };
                let radiance = if shading.material.metallic > 0.0 && broad != Vec3::ZERO {
                    let looked_up = block.broad(shading.index);
                    let of_lobe = broad
                        * looked_up
                            .unwrap_or_else(|| environment.prefiltered(shading.point.position, normal, 1.0));
                    if diffuse == Vec3::ZERO { of_lobe } else { diffuse * mean() + of_lobe }
                } else {
                    // Irradiance stands for the broad part of the faint lobes of dielectrics.
                    let mean = mean();
                    diffuse * mean + broad * mean
                };
                lookups.push(EnvironmentLookup {
                    radiance,
                    albedo: diffuse + broad,
                    lobe: LookupLobe::Diffuse { normal },
                    is_outside,
                });
            }
        }
    }

    /// Whether an opaque surface touches this one from behind.
    fn is_covered(&self, shading: &Shading<'_, '_>) -> bool {
        let touching = shading.transmission_side.touching.as_deref();
        touching.is_some_and(|touching| is_opaque_at(self.context.view, &touching.hit))
    }

    /// The narrow part of the reflected specular lobe.
    fn look_up_specular(
        &mut self,
        shading: &Shading<'_, '_>,
        reached: Vec3,
        lookups: &mut EnvironmentLookups,
    ) {
        let albedo = reached * (prefiltered_albedo(shading) * (1.0 - broad_share(shading)));
        if albedo == Vec3::ZERO {
            return;
        }
        let (seen, lobe) = self.prefiltered_reflection(shading);
        lookups.push(EnvironmentLookup { radiance: albedo * seen, albedo, lobe, is_outside: true });
    }

    /// Transmitted specular lobes that no sampled ray follows.
    fn look_up_transmitted(
        &mut self,
        shading: &Shading<'_, '_>,
        reached: Vec3,
        lookups: &mut EnvironmentLookups,
    ) {
        let (environment, albedos) = (&self.context.lookups, &shading.albedos);
        let prefiltered_share = 1.0 - shading.traced_share_transmitted;
        if shading.follows_transmission || prefiltered_share == 0.0 || albedos.transmission == Vec3::ZERO {
            return;
        }
        for (channels, bsdf) in shading.transmission_lobes() {
            let albedo = albedos.transmission * channels.mask();
            let Some(lobe) = transmitted_lobe(shading, bsdf).filter(|_| albedo != Vec3::ZERO) else {
                continue;
            };
            let mut seen = environment.prefiltered(shading.point.position, lobe.direction, lobe.roughness);
            if self.transmits_peaks(shading) {
                seen += self.peaks_in_lobe(lobe);
            }
            let albedo = reached * (albedo * prefiltered_share);
            let radiance = albedo * seen;
            lookups.push(EnvironmentLookup {
                radiance,
                albedo,
                lobe: LookupLobe::Glossy(lobe),
                is_outside: false,
            });
        }
    }

    /// Light of the environment's peaks in the lobe of a prefiltered lookup: for a view along the normal.
    pub(super) fn peaks_in_lobe(&self, lobe: PrefilteredLobe) -> Vec3 {
        let seen = |peak: &KeyLight| peak.irradiance * lobe.density(peak.direction_to_light);
        self.context.peaks.iter().map(seen).sum()
    }

    /// Prefiltered radiance of the specular lobe, and the lobe.
    fn prefiltered_reflection(&self, shading: &Shading<'_, '_>) -> (Vec3, LookupLobe) {
        if let Some((seen, lobe)) = self.whitted.block_lookups.reflection(shading.index) {
            return (seen, LookupLobe::Glossy(lobe));
        }
        let (environment, roughness) = (&self.context.lookups, shading.material.roughness);
        let normal = shading.point.shading_normal;
        let mirrored = mirror_direction(shading.point.wo, normal);
        if shading.material.anisotropy.is_none() {
            let lobe = RoughLobe::of(shading.material, (mirrored, normal), shading.wo.z).narrow;
            return (
                environment.prefiltered(shading.point.position, lobe.direction, lobe.roughness),
                LookupLobe::Glossy(lobe),
            );
        }
        // Shadow rays follow one lobe as wide as the widest.
        let lobe = PrefilteredLobe::new(mirrored, normal, shading.wo.z, shading.bsdf.widest_roughness());
        if environment.is_uniform() {
            return (
                environment.prefiltered(shading.point.position, lobe.direction, lobe.roughness),
                LookupLobe::Glossy(lobe),
            );
        }
        let (mut seen, mut shares) = (Vec3::ZERO, Vec3::ZERO);
        for (wi, share) in shading.bsdf.anisotropic_reflections(shading.wo, shading.terms) {
            seen += share
                * environment.prefiltered(shading.point.position, shading.world_from_local * wi, roughness);
            shares += share;
        }
        // The mean over the directions; the albedo of the lobe is exact.
        let mean = |seen: f32, shares: f32| if shares > 0.0 { seen / shares } else { 0.0 };
        let seen = Vec3::new(mean(seen.x, shares.x), mean(seen.y, shares.y), mean(seen.z, shares.z));
        (seen, LookupLobe::Glossy(lobe))
    }
}

/// Albedo of the reflected specular lobe as far as it is looked up.
fn prefiltered_albedo(shading: &Shading<'_, '_>) -> Vec3 {
    // Facets follow the rest.
    shading.albedos.specular * ((1.0 - shading.traced_share) * (1.0 - shading.facet_share))
}

/// Share of that light that is looked up with diffuse light. Anisotropic lobes are looked up in several directions of their own.
fn broad_share(shading: &Shading<'_, '_>) -> f32 {
    let material = shading.material;
    if material.anisotropy.is_none() && has_broad_part(material) {
        RoughLobe::broad_share(material.roughness.clamp(0.0, 1.0))
    } else {
        0.0
    }
}

/// The prefiltered lobe that stands for the light of the other side of a surface; `None` where it reflects totally.
pub(super) fn transmitted_lobe(shading: &Shading<'_, '_>, bsdf: &Bsdf) -> Option<PrefilteredLobe> {
    let through = shading.world_from_local * bsdf.refract(shading.wo)?;
    let roughness = shading.bsdf.transmission_roughness();
    // The lobe of a thin wall is that of a reflection, turned to the other side.
    Some(if shading.material.thin {
        PrefilteredLobe::new(through, -shading.point.shading_normal, shading.wo.z, roughness)
    } else {
        PrefilteredLobe { direction: through, roughness }
    })
}
