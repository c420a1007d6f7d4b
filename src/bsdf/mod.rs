//! The glTF material model as lobes: how much light is scattered from one direction into another.
//!
//! Source: Khronos, "glTF 2.0 Specification", appendix B, with `KHR_materials_ior` and `KHR_materials_transmission`.
//! material = mix(dielectric, metal, metallic); dielectric = mix(mix(diffuse, transmission), specular, F(o·h)). Departures:
//! dielectrics follow the exact Fresnel curve, and albedos let through what the specular lobe as a whole leaves,
//! 1 − E(θ_o), so that no surface returns more than it receives.
//!
//! Directions are unit vectors in the local shading frame, +Z along the shading normal on the side of `wo`; both
//! point away from the surface. What a ray does behind the surface (absorption, which medium it is in) is not known here.

mod albedo;
mod fresnel;
mod ggx;
mod sampling;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::interaction::MaterialSample;
use fresnel::Dielectric;

/// Sharper lobes than this GGX α cannot be told from mirrors and would not fit floats.
const SHARPEST_ALPHA: f32 = 0.002;

/// The lobes of one material at one point, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    base_color: Vec3,
    metallic: f32,
    transmission: f32,
    roughness: f32,
    alpha: f32,
    thin: bool,
    dielectric: Dielectric,
}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where the light comes from.
    pub wi: Vec3,
    /// `f(wo, wi) · |cos θ_i| / pdf`.
    pub weight: Vec3,
    /// Density with respect to solid angle.
    pub pdf: f32,
}

/// What the lobes do with uniform light, seen along one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedos {
    /// [`Bsdf::specular_albedo`].
    pub specular: Vec3,
    /// [`Bsdf::diffuse_albedo`].
    pub diffuse: Vec3,
    /// [`Bsdf::transmission_albedo`].
    pub transmission: Vec3,
}

impl Bsdf {
    /// The lobes of `material`; `ior_outside` is the index of refraction on the side of `wo`, `ior_inside` on the other.
    /// An index of 0, in the material or either side, makes the Fresnel factor one everywhere.
    pub fn new(material: &MaterialSample, ior_outside: f32, ior_inside: f32) -> Self {
        let ior_inside = if material.ior == 0.0 { 0.0 } else { ior_inside };
        let roughness = material.roughness.clamp(0.0, 1.0);
        let alpha = roughness * roughness;
        Self {
            base_color: material.base_color,
            metallic: material.metallic.clamp(0.0, 1.0),
            transmission: material.transmission.clamp(0.0, 1.0),
            roughness,
            alpha: if alpha > SHARPEST_ALPHA { alpha } else { SHARPEST_ALPHA },
            thin: material.thin,
            dielectric: Dielectric::between(ior_outside, ior_inside),
        }
    }

    /// f(wo, wi): scattered radiance by irradiance, without the cosine.
    ///
    /// On the side of `wo`: diffuse and specular reflection. On the other side: for thin walls the GGX lobe around the straight
    /// continuation; for the surface of a volume zero, because light reaches through it by refracted rays, and lamps by
    /// the straight shadow rays of the integrator, never by this lobe.
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return Vec3::ZERO;
        }
        let through = wi.z < 0.0;
        if through && !self.transmits_rough() {
            return Vec3::ZERO;
        }
        // A thin wall scatters through as it would reflect the direction on this side.
        let mirrored = Vec3::new(wi.x, wi.y, wi.z.abs());
        let half = (wo + mirrored).normalize_or(Vec3::Z);
        let facet_cosine = wo.dot(half);
        let dielectric = self.dielectric.reflectance(facet_cosine);
        let lobe = ggx::distribution(half, self.alpha) * ggx::visibility(wo.z, mirrored.z, self.alpha);
        let entering = self.base_color * ((1.0 - self.metallic) * (1.0 - dielectric));
        if through {
            return entering * (self.transmission * lobe);
        }
        let metal = fresnel::schlick(facet_cosine, self.base_color);
        let reflected = Vec3::splat(dielectric * (1.0 - self.metallic)) + metal * self.metallic;
        reflected * lobe + entering * ((1.0 - self.transmission) * FRAC_1_PI)
    }

    /// All albedos at once, which share a part.
    pub fn albedos(&self, cos_o: f32) -> Albedos {
        let dielectric = self.dielectric_albedo(cos_o);
        Albedos {
            specular: self.specular_with(cos_o, dielectric),
            diffuse: self.diffuse_with(dielectric),
            transmission: self.transmission_with(cos_o, dielectric),
        }
    }

    /// E(θ_o): share of uniform light that the specular lobe reflects; its Fresnel factor where the surface is smooth.
    pub fn specular_albedo(&self, cos_o: f32) -> Vec3 {
        self.specular_with(cos_o, self.dielectric_albedo(cos_o))
    }

    /// Share of uniform light that the diffuse lobe reflects: what the specular lobe leaves, times the base colour. Times
    /// irradiance over π it is the radiance sent out.
    pub fn diffuse_albedo(&self, cos_o: f32) -> Vec3 {
        self.diffuse_with(self.dielectric_albedo(cos_o))
    }

    /// Share of uniform light that passes through, base colour included: `transmission · (1 − F) · base colour` where the
    /// surface is smooth. Zero where [`Bsdf::refract`] finds no way.
    pub fn transmission_albedo(&self, cos_o: f32) -> Vec3 {
        self.transmission_with(cos_o, self.dielectric_albedo(cos_o))
    }

    fn specular_with(&self, cos_o: f32, dielectric_albedo: f32) -> Vec3 {
        let mut sum = Vec3::ZERO;
        if self.metallic < 1.0 {
            sum += Vec3::splat(dielectric_albedo * (1.0 - self.metallic));
        }
        if self.metallic > 0.0 {
            let (total, grazing) = albedo::schlick_terms(cos_o, self.roughness);
            let metal = self.base_color * total + (Vec3::ONE - self.base_color) * grazing;
            sum += metal * self.metallic;
        }
        sum
    }

    fn diffuse_with(&self, dielectric_albedo: f32) -> Vec3 {
        self.albedo_below(dielectric_albedo, (1.0 - self.metallic) * (1.0 - self.transmission))
    }

    fn transmission_with(&self, cos_o: f32, dielectric_albedo: f32) -> Vec3 {
        if !self.thin && self.refracted_cosine(cos_o).is_none() {
            return Vec3::ZERO;
        }
        self.albedo_below(dielectric_albedo, (1.0 - self.metallic) * self.transmission)
    }

    /// Where light seen along `wo` comes from on the other side, by Snell's law; straight on for thin walls. `None` at
    /// total internal reflection.
    pub fn refract(&self, wo: Vec3) -> Option<Vec3> {
        if self.thin {
            return Some(-wo);
        }
        let cosine = self.refracted_cosine(wo.z)?;
        let bend = 1.0 / self.dielectric.relative_ior;
        Some(Vec3::new(-wo.x * bend, -wo.y * bend, -cosine).normalize())
    }

    /// The cosine beyond the surface, or `None` at total internal reflection.
    fn refracted_cosine(&self, cosine: f32) -> Option<f32> {
        let sine_squared = 1.0 - cosine * cosine;
        let n_squared = self.dielectric.relative_ior * self.dielectric.relative_ior;
        let cosine_squared = 1.0 - sine_squared / n_squared;
        (cosine_squared > 0.0).then(|| cosine_squared.sqrt())
    }

    /// The specular lobe of the part that is no metal; not looked up where there is none.
    fn dielectric_albedo(&self, cos_o: f32) -> f32 {
        if self.metallic < 1.0 { albedo::dielectric(cos_o, self.roughness, &self.dielectric) } else { 1.0 }
    }

    fn albedo_below(&self, dielectric_albedo: f32, share: f32) -> Vec3 {
        if share == 0.0 {
            return Vec3::ZERO;
        }
        self.base_color * (share * (1.0 - dielectric_albedo))
    }

    /// Whether light is scattered through by a lobe, rather than by a refracted ray.
    fn transmits_rough(&self) -> bool {
        self.thin && self.transmission > 0.0 && self.metallic < 1.0
    }
}

#[cfg(test)]
mod tests;
