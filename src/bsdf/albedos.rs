//! Directional albedos of a material's lobes.

use glam::Vec3;

use super::fresnel::FresnelCurve;
use super::isotropic_albedo::{self, AlbedoTerms};
use super::multiple_scattering::single_scattering;
use super::{Bsdf, anisotropic_albedo, share_below};

/// Directional albedos of all lobes: their shares of uniform light, for one view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Albedos {
    /// [`Bsdf::specular_albedo`].
    pub specular: Vec3,
    /// [`Bsdf::diffuse_albedo`].
    pub diffuse: Vec3,
    /// [`Bsdf::transmission_albedo`].
    pub transmission: Vec3,
    /// Diffusely transmitted share of uniform light from the other side.
    pub diffuse_transmission: Vec3,
    /// Share of uniform light that the sheen reflects.
    pub sheen: Vec3,
}

impl std::ops::Mul<f32> for Albedos {
    type Output = Self;

    #[inline(always)]
    fn mul(self, scale: f32) -> Self {
        Self {
            specular: self.specular * scale,
            diffuse: self.diffuse * scale,
            transmission: self.transmission * scale,
            diffuse_transmission: self.diffuse_transmission * scale,
            sheen: self.sheen * scale,
        }
    }
}

impl Bsdf {
    /// All albedos at once, since they share terms.
    pub fn albedos(&self, wo: Vec3) -> Albedos {
        self.albedos_by(wo, self.albedo_terms(wo))
    }

    /// [`Bsdf::albedos`] with the terms of [`Bsdf::albedo_terms`]. For loops over lanes.
    #[inline(always)]
    pub(crate) fn albedos_by(&self, wo: Vec3, terms: AlbedoTerms) -> Albedos {
        let albedos = self.facet_albedos(wo, terms);
        if self.thin || self.transmission == 0.0 || self.refracted_cosine(wo.z).is_some() {
            return albedos;
        }
        // Facets that hardly bend light reflect what a few of them would transmit.
        let reflected = if self.is_refraction_smooth() {
            let below = self.sheen.map_or(1.0, |sheen| sheen.below(wo.z));
            let entering = share_below(self.lobe_albedos(wo, terms).0);
            (1.0 - self.metallic) * self.transmission * entering * below
        } else {
            0.0
        };
        Albedos { transmission: Vec3::ZERO, specular: albedos.specular + reflected, ..albedos }
    }

    /// The same, with the light that facets transmit where the smooth surface would reflect totally.
    #[inline(always)]
    pub(super) fn facet_albedos(&self, wo: Vec3, terms: AlbedoTerms) -> Albedos {
        let (dielectric, metal) = self.lobe_albedos(wo, terms);
        let mut specular = Vec3::ZERO;
        if self.metallic < 1.0 {
            specular += dielectric * (1.0 - self.metallic);
        }
        if self.metallic > 0.0 {
            specular += metal * self.metallic;
        }
        let entering = share_below(dielectric);
        let mut albedos = Albedos {
            specular,
            diffuse: self.base_below(entering, (1.0 - self.metallic) * self.diffuse_share()),
            transmission: self.base_below(entering, (1.0 - self.metallic) * self.transmission),
            diffuse_transmission: self.diffusely_transmitted((1.0 - self.metallic) * entering),
            sheen: Vec3::ZERO,
        };
        if let Some(sheen) = &self.sheen {
            let below = sheen.below(wo.z);
            albedos.specular *= below;
            albedos.diffuse *= below;
            albedos.transmission *= below;
            albedos.diffuse_transmission *= below;
            albedos.sheen = sheen.albedo(wo.z);
        }
        albedos
    }

    /// E(θ_o): share of uniform light that the specular lobe reflects; its Fresnel factor where the surface is smooth.
    pub fn specular_albedo(&self, wo: Vec3) -> Vec3 {
        self.albedos(wo).specular
    }

    /// Share of uniform light that the diffuse lobe reflects: what the specular lobe leaves, times the base colour. The outgoing
    /// radiance is this times irradiance over π.
    pub fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        self.albedos(wo).diffuse
    }

    /// Transmitted share of uniform light, base colour included: `transmission · (1 − F) · base colour` where the
    /// surface is smooth. Zero where [`Bsdf::refract`] returns `None`.
    pub fn transmission_albedo(&self, wo: Vec3) -> Vec3 {
        self.albedos(wo).transmission
    }

    /// Specular albedos of the dielectric and of the metal, compensated. Without a dielectric the first is 1, without a metal the second
    /// is 0.
    #[inline(always)]
    pub(super) fn lobe_albedos(&self, wo: Vec3, terms: AlbedoTerms) -> (Vec3, Vec3) {
        let film = self.film_reflectances(wo.z);
        let scale = self.compensation(film.as_ref(), terms);
        let dielectric = if self.metallic < 1.0 {
            let shaped = match self.dielectric.curve {
                FresnelCurve::Exact => terms.exact,
                FresnelCurve::Schlick => terms.schlick,
            };
            let bare = self.dielectric.albedo(terms.total, shaped);
            let single = film.map_or(bare, |film| film.over(bare, film.dielectric * terms.total));
            single * scale.dielectric
        } else {
            Vec3::ONE
        };
        let metal = if self.metallic > 0.0 {
            let bare = single_scattering(self.base_color, terms.total, terms.schlick);
            film.map_or(bare, |film| film.over(bare, film.metal * terms.total)) * scale.metal
        } else {
            Vec3::ZERO
        };
        (dielectric, metal)
    }

    /// The albedo terms that the material needs.
    pub(crate) fn albedo_terms(&self, wo: Vec3) -> AlbedoTerms {
        let exact = self.metallic < 1.0 && self.dielectric.curve == FresnelCurve::Exact;
        match self.lobe.anisotropic {
            Some(ggx) if exact => anisotropic_albedo::terms(ggx, wo, &self.albedo_slice),
            Some(ggx) => anisotropic_albedo::schlick_terms(ggx, wo),
            None if exact => self.albedo_slice.terms(wo.z, self.lobe.roughness),
            None => isotropic_albedo::schlick_terms(wo.z, self.lobe.roughness),
        }
    }

    /// Share of the diffuse reflection in what is not metal.
    #[inline(always)]
    fn diffuse_share(&self) -> f32 {
        (1.0 - self.transmission) * (1.0 - self.diffuse_transmission)
    }

    #[inline(always)]
    fn base_below(&self, entering: f32, share: f32) -> Vec3 {
        if share == 0.0 {
            return Vec3::ZERO;
        }
        self.base_color * (share * entering)
    }
}
