//! Drawing directions from a material's lobes, and the density with which that happens.
//!
//! One lobe is chosen by its albedo's luminance, then a direction by the lobe: visible normals of GGX (Heitz 2018) for
//! reflection and for thin walls, cosine for diffuse light, transmitted or not, and for fibres. Densities and weights are those of the whole mixture, as for multiple
//! importance sampling with one sample (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.4).

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::{Bsdf, BsdfSample, ggx};
use crate::color::luminance;

/// Probabilities of the lobes; they sum to one.
struct LobeChoice {
    specular: f32,
    /// Diffuse light and that of fibres.
    diffuse: f32,
    through: f32,
    diffusely_through: f32,
}

impl Bsdf {
    /// Draws `wi` with a density close to `f · |cos θ_i|`. `u_lobe` and `u` are uniform in the unit interval and square.
    /// `None` when nothing is scattered or the draw points below the surface; count it as zero.
    ///
    /// Light through the surface of a volume is not drawn: follow [`Bsdf::refract`] with [`Bsdf::transmission_albedo`].
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let choice = self.lobe_choice(wo)?;
        let wi = if u_lobe < choice.diffuse {
            cosine_direction(u)
        } else if u_lobe < choice.diffuse + choice.diffusely_through {
            -cosine_direction(u)
        } else {
            let through = u_lobe < choice.diffuse + choice.diffusely_through + choice.through;
            let lobe = if through { &self.lobe_through } else { &self.lobe };
            let half = lobe.visible_normal(wo, ggx::disk_point(u));
            let mirrored = half * (2.0 * wo.dot(half)) - wo;
            if mirrored.z <= 0.0 {
                return None;
            }
            if through { Vec3::new(mirrored.x, mirrored.y, -mirrored.z) } else { mirrored }
        };
        let pdf = self.mixture_pdf(&choice, wo, wi);
        let value = self.eval(wo, wi);
        if pdf <= 0.0 || value == Vec3::ZERO {
            return None;
        }
        Some(BsdfSample { wi, weight: value * (wi.z.abs() / pdf), pdf })
    }

    /// The density with which [`Bsdf::sample`] draws `wi`.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.lobe_choice(wo).map_or(0.0, |choice| self.mixture_pdf(&choice, wo, wi))
    }

    fn lobe_choice(&self, wo: Vec3) -> Option<LobeChoice> {
        if wo.z <= 0.0 {
            return None;
        }
        let albedos = self.albedos(wo);
        let specular = luminance(albedos.specular);
        let diffuse = luminance(albedos.diffuse + albedos.sheen);
        let through = if self.transmits_rough() { luminance(albedos.transmission) } else { 0.0 };
        let diffusely_through = luminance(albedos.diffuse_transmission);
        let total = specular + diffuse + through + diffusely_through;
        (total > 0.0).then(|| LobeChoice {
            specular: specular / total,
            diffuse: diffuse / total,
            through: through / total,
            diffusely_through: diffusely_through / total,
        })
    }

    fn mixture_pdf(&self, choice: &LobeChoice, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z == 0.0 {
            return 0.0;
        }
        let mirrored = Vec3::new(wi.x, wi.y, wi.z.abs());
        let half = (wo + mirrored).normalize_or(Vec3::Z);
        if wi.z < 0.0 {
            choice.through * self.lobe_through.reflection_pdf(wo, half)
                + choice.diffusely_through * -wi.z * FRAC_1_PI
        } else {
            choice.specular * self.lobe.reflection_pdf(wo, half) + choice.diffuse * wi.z * FRAC_1_PI
        }
    }
}

/// A direction with density cos θ / π.
fn cosine_direction(u: Vec2) -> Vec3 {
    let disk = ggx::disk_point(u);
    // 1 − |disk|² is 1 − u.x, which cannot be negative.
    Vec3::new(disk.x, disk.y, (1.0 - u.x).sqrt())
}
