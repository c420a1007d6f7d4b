//! Single directions of the specular lobes, for rays that follow rough mirrors and frosted glass.
//!
//! Source: Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984; directions are drawn by visible normals (Heitz,
//! "Sampling the GGX Distribution of Visible Normals", JCGT 2018). What a drawn direction counts for has the lobe's albedo as
//! its mean. `u` is a point of the unit square.

use glam::{Vec2, Vec3};

use super::{Bsdf, Coat, SHARPEST_ALPHA, ggx};

impl Bsdf {
    /// Whether what is reflected cannot be told from what a mirror reflects.
    pub fn is_smooth(&self) -> bool {
        self.lobe.is_smooth()
    }

    /// Whether what passes through is as sharp as through a smooth surface.
    pub fn is_smooth_through(&self) -> bool {
        self.lobe_through.is_smooth()
    }

    /// A direction that the specular lobe reflects and what it counts for; `None` where the draw is masked.
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Vec3)> {
        if wo.z <= 0.0 {
            return None;
        }
        let half = self.lobe.visible_normal(wo, ggx::disk_point(u));
        let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
        let wi = half * (2.0 * facet_cosine) - wo;
        if wi.z <= 0.0 {
            return None;
        }
        let pdf = self.lobe.reflection_pdf(wo, half);
        let (dielectric, metal) = self.reflectances(wo.z, facet_cosine);
        let factor = dielectric * (1.0 - self.metallic) + metal * self.metallic;
        let below = self.sheen.map_or(1.0, |sheen| sheen.below(wo.z));
        let masking = self.lobe.eval(wo, wi, half) * wi.z / pdf;
        (pdf > 0.0).then(|| (wi, factor * (masking * below)))
    }

    /// A direction through a frosted surface, which counts for [`super::Albedos::transmission`]; the smooth surface's where a
    /// facet would not let the light through, and `None` where that would not either.
    pub fn sample_transmission(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        let straight = self.refract(wo)?;
        if wo.z <= 0.0 {
            return Some(straight);
        }
        // A volume's facets are those that reflect, and the index does the rest; a wall's two sides are one lobe.
        let lobe = if self.thin { &self.lobe_through } else { &self.lobe };
        let half = lobe.visible_normal(wo, ggx::disk_point(u));
        let facet_cosine = wo.dot(half).clamp(0.0, 1.0);
        let wi = if self.thin {
            // A wall scatters through as it would reflect.
            let mirrored = half * (2.0 * facet_cosine) - wo;
            Vec3::new(mirrored.x, mirrored.y, -mirrored.z)
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
    /// Whether the lobe cannot be told from a mirror's.
    pub fn is_smooth(&self) -> bool {
        self.alpha <= SHARPEST_ALPHA
    }

    /// A direction that the coat reflects and what it counts for; `None` where the draw is masked.
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        if wo.z <= 0.0 {
            return None;
        }
        let half = ggx::visible_normal(wo, self.alpha, ggx::disk_point(u));
        let wi = half * (2.0 * wo.dot(half).clamp(0.0, 1.0)) - wo;
        (wi.z > 0.0).then(|| (wi, self.reflectance(wo.z) * ggx::shadowing_of_visible(wo.z, wi.z, self.alpha)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interaction::MaterialSample;

    /// Points of a grid in the unit square.
    fn grid(side: u32) -> impl Iterator<Item = Vec2> {
        let at = move |i: u32| (i as f32 + 0.5) / side as f32;
        (0..side * side).map(move |i| Vec2::new(at(i % side), at(i / side)))
    }

    #[test]
    fn drawn_reflections_have_the_albedo_as_their_mean() {
        for (metallic, roughness) in [(0.0, 0.3), (1.0, 0.5), (0.5, 1.0)] {
            let base_color = Vec3::new(0.9, 0.5, 0.1);
            let material =
                MaterialSample { base_color, metallic, roughness, ior: 1.5, ..MaterialSample::default() };
            let bsdf = Bsdf::new(&material, 1.0, 1.5);
            for cosine in [0.2_f32, 0.6, 1.0] {
                let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let drawn = grid(128).filter_map(|u| bsdf.sample_reflection(wo, u));
                let mean = drawn.map(|(_, share)| share).sum::<Vec3>() / (128.0 * 128.0);
                let albedo = bsdf.specular_albedo(wo);
                assert!((mean - albedo).abs().max_element() < 3e-3, "{roughness} {cosine}: {mean} {albedo}");
            }
        }
    }

    #[test]
    fn a_drawn_coat_has_the_albedo_as_its_mean() {
        // The coat's Fresnel factor is that of its normal, so only masking differs between directions.
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
