//! What the surface of an occluder reflects of an environment: a flat metal, or a diffuse one, of the material's base.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::bsdf::metallic_albedo;
use crate::bvh::Hit;
use crate::color::luminance;
use crate::integrator::IntegratorContext;
use crate::integrator::local_frame::mirror_direction;
use crate::integrator::prefiltered_lobe::RoughLobe;
use crate::interaction::{BlurredMaterial, SurfacePoint};

/// Metallic occluders are at least as rough: what lobes sharper than that light would be white dots.
const MIN_ROUGHNESS: f32 = 0.5;

/// The surface of an occluder as its light's receiver: a diffuse part, and a metallic one.
pub(super) struct OccluderSurface {
    position: Vec3,
    pub(super) normal: Vec3,
    /// Albedo of the diffuse part.
    diffuse: Vec3,
    metallic: Option<MetallicPart>,
}

/// The lobe of a metal towards the lookup, with its directional albedo.
struct MetallicPart {
    albedo: Vec3,
    lobe: RoughLobe,
}

/// Light of one of the environment's own lights, as an occluder reflects it.
pub(super) struct ReflectedKey {
    /// Radiance without shadows by one of the lights, over its probability.
    pub(super) radiance: Vec3,
    /// Direction to the light.
    pub(super) wi: Vec3,
}

impl OccluderSurface {
    pub(super) fn new(context: &IntegratorContext<'_>, point: &SurfacePoint<'_>, hit: &Hit) -> Self {
        let BlurredMaterial { color, metallic, roughness } = BlurredMaterial::at(context.view, hit);
        let (color, metallic) = (color.clamp(Vec3::ZERO, Vec3::ONE), metallic.clamp(0.0, 1.0));
        let normal = point.geometric_normal;
        let metal = || {
            let mirrored = mirror_direction(point.wo, normal);
            let (cos_o, roughness) = (point.wo.dot(normal), roughness.clamp(0.0, 1.0));
            MetallicPart {
                albedo: metallic_albedo(color, cos_o, roughness) * metallic,
                lobe: RoughLobe::new(mirrored, normal, cos_o, roughness.max(MIN_ROUGHNESS)),
            }
        };
        Self {
            position: point.position,
            normal,
            diffuse: color * (1.0 - metallic),
            metallic: (metallic > 0.0).then(metal),
        }
    }

    pub(super) fn albedo(&self) -> Vec3 {
        self.diffuse + self.metallic.as_ref().map_or(Vec3::ZERO, |part| part.albedo)
    }

    /// The radiance that it reflects of the environment without shadows, and a direction from which that light comes: of the narrow lobe or of the rest, by the
    /// share of the luminance, which `part` in [0, 1) decides.
    pub(super) fn reflected_environment(
        &self,
        context: &IntegratorContext<'_>,
        part: f32,
        direction: (Vec2, f32),
    ) -> (Vec3, Vec3) {
        let environment = &context.lookups;
        let mut radiance = if self.diffuse == Vec3::ZERO {
            Vec3::ZERO
        } else {
            self.diffuse * environment.irradiance(self.position, self.normal) * FRAC_1_PI
        };
        let mut narrow_part = None;
        if let Some(MetallicPart { albedo, lobe: RoughLobe { narrow, broad_share } }) = &self.metallic {
            radiance += *albedo * *broad_share * environment.prefiltered(self.position, self.normal, 1.0);
            if *broad_share < 1.0 {
                let seen = environment.prefiltered(self.position, narrow.direction, narrow.roughness);
                let seen = *albedo * (1.0 - broad_share) * seen;
                radiance += seen;
                narrow_part = Some((narrow, seen));
            }
        }
        // The direction is one of the narrow lobe where that is the chosen part.
        let chosen = narrow_part.filter(|(_, seen)| part * luminance(radiance) < luminance(*seen));
        let sampled =
            context.environment_directions.as_ref().map_or(self.normal, |directions| match chosen {
                Some((lobe, _)) => directions.glossy(lobe.direction, lobe.roughness, direction),
                None => directions.diffuse(self.normal, direction),
            });
        (radiance, sampled)
    }

    /// Radiance for irradiance 1 of a surface that faces the light.
    fn scattered(&self, wi: Vec3) -> Vec3 {
        let cosine_density = wi.dot(self.normal) * FRAC_1_PI;
        let Some(MetallicPart { albedo, lobe: RoughLobe { narrow, broad_share } }) = &self.metallic else {
            return self.diffuse * cosine_density;
        };
        let broad = (self.diffuse + albedo * broad_share) * cosine_density;
        broad + albedo * ((1.0 - broad_share) * narrow.density(wi))
    }
}

impl ReflectedKey {
    /// One of the lights on a surface, chosen by luminance; `None` if none faces it. `u` is a random number in [0, 1).
    pub(super) fn new(context: &IntegratorContext<'_>, surface: &OccluderSurface, u: f32) -> Option<Self> {
        let lights = || {
            let lights = context.environment_lights().iter();
            lights
                .filter_map(|light| light.incidence(surface.position))
                .filter(|incidence| incidence.wi.dot(surface.normal) > 0.0)
                .map(|incidence| (incidence.irradiance * surface.scattered(incidence.wi), incidence.wi))
        };
        let sum: f32 = lights().map(|(radiance, _)| luminance(radiance)).sum();
        let mut left = u * sum;
        let (radiance, wi) = lights().find(|(radiance, _)| {
            left -= luminance(*radiance);
            left < 0.0
        })?;
        Some(Self { radiance: radiance * (sum / luminance(radiance)), wi })
    }
}
