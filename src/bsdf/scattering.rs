//! Temporary.
use super::{Albedos, Bsdf, Coat};
use glam::{Mat3, Vec2, Vec3};

pub struct Scattering {
    bsdf: Bsdf,
    albedos: Albedos,
    wo: Vec3,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScatterLobe {
    SpecularReflection,
    Diffuse,
    Transmission,
    DiffuseTransmission,
}
#[derive(Clone, Copy, Debug)]
pub struct ScatterSample {
    pub wi: Vec3,
    pub weight: Vec3,
    pub pdf: f32,
    pub lobe: ScatterLobe,
    pub is_smooth: bool,
    pub is_unbent: bool,
}
impl Scattering {
    pub fn new(bsdf: Bsdf, wo: Vec3, _coat: Option<(Coat, Mat3)>) -> Self {
        Self { bsdf, albedos: bsdf.albedos(wo), wo }
    }
    pub fn eval(&self, wi: Vec3) -> Vec3 {
        if self.bsdf.is_smooth() {
            if wi.z > 0.0 { self.albedos.diffuse * wi.z * std::f32::consts::FRAC_1_PI } else { Vec3::ZERO }
        } else {
            self.bsdf.eval(self.wo, wi) * wi.z.abs()
        }
    }
    pub fn eval_with_smooth(&self, wi: Vec3) -> Vec3 {
        self.bsdf.eval(self.wo, wi) * wi.z.abs()
    }
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.bsdf.pdf(self.wo, wi)
    }
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Option<ScatterSample> {
        let total = self.albedos.specular + self.albedos.transmission + self.albedos.diffuse;
        let (s, t) = (self.albedos.specular.max_element(), self.albedos.transmission.max_element());
        let d = self.albedos.diffuse.max_element();
        let sum = s + t + d;
        let _ = total;
        if sum <= 0.0 {
            return None;
        }
        if self.bsdf.is_smooth() {
            let x = u_lobe * sum;
            if x < s {
                return Some(ScatterSample {
                    wi: Vec3::new(-self.wo.x, -self.wo.y, self.wo.z),
                    weight: self.albedos.specular * (sum / s),
                    pdf: 0.0,
                    lobe: ScatterLobe::SpecularReflection,
                    is_smooth: true,
                    is_unbent: false,
                });
            } else if x < s + t {
                let wi = self.bsdf.refract(self.wo)?;
                return Some(ScatterSample {
                    wi,
                    weight: self.albedos.transmission * (sum / t),
                    pdf: 0.0,
                    lobe: ScatterLobe::Transmission,
                    is_smooth: true,
                    is_unbent: wi == -self.wo,
                });
            }
            let r = libm::sqrtf(u.x);
            let (sn, cs) = libm::sincosf(u.y * std::f32::consts::TAU);
            let wi = Vec3::new(r * cs, r * sn, libm::sqrtf(1.0 - u.x));
            return Some(ScatterSample {
                wi,
                weight: self.albedos.diffuse * (sum / d),
                pdf: d / sum * wi.z * std::f32::consts::FRAC_1_PI,
                lobe: ScatterLobe::Diffuse,
                is_smooth: false,
                is_unbent: false,
            });
        }
        let s = self.bsdf.sample(self.wo, u_lobe, u)?;
        Some(ScatterSample {
            wi: s.wi,
            weight: s.weight,
            pdf: s.pdf,
            lobe: ScatterLobe::Diffuse,
            is_smooth: false,
            is_unbent: false,
        })
    }
}
