//! Sampling of all lobes of a material, and its density.
//!
//! A lobe is chosen by the luminance of its albedo, then a direction by the lobe: visible normals of GGX (Heitz 2018) for reflection
//! and for thin walls, the cosine for diffuse light, transmitted or not, and for sheen. Densities and weights are those of the whole
//! mixture, as in multiple importance sampling with one sample (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.4).

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::{Bsdf, BsdfSample, ggx};
use crate::color::luminance;

/// Probabilities of the lobes; they sum to 1.
struct LobeProbabilities {
    specular: f32,
    /// Diffuse reflection and sheen.
    diffuse: f32,
    /// Transmission lobe of thin walls.
    transmission: f32,
    diffuse_transmission: f32,
}

impl Bsdf {
    /// Samples `wi` with a density close to `f · |cos θ_i|`. `u_lobe` and `u` are uniform in the unit interval and square.
    /// `None` where nothing is scattered or the sample points below the surface; its value is zero.
    ///
    /// Light through the surface of a volume is not sampled: follow [`Bsdf::refract`] with weight [`Bsdf::transmission_albedo`].
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let probabilities = self.lobe_probabilities(wo)?;
        let wi = if u_lobe < probabilities.diffuse {
            cosine_direction(u)
        } else if u_lobe < probabilities.diffuse + probabilities.diffuse_transmission {
            -cosine_direction(u)
        } else {
            let through = u_lobe
                < probabilities.diffuse + probabilities.diffuse_transmission + probabilities.transmission;
            let lobe = if through { &self.transmission_lobe } else { &self.lobe };
            let half = lobe.visible_normal(wo, ggx::disk_point(u));
            let mirrored = half * (2.0 * wo.dot(half)) - wo;
            if mirrored.z <= 0.0 {
                return None;
            }
            if through { Vec3::new(mirrored.x, mirrored.y, -mirrored.z) } else { mirrored }
        };
        let pdf = self.mixture_pdf(&probabilities, wo, wi);
        let value = self.eval(wo, wi);
        if pdf <= 0.0 || value == Vec3::ZERO {
            return None;
        }
        Some(BsdfSample { wi, weight: value * (wi.z.abs() / pdf), pdf })
    }

    /// The density with which [`Bsdf::sample`] samples `wi`.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.lobe_probabilities(wo).map_or(0.0, |probabilities| self.mixture_pdf(&probabilities, wo, wi))
    }

    fn lobe_probabilities(&self, wo: Vec3) -> Option<LobeProbabilities> {
        if wo.z <= 0.0 {
            return None;
        }
        let albedos = self.albedos(wo);
        let specular = luminance(albedos.specular);
        let diffuse = luminance(albedos.diffuse + albedos.sheen);
        let transmission = if self.transmits_rough() { luminance(albedos.transmission) } else { 0.0 };
        let diffuse_transmission = luminance(albedos.diffuse_transmission);
        let total = specular + diffuse + transmission + diffuse_transmission;
        (total > 0.0).then(|| LobeProbabilities {
            specular: specular / total,
            diffuse: diffuse / total,
            transmission: transmission / total,
            diffuse_transmission: diffuse_transmission / total,
        })
    }

    fn mixture_pdf(&self, probabilities: &LobeProbabilities, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z == 0.0 {
            return 0.0;
        }
        let mirrored = Vec3::new(wi.x, wi.y, wi.z.abs());
        let half = (wo + mirrored).normalize_or(Vec3::Z);
        if wi.z < 0.0 {
            probabilities.transmission * self.transmission_lobe.reflection_pdf(wo, half)
                + probabilities.diffuse_transmission * -wi.z * FRAC_1_PI
        } else {
            probabilities.specular * self.lobe.reflection_pdf(wo, half)
                + probabilities.diffuse * wi.z * FRAC_1_PI
        }
    }
}

/// A direction with density cos θ / π.
fn cosine_direction(u: Vec2) -> Vec3 {
    let disk = ggx::disk_point(u);
    // 1 − |disk|² is 1 − u.x, which cannot be negative.
    Vec3::new(disk.x, disk.y, (1.0 - u.x).sqrt())
}
