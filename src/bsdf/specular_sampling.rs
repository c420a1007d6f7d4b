//! Sampling of the specular lobes, for rays that follow rough mirrors and frosted glass.
//!
//! Source: Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984. Directions are sampled by visible normals: bounded ones for
//! reflection ([`super::bounded_reflection`]), and all of them for transmission (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018). The mean
//! weight of the directions is the lobe's albedo. `u` is a point of the unit square.

use glam::{Vec2, Vec3};

use super::ggx::MIN_ALPHA;
use super::{AlbedoTerms, Bsdf, Coat, bounded_reflection, ggx};
use crate::geometry::normalized_or;

impl Bsdf {
    /// Whether the reflection lobe is a mirror.
    pub fn is_smooth(&self) -> bool {
        self.lobe.is_smooth()
    }

    /// Whether the transmission lobe is as sharp as that of a smooth surface.
    pub fn is_transmission_smooth(&self) -> bool {
        self.transmission_lobe.is_smooth()
    }

    /// Samples a direction of the specular lobe and its weight; `None` where the sample is masked. `terms` are those of
    /// [`Bsdf::albedo_terms`].
    pub(crate) fn sample_reflection(&self, wo: Vec3, terms: AlbedoTerms, u: Vec2) -> Option<(Vec3, Vec3)> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = self.lobe.reflected(wo, ggx::disk_point(u))?;
        let half = normalized_or(wo + wi, Vec3::Z);
        let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
        let pdf = self.lobe.reflected_pdf(wo, half);
        let film = self.film_reflectances(wo.z);
        let scale = self.compensation(film.as_ref(), terms);
        let factor = self.specular_factor(self.reflectances(film.as_ref(), facet_cosine), &scale);
        let below = self.sheen.map_or(1.0, |sheen| sheen.below(wo.z));
        let masking = self.lobe.eval(wo, wi, half) * wi.z / pdf;
        (pdf > 0.0).then(|| (wi, factor * (masking * below)))
    }

    /// Samples a direction through a frosted surface, of weight [`super::Albedos::transmission`]. Where the facet reflects totally, the
    /// direction is that of the smooth surface; `None` where that reflects totally, too.
    pub fn sample_transmission(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        let straight = self.refract(wo)?;
        if wo.z <= 0.0 {
            return Some(straight);
        }
        // The facets of a volume are those of its reflection, and the index bends the light. Both sides of a thin wall are one lobe.
        let lobe = if self.thin { &self.transmission_lobe } else { &self.lobe };
        let half = lobe.visible_normal(wo, ggx::disk_point(u));
        let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
        let wi = if self.thin {
            // A thin wall transmits as it would reflect, what its facets would send to the side of the view included.
            let mirrored = half * (2.0 * facet_cosine) - wo;
            Vec3::new(mirrored.x, mirrored.y, -mirrored.z.abs())
        } else {
            let bend = 1.0 / self.dielectric.relative_ior;
            let cosine_squared = 1.0 - bend * bend * (1.0 - facet_cosine * facet_cosine);
            if cosine_squared <= 0.0 {
                return Some(straight);
            }
            half * (bend * facet_cosine - cosine_squared.sqrt()) - wo * bend
        };
        Some(if wi.z < 0.0 { wi.normalize() } else { straight })
    }
}

impl Coat {
    /// Whether the coat is a mirror.
    pub fn is_smooth(&self) -> bool {
        self.alpha <= MIN_ALPHA
    }

    /// Samples a direction of the coat's lobe and its weight; `None` where the sample is masked.
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = bounded_reflection::reflected(wo, Vec2::splat(self.alpha), ggx::disk_point(u))?;
        Some((wi, self.lobe_scale(wo.z) * bounded_reflection::weight(wo.z, wi.z, self.alpha)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interaction::MaterialSample;

    /// The points of a grid in the unit square.
    fn grid(side: u32) -> impl Iterator<Item = Vec2> {
        let at = move |i: u32| (i as f32 + 0.5) / side as f32;
        (0..side * side).map(move |i| Vec2::new(at(i % side), at(i / side)))
    }

    #[test]
    fn sampled_reflections_have_the_albedo_as_their_mean() {
        for (metallic, roughness) in [(0.0, 0.3), (1.0, 0.5), (0.5, 1.0)] {
            let base_color = Vec3::new(0.9, 0.5, 0.1);
            let material =
                MaterialSample { base_color, metallic, roughness, ior: 1.5, ..MaterialSample::default() };
            let bsdf = Bsdf::new(&material, 1.0, 1.5);
            for cosine in [0.2_f32, 0.6, 1.0] {
                let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let sampled = grid(128).filter_map(|u| bsdf.sample_reflection(wo, bsdf.albedo_terms(wo), u));
                let mean = sampled.map(|(_, share)| share).sum::<Vec3>() / (128.0 * 128.0);
                let albedo = bsdf.specular_albedo(wo);
                assert!((mean - albedo).abs().max_element() < 3e-3, "{roughness} {cosine}: {mean} {albedo}");
            }
        }
    }

    #[test]
    fn sampled_coat_reflections_have_the_albedo_as_their_mean() {
        // The Fresnel factor of the coat is that of its normal, so weights differ by masking only.
        let coat = Coat::new(0.8, 0.6);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let mean =
            grid(128).filter_map(|u| coat.sample_reflection(wo, u)).map(|(_, share)| share).sum::<f32>();
        assert!((mean / (128.0 * 128.0) - coat.albedo(wo.z)).abs() < 1e-3);
    }

    #[test]
    fn frosted_glass_scatters_around_the_refracted_direction() {
        let material =
            MaterialSample { roughness: 0.2, transmission: 1.0, ior: 1.5, ..MaterialSample::default() };
        let bsdf = Bsdf::new(&material, 1.0, 1.5);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let smooth = bsdf.refract(wo).unwrap();
        let mut sum = Vec3::ZERO;
        for wi in grid(64).filter_map(|u| bsdf.sample_transmission(wo, u)) {
            assert!(wi.z < 0.0 && (wi.length() - 1.0).abs() < 1e-5);
            sum += wi;
        }
        assert!(sum.normalize().dot(smooth) > 0.999);
        assert!(sum.length() / 4096.0 < 0.9999, "no direction was scattered");
    }
}
