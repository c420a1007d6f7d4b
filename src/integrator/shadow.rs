//! Transmittance of shadow rays: opaque surfaces, transparent surfaces, and the media in between.

mod batch_tracing;

use std::cell::{Cell, RefCell};

use glam::Vec3;

use super::albedo_slices::AlbedoSlices;
use super::glass_passage::GlassPassage;
use super::media::{MediaCache, SurfaceMedia};
use super::transparent_hits::{TRANSPARENCY_LIMIT, TransparentHits};
use super::{GlassShadows, IntegratorContext, MediaStack, Medium};
use crate::bsdf::{Bsdf, Coat};
use crate::bvh::{Hit, HitOrder, TraversalCounters, TriangleFlags};
use crate::geometry::{Facing, Ray};
use crate::interaction::{
    MaterialSample, SurfacePoint, TextureProbes, alpha_at, catches_shadows, material_values, transmits_at,
};
use crate::scene::{Material, MaterialIndex};

/// How a surface occludes light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Occlusion {
    Opaque,
    Transparent,
    Absent,
}

impl GlassPassage {
    /// Whether light passes glass of a material.
    fn passes(self, context: &IntegratorContext<'_>, material: &Material) -> bool {
        match self {
            Self::Straight => context.settings.glass_shadows == GlassShadows::Straight,
            Self::ThinWalls => !material.is_volume(),
        }
    }

    /// The share of light that passes lobes straight.
    fn transmittance(self, lobes: &Bsdf, wo: Vec3) -> Vec3 {
        let is_clear = self == Self::Straight || lobes.is_transmission_smooth();
        if is_clear { lobes.transmission_albedo(wo) } else { Vec3::ZERO }
    }
}

/// The light that a shadow ray lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShadowTransmittance {
    /// Share of the light that arrives; 0 behind an opaque surface.
    pub(super) transmittance: Vec3,
    /// Share of the ray that surfaces hide without absorbing it as tinted glass and volumes do; 1 behind an opaque surface.
    pub(super) hidden: Vec3,
    /// Whether the ray hits more than [`TRANSPARENCY_LIMIT`] transparent surfaces; it then counts as occluded.
    pub(super) limit_reached: bool,
}

impl ShadowTransmittance {
    /// An occluded ray.
    const NONE: Self = Self { transmittance: Vec3::ZERO, hidden: Vec3::ONE, limit_reached: false };
}

/// Shadow rays that are traced together.
#[derive(Debug, Default)]
pub(super) struct ShadowBatch {
    passage: GlassPassage,
    rays: Vec<Ray>,
    is_occluded: Vec<bool>,
    /// Whether the ray hits a transparent surface; known for rays that hit no opaque one.
    is_tinted: Vec<Cell<bool>>,
    /// The transparent surfaces of those rays, from the ray `first_collected` on.
    transparent_hits: TransparentHits,
    first_collected: u32,
    /// The transmittance of every ray, where the rays have more transparent surfaces than are kept at once; else empty.
    found_in_parts: Vec<ShadowTransmittance>,
    media: Vec<SurfaceMedia>,
    cache: RefCell<ShadowCache>,
}

/// What shadow rays found last.
#[derive(Debug, Default)]
struct ShadowCache {
    glass: Option<ConstantGlass>,
    albedo_slices: AlbedoSlices,
    media: MediaCache,
    probes: RefCell<TextureProbes>,
}

impl ShadowCache {
    /// The lobes that light passes from a medium of index `ior_outside`. Thin walls have those that shading finds there, since both decide which walls
    /// are clear. Elsewhere the direction of anisotropy hardly changes how much light passes.
    fn lobes(&mut self, passage: GlassPassage, material: &MaterialSample, ior_outside: f32) -> Bsdf {
        let albedo_slice = self.albedo_slices.between(ior_outside, material.ior);
        let anisotropy = material.anisotropy.filter(|_| passage == GlassPassage::ThinWalls);
        let material = MaterialSample { anisotropy, ..*material };
        Bsdf::with_albedos(&material, ior_outside, material.ior, albedo_slice)
    }
}

/// The lobes of the last constant material.
#[derive(Debug)]
struct ConstantGlass {
    material: MaterialIndex,
    ior_outside: f32,
    bsdf: Bsdf,
    /// Base colour.
    tint: Vec3,
}

impl ShadowBatch {
    /// A batch without rays.
    pub(super) fn new(passage: GlassPassage) -> Self {
        Self { passage, ..Self::default() }
    }

    /// Adds a ray and returns its index.
    #[inline]
    pub(super) fn push(&mut self, ray: Ray, media: SurfaceMedia) -> u32 {
        let index = self.rays.len() as u32;
        self.rays.push(ray);
        self.media.push(media);
        index
    }

    /// A ray that hits an opaque surface; `None` for any other.
    pub(super) fn occluded_ray(&self, index: u32) -> Option<&Ray> {
        self.is_occluded[index as usize].then(|| &self.rays[index as usize])
    }

    /// The volumes around the surface of a ray.
    pub(super) fn media(&self, index: u32) -> &SurfaceMedia {
        &self.media[index as usize]
    }

    /// The direction of a ray.
    pub(super) fn direction(&self, index: u32) -> Vec3 {
        self.rays[index as usize].direction
    }

    /// Whether there are no rays.
    pub(super) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// The transmittance of a ray.
    #[inline(always)]
    pub(super) fn transmittance(
        &self,
        context: &IntegratorContext<'_>,
        index: u32,
        counters: &mut TraversalCounters,
    ) -> ShadowTransmittance {
        match self.found_in_parts.get(index as usize) {
            Some(found) => *found,
            None => self.collected_transmittance(context, index, counters),
        }
    }

    /// The transmittance of one of the rays whose surfaces were collected last.
    #[inline(always)]
    fn collected_transmittance(
        &self,
        context: &IntegratorContext<'_>,
        index: u32,
        counters: &mut TraversalCounters,
    ) -> ShadowTransmittance {
        if self.is_occluded[index as usize] {
            ShadowTransmittance::NONE
        } else if !self.is_tinted[index as usize].get() {
            let transmittance = self.unhindered(index);
            ShadowTransmittance { transmittance, hidden: Vec3::ZERO, limit_reached: false }
        } else {
            self.tinted_transmittance(context, index, counters)
        }
    }

    /// The transmittance of a ray that hits nothing: that of the volume around it.
    #[inline(always)]
    fn unhindered(&self, index: u32) -> Vec3 {
        self.passage.last_stretch(self.media[index as usize].stack(), &self.rays[index as usize], None)
    }

    /// The volumes in which a ray starts; found from where it ends, by what it hits before.
    fn media_at_start(
        &self,
        context: &IntegratorContext<'_>,
        (index, cache): (u32, &mut MediaCache),
        mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
    ) -> MediaStack {
        let mut media = match &self.media[index as usize] {
            SurfaceMedia::AtEnd(media) if crosses_volumes(context, self.passage) => media.clone(),
            at_start => return at_start.stack().clone(),
        };
        let (mut crossed, mut after) = (Vec::new(), None);
        for _ in 0..TRANSPARENCY_LIMIT {
            let Some(hit) = next(after) else { break };
            after = Some(hit.order());
            crossed.extend(clear_medium(context, &hit, self.passage).map(|medium| (medium, hit.facing)));
        }
        for (medium, facing) in crossed.into_iter().rev() {
            media.cross_back(medium, facing, cache);
        }
        media
    }

    /// The transmittance of a ray that hits transparent surfaces alone.
    #[inline(never)]
    fn tinted_transmittance(
        &self,
        context: &IntegratorContext<'_>,
        index: u32,
        counters: &mut TraversalCounters,
    ) -> ShadowTransmittance {
        let ray = &self.rays[index as usize];
        let mut cache = self.cache.borrow_mut();
        if self.transparent_hits.is_overfull() {
            let mut next = |after| next_surface(context, (ray, self.passage), after, counters);
            let media = self.media_at_start(context, (index, &mut cache.media), &mut next);
            through_surfaces(context, (ray, self.passage), (media, &mut *cache), next)
        } else {
            let next = || self.transparent_hits.along(index - self.first_collected);
            let media = self.media_at_start(context, (index, &mut cache.media), next());
            through_surfaces(context, (ray, self.passage), (media, &mut *cache), next())
        }
    }

    /// Removes all rays and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.media.clear();
    }
}

/// Whether a hit stops a shadow ray.
pub(super) fn stops_light(context: &IntegratorContext<'_>, hit: &Hit, passage: GlassPassage) -> bool {
    occlusion(context, hit, passage) == Occlusion::Opaque
}

fn occlusion(context: &IntegratorContext<'_>, hit: &Hit, passage: GlassPassage) -> Occlusion {
    let alpha = alpha_at(context.view, hit);
    if alpha <= 0.0 || catches_shadows(context.view, hit) {
        return Occlusion::Absent;
    }
    let instance = context.view.frame.instance(hit.triangle);
    let material = &context.view.frame.materials[instance.material.index()];
    let clear_glass =
        material.transmits() && passage.passes(context, material) && transmits_at(context.view, hit);
    let lets_pass = alpha < 1.0 || clear_glass;
    if lets_pass && passage == GlassPassage::ThinWalls && is_unseen_back(context, hit) {
        Occlusion::Absent
    } else if lets_pass {
        Occlusion::Transparent
    } else {
        Occlusion::Opaque
    }
}

/// Whether a hit is on the back of a single-sided surface, which sampled rays pass as if nothing were there.
fn is_unseen_back(context: &IntegratorContext<'_>, hit: &Hit) -> bool {
    let flags = context.view.frame.flags[hit.triangle as usize];
    hit.facing == Facing::Back && flags.has(TriangleFlags::SINGLE_SIDED)
}

/// The next surface of a shadow ray, by a query of its own. Reference implementation of the collected hits, and the fallback
/// where those of a single ray are too many.
fn next_surface(
    context: &IntegratorContext<'_>,
    (ray, passage): (&Ray, GlassPassage),
    after: Option<HitOrder>,
    counters: &mut TraversalCounters,
) -> Option<Hit> {
    let is_surface = |hit: &Hit| occlusion(context, hit, passage) != Occlusion::Absent;
    context.view.bvh.closest_hit_of_any_side(ray, after, is_surface, counters)
}

/// Multiplies the transmittances of all transparent surfaces and of the media between them, in order along the ray. `next` returns
/// the first surface after a given hit.
fn through_surfaces(
    context: &IntegratorContext<'_>,
    (ray, passage): (&Ray, GlassPassage),
    (mut media, cache): (MediaStack, &mut ShadowCache),
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) -> ShadowTransmittance {
    let length = libm::sqrtf(ray.direction.dot(ray.direction));
    let (mut transmittance, mut hidden) = (Vec3::ONE, Vec3::ZERO);
    let mut reached_t = ray.t_min;
    let mut after = None;
    for _ in 0..TRANSPARENCY_LIMIT {
        let Some(hit) = next(after) else {
            transmittance *= passage.last_stretch(&media, ray, Some((reached_t, length)));
            return ShadowTransmittance { transmittance, hidden, limit_reached: false };
        };
        after = Some(hit.order());
        let surface = through_surface(context, (ray, passage), (&hit, passage.ior_outside(&media)), cache);
        let to_surface = media.transmittance((hit.t - reached_t) * length);
        hidden += transmittance * to_surface * surface.hidden;
        transmittance *= to_surface * surface.transmittance;
        if let Some(medium) = clear_medium(context, &hit, passage) {
            // A ray that started inside a volume unknowingly reveals it where it leaves.
            if hit.facing == Facing::Back && !media.holds(medium.volume) {
                transmittance *= medium.transmittance((hit.t - ray.t_min) * length);
            }
            media.cross(medium, hit.facing, &mut cache.media);
        }
        reached_t = hit.t;
        if transmittance == Vec3::ZERO {
            return ShadowTransmittance { transmittance, hidden, limit_reached: false };
        }
    }
    ShadowTransmittance { limit_reached: true, ..ShadowTransmittance::NONE }
}

/// Whether shadow rays enter and leave volumes.
fn crosses_volumes(context: &IntegratorContext<'_>, passage: GlassPassage) -> bool {
    passage == GlassPassage::Straight
        && context.settings.glass_shadows == GlassShadows::Straight
        && !context.interiors.is_empty()
}

fn clear_medium(context: &IntegratorContext<'_>, hit: &Hit, passage: GlassPassage) -> Option<Medium> {
    let instance = context.view.frame.instance(hit.triangle);
    crosses_volumes(context, passage).then(|| context.interiors.medium(instance)).flatten()
}

/// The light that one surface lets through.
#[derive(Clone, Copy)]
struct SurfaceTransmittance {
    /// (1 − α) + α · transmission · (1 − F) · base colour, times the transmittance of its coat.
    transmittance: Vec3,
    /// What a white surface in its place would not let through.
    hidden: f32,
}

fn through_surface(
    context: &IntegratorContext<'_>,
    (ray, passage): (&Ray, GlassPassage),
    (hit, ior_outside): (&Hit, f32),
    cache: &mut ShadowCache,
) -> SurfaceTransmittance {
    let alpha = alpha_at(context.view, hit);
    let frame = context.view.frame;
    let material = &frame.materials[frame.instance(hit.triangle).material.index()];
    let (glass, tint) = if material.transmits() && passage.passes(context, material) {
        glass_transmittance(context, (ray, passage), (hit, ior_outside), cache)
    } else {
        (Vec3::ZERO, Vec3::ONE)
    };
    // Black glass reflects as little as glass of its index can.
    let untinted = if tint == Vec3::ZERO { 1.0 } else { glass.max_element() / tint.max_element() };
    SurfaceTransmittance {
        transmittance: Vec3::splat(1.0 - alpha) + glass * alpha,
        hidden: alpha * (1.0 - untinted).max(0.0),
    }
}

/// The ray is not bent, so F is always that of a ray that enters. This is F of the same path backwards, and there is no total
/// reflection. Returns the base colour, too.
fn glass_transmittance(
    context: &IntegratorContext<'_>,
    (ray, passage): (&Ray, GlassPassage),
    (hit, ior_outside): (&Hit, f32),
    cache: &mut ShadowCache,
) -> (Vec3, Vec3) {
    let view = context.view;
    let point = SurfacePoint::orientation(view, ray, hit, &cache.probes);
    let cosine = point.wo.dot(point.shading_normal);
    let wo = Vec3::new(libm::sqrtf((1.0 - cosine * cosine).abs()), 0.0, cosine);
    let index = point.instance.material;
    if context.constant_materials[index.index()] && !point.instance.has_colors(view.scene) {
        let is_known = |glass: &ConstantGlass| glass.material == index && glass.ior_outside == ior_outside;
        if !cache.glass.as_ref().is_some_and(is_known) {
            let values = material_values(view, &point, &cache.probes);
            let bsdf = cache.lobes(passage, &values, ior_outside);
            cache.glass = Some(ConstantGlass { material: index, ior_outside, bsdf, tint: values.base_color });
        }
        let of_constant = |glass: &ConstantGlass| (passage.transmittance(&glass.bsdf, wo), glass.tint);
        return cache.glass.as_ref().map_or((Vec3::ZERO, Vec3::ONE), of_constant);
    }
    let material = material_values(view, &point, &cache.probes);
    if material.transmission > 0.0 {
        let glass = passage.transmittance(&cache.lobes(passage, &material, ior_outside), wo);
        (glass * coat_transmittance(&material, &point), material.base_color)
    } else {
        (Vec3::ZERO, Vec3::ONE)
    }
}

fn coat_transmittance(material: &MaterialSample, point: &SurfacePoint<'_>) -> f32 {
    material
        .clear_coat
        .map_or(1.0, |coat| Coat::new(coat.factor, coat.roughness).transmittance(point.wo.dot(coat.normal)))
}

#[cfg(test)]
mod tests;
