//! BSDF of the glTF material model, as a sum of lobes.
//!
//! Source: Khronos, "glTF 2.0 Specification", appendix B, with the extensions `KHR_materials_ior`, `specular`, `transmission`,
//! `diffuse_transmission`, `anisotropy`, `iridescence` and `sheen`. The clear coat on top of all is [`Coat`].
//! material = sheen over mix(dielectric, metal, metallic); dielectric = mix(mix(diffuse, transmission), specular, F(o·h)), where
//! diffuse = mix(reflected, transmitted). Departures: dielectrics follow the exact Fresnel curve, and the albedos of lower lobes are
//! scaled by what the whole specular lobe leaves, 1 − E(θ_o), so that no surface returns more light than it receives. Rough specular
//! lobes keep the light of multiple scattering (`multiple_scattering`).
//!
//! Directions are unit vectors in the local shading frame, with +Z along the shading normal on the side of `wo`. Both point away from
//! the surface. Media and absorption are not known here.

mod albedo_grid;
mod albedo_slice;
mod albedo_table;
mod albedo_tables;
mod albedos;
mod anisotropic_albedo;
mod bounded_reflection;
mod coat;
mod coat_lobe;
mod cubic_table;
mod external_albedo;
mod fresnel;
mod ggx;
mod ggx_anisotropic;
mod index_planes;
mod internal_albedo;
mod isotropic_albedo;
mod lobe_probabilities;
mod microfacets;
mod multiple_scattering;
mod rough_transmission;
mod rough_volume_albedo;
mod scattering;
mod scattering_lanes;
mod scattering_sampling;
mod sheen;
mod smooth_lobes;
mod specular_lobe;
mod specular_sampling;
mod stored_values;
mod thin_film;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::geometry::normalized_or;
use crate::interaction::MaterialSample;

pub use albedo_slice::AlbedoSlice;
pub(crate) use albedo_table::{AlbedoTable, AlbedoTermLanes};
pub use albedo_tables::integrated_albedo_tables;
pub use albedos::Albedos;
pub use coat::Coat;
pub use coat_lobe::OrientedCoat;
pub(crate) use fresnel::{LARGEST_SCALED_IOR, exact as dielectric_reflectance};
pub(crate) use isotropic_albedo::AlbedoTerms;
pub(crate) use multiple_scattering::metallic_albedo;
pub use scattering::Scattering;
pub(crate) use scattering_lanes::{ScatteredLanes, ScatteringLanes};
pub(crate) use scattering_sampling::FacetSample;
pub(crate) use scattering_sampling::LobeDirection;
pub(crate) use scattering_sampling::cosine_direction;
pub use scattering_sampling::{ScatterLobe, ScatterSample};
pub(crate) use specular_lobe::is_smooth_roughness;

use fresnel::{Dielectric, Tint};
use ggx_anisotropic::ReflectedDirection;
use multiple_scattering::Compensation;
use sheen::Sheen;
use specular_lobe::SpecularLobe;
use thin_film::{FilmReflectances, ThinFilm};

/// The lobes of one material at one point, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    base_color: Vec3,
    metallic: f32,
    transmission: f32,
    thin: bool,
    diffuse_transmission: f32,
    diffuse_transmission_color: Vec3,
    dielectric: Dielectric,
    albedo_slice: AlbedoSlice,
    lobe: SpecularLobe,
    /// Lobe of transmitted light: sharper where the index bends light less.
    transmission_lobe: SpecularLobe,
    thin_film: Option<ThinFilm>,
    sheen: Option<Sheen>,
}

impl Bsdf {
    /// The lobes of `material`; `ior_outside` is the index of refraction on the side of `wo`, `ior_inside` on the other.
    /// An index of 0, in the material or on either side, leaves the reflectance to the specular colour: white reflects everything.
    pub fn new(material: &MaterialSample, ior_outside: f32, ior_inside: f32) -> Self {
        let albedo_slice = AlbedoSlice::between(ior_outside, ior_inside);
        Self::with_albedos(material, ior_outside, ior_inside, albedo_slice)
    }

    /// The same lobes with the slice of their indices, [`AlbedoSlice::between`], at hand.
    pub fn with_albedos(
        material: &MaterialSample,
        ior_outside: f32,
        ior_inside: f32,
        albedo_slice: AlbedoSlice,
    ) -> Self {
        Self::in_lane(material, ior_outside, ior_inside, albedo_slice)
    }

    /// [`Bsdf::with_albedos`], for loops over lanes.
    #[inline(always)]
    pub(crate) fn in_lane(
        material: &MaterialSample,
        ior_outside: f32,
        ior_inside: f32,
        albedo_slice: AlbedoSlice,
    ) -> Self {
        let ior_inside = if material.ior == 0.0 { 0.0 } else { ior_inside };
        let roughness = material.roughness.clamp(0.0, 1.0);
        let tint = Tint { factor: material.specular, color: material.specular_color };
        // From the denser side, the film's outer side is the other one.
        let film_outside = if ior_inside < ior_outside { ior_inside } else { ior_outside };
        let dielectric = if material.is_tinted {
            Dielectric::tinted(ior_outside, ior_inside, tint, material.transmission > 0.0)
        } else {
            Dielectric::between(ior_outside, ior_inside, tint)
        };
        let strength = material.anisotropy.map(|anisotropy| anisotropy.strength);
        let lobe = SpecularLobe::new(roughness, strength);
        Self {
            base_color: material.base_color,
            metallic: material.metallic.clamp(0.0, 1.0),
            transmission: material.transmission.clamp(0.0, 1.0),
            diffuse_transmission: material.diffuse_transmission.clamp(0.0, 1.0),
            diffuse_transmission_color: material.diffuse_transmission_color,
            thin: material.thin,
            dielectric,
            albedo_slice,
            lobe,
            transmission_lobe: lobe.narrowed(transmission_roughness_scale(dielectric.relative_ior)),
            thin_film: material
                .iridescence
                .and_then(|film| ThinFilm::new(&film, if film_outside > 0.0 { film_outside } else { 1.0 })),
            sheen: material.sheen.map(|sheen| Sheen::new(sheen.color, sheen.roughness)),
        }
    }

    /// f(wo, wi), without the cosine.
    ///
    /// On the side of `wo`: diffuse and specular reflection. On the other side: diffuse transmission, and for thin walls the GGX lobe
    /// around the straight direction. Light passes the surface of a volume by refracted rays, and that of punctual lights by the
    /// straight shadow rays of the integrator or by the lobe of [`Scattering`], never by this one.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.eval_by(wo, wi, self.albedo_terms(wo))
    }

    /// [`Bsdf::eval`] with the terms of [`Bsdf::albedo_terms`]. For loops over lanes.
    #[inline(always)]
    pub(crate) fn eval_by(&self, wo: Vec3, wi: Vec3, terms: AlbedoTerms) -> Vec3 {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return Vec3::ZERO;
        }
        let through = wi.z < 0.0;
        if through && !self.transmits_rough() && self.diffuse_transmission == 0.0 {
            return Vec3::ZERO;
        }
        // A thin wall transmits as it would reflect the mirrored direction.
        let mirrored = Vec3::new(wi.x, wi.y, wi.z.abs());
        let half = normalized_or(wo + mirrored, Vec3::Z);
        let film = self.film_reflectances(wo.z);
        let (dielectric, metal) = self.reflectances(film.as_ref(), wo.dot(half));
        let entering = (1.0 - self.metallic) * share_below(dielectric);
        let below = if through {
            let lobe = if self.thin { self.transmission_lobe.eval(wo, mirrored, half) } else { 0.0 };
            self.diffusely_transmitted(entering) * FRAC_1_PI
                + self.base_color * entering * (self.transmission * lobe)
        } else {
            let scale = self.compensation(film.as_ref(), terms);
            let reflected = self.specular_factor((dielectric, metal), &scale);
            let diffuse = (1.0 - self.transmission) * (1.0 - self.diffuse_transmission);
            let lobe = self.lobe.eval(wo, mirrored, half);
            reflected * lobe + self.base_color * entering * (diffuse * FRAC_1_PI)
        };
        let Some(sheen) = &self.sheen else { return below };
        // The sheen takes the larger of the shares at both directions.
        let (left_o, left_i) = (sheen.below(wo.z), sheen.below(mirrored.z));
        let scaled = below * if left_o < left_i { left_o } else { left_i };
        if through { scaled } else { scaled + sheen.eval(wo, wi) }
    }

    /// Direction on the other side of light that leaves along `wo`, refracted (Snell); unbent for thin walls. `None` at total internal
    /// reflection.
    pub fn refract(&self, wo: Vec3) -> Option<Vec3> {
        if self.thin {
            return Some(-wo);
        }
        let cosine = self.refracted_cosine(wo.z)?;
        let bend = 1.0 / self.dielectric.relative_ior;
        Some(Vec3::new(-wo.x * bend, -wo.y * bend, -cosine).normalize())
    }

    /// Roughness of the reflection lobe along the direction in which it is widest.
    pub fn widest_roughness(&self) -> f32 {
        self.lobe.widest_roughness()
    }

    /// Roughness of the transmission lobe: facets that bend light less blur it less, and an index of 1 not at all.
    pub fn transmission_roughness(&self) -> f32 {
        self.transmission_lobe.roughness
    }

    /// Roughness of the transmission lobe along the direction in which it is widest.
    pub fn widest_transmission_roughness(&self) -> f32 {
        self.transmission_lobe.widest_roughness()
    }

    /// Directions around which lobes of the material's roughness make up an anisotropic specular lobe, with shares whose sum is about
    /// [`Albedos::specular`]; none for isotropic lobes.
    pub(crate) fn anisotropic_reflections(
        &self,
        wo: Vec3,
        terms: AlbedoTerms,
    ) -> impl Iterator<Item = (Vec3, Vec3)> {
        let below = self.sheen.map_or(1.0, |sheen| sheen.below(wo.z));
        let film = self.film_reflectances(wo.z);
        let reflected = self.lobe.anisotropic.into_iter().flat_map(move |ggx| {
            let scale = self.compensation(film.as_ref(), terms);
            ggx.narrow_lobes(wo).map(move |reflected| (reflected, scale))
        });
        reflected.map(move |(ReflectedDirection { wi, facet_cosine, weight }, scale)| {
            let factor = self.specular_factor(self.reflectances(film.as_ref(), facet_cosine), &scale);
            (wi, factor * (weight * below))
        })
    }

    /// The cosine of the refracted direction; `None` at total internal reflection.
    #[inline(always)]
    fn refracted_cosine(&self, cosine: f32) -> Option<f32> {
        let sine_squared = 1.0 - cosine * cosine;
        let n_squared = self.dielectric.relative_ior * self.dielectric.relative_ior;
        let cosine_squared = 1.0 - sine_squared / n_squared;
        (cosine_squared > 0.0).then(|| cosine_squared.sqrt())
    }

    /// Reflectances where a thin film covers the surface, for a view.
    #[inline(always)]
    fn film_reflectances(&self, cos_o: f32) -> Option<FilmReflectances> {
        let film = self.thin_film.as_ref()?;
        let cosine = self.cosine_outside_film(cos_o);
        Some(film.reflectances(cosine, [self.dielectric.along_normal(), self.base_color]))
    }

    /// Fresnel factors of the dielectric and of the metal, for a microfacet.
    #[inline(always)]
    fn reflectances(&self, film: Option<&FilmReflectances>, facet_cosine: f32) -> (Vec3, Vec3) {
        let dielectric = self.dielectric.reflectance(facet_cosine);
        let metal = fresnel::schlick(facet_cosine, self.base_color);
        let Some(film) = film else { return (dielectric, metal) };
        (film.over(dielectric, film.dielectric), film.over(metal, film.metal))
    }

    /// What multiple scattering adds to the specular lobe for a view.
    #[inline(always)]
    fn compensation(&self, film: Option<&FilmReflectances>, terms: AlbedoTerms) -> Compensation {
        let dielectric = if self.dielectric.relative_ior < 1.0 {
            self.dielectric.reflectance_by(terms.exact / terms.total)
        } else {
            self.dielectric.along_normal()
        };
        let mut f0 = (dielectric, self.base_color);
        if let Some(film) = film {
            f0 = (film.over(dielectric, film.dielectric), film.over(self.base_color, film.metal));
        }
        Compensation::new(f0, terms.total)
    }

    /// Factor of the specular lobe for a microfacet: Fresnel's of both parts, compensated.
    #[inline(always)]
    fn specular_factor(&self, (dielectric, metal): (Vec3, Vec3), scale: &Compensation) -> Vec3 {
        dielectric * scale.dielectric * (1.0 - self.metallic) + metal * scale.metal * self.metallic
    }

    /// The cosine of the view on the outer side of a thin film; from within a volume that is the far side.
    #[inline(always)]
    fn cosine_outside_film(&self, cos_o: f32) -> Option<f32> {
        if self.dielectric.relative_ior < 1.0 { self.refracted_cosine(cos_o) } else { Some(cos_o) }
    }

    /// The diffusely transmitted share of the light that enters, colour included.
    #[inline(always)]
    fn diffusely_transmitted(&self, entering: f32) -> Vec3 {
        self.diffuse_transmission_color * (entering * (1.0 - self.transmission) * self.diffuse_transmission)
    }

    /// Whether light is transmitted by a lobe instead of a refracted ray.
    #[inline(always)]
    fn transmits_rough(&self) -> bool {
        self.thin && self.transmission > 0.0 && self.metallic < 1.0
    }
}

/// Scale of the roughness for transmitted light, by relative index of refraction: from 0 at 1 to 1 at 1.5, as in glTF viewers.
#[inline(always)]
fn transmission_roughness_scale(relative_ior: f32) -> f32 {
    let ior = if relative_ior > 1.0 { relative_ior } else { 1.0 / relative_ior };
    (2.0 * ior - 2.0).clamp(0.0, 1.0)
}

/// The share of light below a lobe, the same for all colour channels.
#[inline(always)]
fn share_below(reflectance: Vec3) -> f32 {
    let left = 1.0 - reflectance.max_element();
    if left > 0.0 { left } else { 0.0 }
}

#[cfg(test)]
mod tests;
