//! What is left of light on its way to a surface.

use std::cell::Cell;

use glam::Vec3;

use super::transparent_hits::TransparentHits;
use super::{GlassShadows, IntegratorContext, MediaStack, Medium};
use crate::bsdf::{Bsdf, Coat};
use crate::bvh::{Hit, HitOrder, TraversalCounters};
use crate::frame::transmits;
use crate::geometry::{Facing, Ray};
use crate::interaction::{
    MaterialSample, RayDifferential, SurfacePoint, alpha_at, catches_shadows, surface_at,
};

/// See-through surfaces that one ray may pass.
pub const PASS_THROUGH_LIMIT: u32 = 256;

/// How a surface stands in the way of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Blocking {
    Solid,
    SeeThrough,
    Absent,
}

/// Shadow rays of one kind, traced together.
#[derive(Debug, Default)]
pub(super) struct ShadowBatch {
    rays: Vec<Ray>,
    is_occluded: Vec<bool>,
    /// Whether something see-through was met; known where nothing solid was.
    is_tinted: Vec<Cell<bool>>,
    /// What was met there.
    transparent_hits: TransparentHits,
}

impl ShadowBatch {
    /// Adds a ray and gives its subscript.
    pub(super) fn push(&mut self, ray: Ray) -> u32 {
        self.rays.push(ray);
        self.rays.len() as u32 - 1
    }

    /// Whether there are no rays.
    pub(super) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// Looks for solid surfaces along all rays.
    pub(super) fn trace(&mut self, context: &IntegratorContext<'_>, counters: &mut TraversalCounters) {
        let Self { rays, is_occluded, is_tinted, transparent_hits } = self;
        transparent_hits.clear();
        is_occluded.resize(rays.len(), false);
        is_tinted.clear();
        is_tinted.resize(rays.len(), Cell::new(false));
        let solid = |index: usize, hit: &Hit| match blocking(context, hit) {
            Blocking::Solid => true,
            Blocking::SeeThrough => {
                is_tinted[index].set(true);
                transparent_hits.add(index, hit);
                false
            }
            Blocking::Absent => false,
        };
        context.view.bvh.occluded_rays(rays, solid, is_occluded, counters);
        transparent_hits.sort(|index| !is_occluded[index]);
    }

    /// The share of light along a ray, which starts in `media`, that arrives; zero where one solid surface is in between.
    /// The flag is set where more see-through surfaces were met than are followed; the rest is then taken as dark.
    pub(super) fn transmittance(
        &self,
        context: &IntegratorContext<'_>,
        index: u32,
        media: MediaStack,
        counters: &mut TraversalCounters,
    ) -> (Vec3, bool) {
        let ray = &self.rays[index as usize];
        if self.is_occluded[index as usize] {
            (Vec3::ZERO, false)
        } else if !self.is_tinted[index as usize].get() {
            (Vec3::ONE, false)
        } else if self.transparent_hits.is_overfull() {
            through_surfaces(context, ray, media, |after| next_surface(context, ray, after, counters))
        } else {
            through_surfaces(context, ray, media, self.transparent_hits.along(index))
        }
    }

    /// Forgets all rays, not the memory.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
    }
}

fn blocking(context: &IntegratorContext<'_>, hit: &Hit) -> Blocking {
    let alpha = alpha_at(context.view, hit);
    if alpha <= 0.0 || catches_shadows(context.view, hit) {
        return Blocking::Absent;
    }
    let instance = context.view.frame.instance(hit.triangle);
    let glass = transmits(&context.view.frame.materials[instance.material.index()]);
    let clear_glass = glass && context.settings.glass_shadows == GlassShadows::Straight;
    if alpha < 1.0 || clear_glass { Blocking::SeeThrough } else { Blocking::Solid }
}

/// The slow twin of what a batch collects: asks for one surface after the other.
fn next_surface(
    context: &IntegratorContext<'_>,
    ray: &Ray,
    after: Option<HitOrder>,
    counters: &mut TraversalCounters,
) -> Option<Hit> {
    let there = |hit: &Hit| blocking(context, hit) != Blocking::Absent;
    context.view.bvh.closest_surface(ray, after, there, counters)
}

/// Multiplies what each see-through surface and the volumes between them leave, in order along the ray. `next` gives the
/// first surface after another.
fn through_surfaces(
    context: &IntegratorContext<'_>,
    ray: &Ray,
    mut media: MediaStack,
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) -> (Vec3, bool) {
    let length = libm::sqrtf(ray.direction.dot(ray.direction));
    let mut left = Vec3::ONE;
    let mut reached_t = ray.t_min;
    let mut after = None;
    for _ in 0..PASS_THROUGH_LIMIT {
        let Some(hit) = next(after) else {
            return (left * media.transmittance((ray.t_max - reached_t) * length), false);
        };
        after = Some(hit.order());
        left *= media.transmittance((hit.t - reached_t) * length) * through_surface(context, ray, &hit);
        if let Some(medium) = clear_medium(context, &hit) {
            // A ray that began inside a volume without knowing shows it by leaving.
            if hit.facing == Facing::Back && !media.holds(medium.volume) {
                left *= medium.transmittance((hit.t - ray.t_min) * length);
            }
            media.cross(medium, hit.facing);
        }
        reached_t = hit.t;
        if left == Vec3::ZERO {
            return (left, false);
        }
    }
    (Vec3::ZERO, true)
}

fn clear_medium(context: &IntegratorContext<'_>, hit: &Hit) -> Option<Medium> {
    let straight = context.settings.glass_shadows == GlassShadows::Straight;
    let instance = context.view.frame.instance(hit.triangle);
    straight.then(|| context.interiors.medium(instance)).flatten()
}

/// (1 − α) + α · transmission · (1 − F) · base colour, times what a coat lets through. The way is not bent, so the Fresnel factor is always the one of
/// entering: the same path backwards, and never total reflection.
fn through_surface(context: &IntegratorContext<'_>, ray: &Ray, hit: &Hit) -> Vec3 {
    let alpha = alpha_at(context.view, hit);
    let (point, material) = surface_at(context.view, ray, hit, &RayDifferential::ZERO);
    let straight = context.settings.glass_shadows == GlassShadows::Straight;
    let glass = if straight && material.transmission > 0.0 {
        // The direction of a stretch hardly changes how much passes.
        let material = MaterialSample { anisotropy: None, ..material };
        let bsdf = Bsdf::new(&material, 1.0, material.ior);
        let cosine = point.wo.dot(point.shading_normal);
        let wo = Vec3::new(libm::sqrtf((1.0 - cosine * cosine).abs()), 0.0, cosine);
        bsdf.transmission_albedo(wo) * coat_transmittance(&material, &point)
    } else {
        Vec3::ZERO
    };
    Vec3::splat(1.0 - alpha) + glass * alpha
}

fn coat_transmittance(material: &MaterialSample, point: &SurfacePoint<'_>) -> f32 {
    material
        .clear_coat
        .map_or(1.0, |coat| Coat::new(coat.factor, coat.roughness).transmittance(point.wo.dot(coat.normal)))
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::integrator::Seed;
    use crate::integrator::whitted::tests::with_context;
    use crate::scene::Environment;

    #[test]
    fn collected_surfaces_darken_as_those_found_one_by_one() {
        for scene in ["material/nested_glass", "material/alpha_blend_stack", "material/glass_shadow"] {
            with_context(scene, &Environment::None, |context, camera| {
                // Camera rays that end at some distance, in a fixed pattern, are as good as shadow rays.
                let (mut batch, mut counters) = (ShadowBatch::default(), TraversalCounters::default());
                for index in 0..768_u32 {
                    let pixel = Vec2::new((index % 32) as f32 * 0.5, (index / 32) as f32 * 0.5);
                    batch.push(Ray { t_max: 1.0 + (index % 7) as f32, ..camera.ray(pixel, Seed::default()) });
                }
                batch.trace(context, &mut counters);
                let mut tinted = 0;
                for index in 0..768_u32 {
                    let ray = batch.rays[index as usize];
                    let (left, _) = batch.transmittance(context, index, MediaStack::default(), &mut counters);
                    if batch.is_occluded[index as usize] {
                        assert_eq!(left, Vec3::ZERO);
                        continue;
                    }
                    let one_by_one = |after| next_surface(context, &ray, after, &mut counters);
                    let (slow, _) = through_surfaces(context, &ray, MediaStack::default(), one_by_one);
                    assert_eq!(left, slow, "{scene}: ray {index}");
                    tinted += u32::from(left != Vec3::ONE);
                }
                assert!(tinted > 10, "{scene}: {tinted}");
            });
        }
    }
}
