//! What one surface sends back along a ray: its own light, lights, the environment, and the rays it sends on.

use glam::{Mat3, Vec3};

use super::coat::Coated;
use super::generation::{Generation, Route};
use super::sight::Sight;
use super::{LEAST_WEIGHT, Tracer};
use crate::bsdf::{Albedos, Bsdf};
use crate::bvh::{Hit, HitOrder, PrimitiveFlags};
use crate::geometry::{Facing, Ray, unit};
use crate::integrator::random::Purpose;
use crate::integrator::{MediaStack, Medium, Path, PathClass, Seed, Spectrum, World};
use crate::interaction::{MaterialSample, SurfacePoint, alpha_at, catches_shadows, material_at};

/// Below this roughness a lobe is followed by rays only.
const SHARP_ROUGHNESS: f32 = 0.1;
/// Above this roughness a lobe only looks the environment up.
const DULL_ROUGHNESS: f32 = 0.4;

/// A surface with its lobes, seen by one ray.
pub(super) struct Shading<'p, 'a> {
    /// How the ray came about.
    pub(super) route: Route,
    pub(super) path: &'p Path,
    pub(super) point: &'p SurfacePoint<'a>,
    pub(super) material: MaterialSample,
    pub(super) bsdf: Bsdf,
    /// Of the lobes, as seen by the ray.
    pub(super) albedos: Albedos,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    pub(super) wo: Vec3,
    /// What radiance that leaves towards the eye counts for.
    pub(super) weight: Vec3,
    /// The same for what leaves below the coat.
    pub(super) weight_below: Vec3,
    pub(super) coat: Option<Coated>,
    /// The lobes of single colours, where glass bends those differently.
    pub(super) parted: Option<[Bsdf; 3]>,
    /// What lies on the other side.
    behind: Behind,
    /// Index of refraction there by the one on this side.
    pub(super) relative_ior: f32,
    /// Share of each lobe that rays follow; the environment lookup has the rest.
    pub(super) sharpness: f32,
}

/// A ray that a surface sends on.
pub(super) struct Child {
    pub(super) ray: Ray,
    /// What the radiance that it finds counts for.
    pub(super) weight: Vec3,
    pub(super) class: PathClass,
    pub(super) spectrum: Spectrum,
    pub(super) seed: Seed,
}

impl Shading<'_, '_> {
    /// The lobes by which light goes through, each with the colours it is for.
    pub(super) fn ways_through(&self) -> impl Iterator<Item = (Spectrum, &Bsdf)> {
        let together = self.parted.is_none().then_some((self.path.spectrum, &self.bsdf));
        let apart = self.parted.iter().flat_map(|parted| Spectrum::COLORS.into_iter().zip(parted));
        together.into_iter().chain(apart)
    }
}

impl Tracer<'_, '_> {
    /// Shades everything that a generation sees, in order.
    pub(super) fn shade_sights(&mut self, generation: &Generation) {
        let mut sights = std::mem::take(&mut self.sights);
        for sight in sights.drain(..) {
            self.shade(generation, &sight);
        }
        self.sights = sights;
    }

    fn shade(&mut self, generation: &Generation, Sight { place, hit, share }: &Sight) {
        let posed = self.world.posed;
        let (ray, path) = generation.ray(*place);
        let point = SurfacePoint::new(posed, ray, hit, &path.footprint);
        let material = material_at(posed, &point);
        let weight = path.weight * path.media.transmittance(hit.t) * *share;
        if material.unlit {
            self.add(path, weight * material.base_color);
            return;
        }
        let follows_rays = self.world.settings.glossy_samples > 0;
        let coat = material.clear_coat.map(|coat| Coated::new(&coat, &point, follows_rays));
        let weight_below = weight * coat.as_ref().map_or(1.0, |coat| coat.transmittance);
        self.add(path, weight_below * material.emission);

        let behind = self.behind(path, &point, &material);
        let own_medium = self.world.interiors.medium(point.shape);
        let iors = |spectrum| {
            let before = ior_before(path, own_medium, point.facing, spectrum);
            (before, ior_behind(&material, &behind.media, spectrum))
        };
        let lobes_of = |spectrum| {
            let (before, behind) = iors(spectrum);
            Bsdf::new(&material, before, behind)
        };
        let (before, after) = iors(path.spectrum);
        let bsdf = lobes_of(path.spectrum);
        let disperses = path.media.disperses()
            || behind.media.disperses()
            || own_medium.is_some_and(|medium| medium.half_spread > 0.0);
        let parts = path.spectrum == Spectrum::White && !material.thin && disperses;
        let parted = parts.then(|| Spectrum::COLORS.map(lobes_of));
        let world_from_local = match material.anisotropy {
            Some(anisotropy) => frame_along(point.shading_normal, anisotropy.direction),
            None => local_frame(point.shading_normal),
        };
        let wo = world_from_local.transpose() * point.wo;
        let sharpness = if follows_rays { 1.0 } else { sharpness(bsdf.widest_roughness()) };
        let shading = Shading {
            route: place.route,
            path,
            point: &point,
            albedos: parted.as_ref().map_or_else(|| bsdf.albedos(wo), |parted| by_color(parted, wo)),
            material,
            bsdf,
            world_from_local,
            wo,
            weight,
            weight_below,
            coat,
            parted,
            behind,
            relative_ior: after / before,
            sharpness,
        };
        self.light(&shading);
        self.environment(&shading);
        self.mirror(&shading);
        self.refract(&shading);
    }

    /// Punctual lights, each behind a shadow ray.
    fn light(&mut self, shading: &Shading<'_, '_>) {
        for (subscript, light) in self.world.lights.iter().enumerate() {
            let Some(incidence) = light.incidence(shading.point.position) else { continue };
            let wi = shading.world_from_local.transpose() * incidence.wi;
            let scattered = shading.bsdf.evaluate(shading.wo, wi) * wi.z.abs();
            let mut contribution = shading.weight_below * scattered * incidence.irradiance;
            let by_coat = shading.coat.as_ref().map_or(0.0, |coat| coat.scattered(incidence.wi));
            if by_coat > 0.0 {
                contribution += shading.weight * by_coat * incidence.irradiance;
            }
            if contribution.max_element() > 0.0 {
                let span = light.shadow_span(shading.point.position);
                let end = if wi.z > 0.0 || by_coat > 0.0 {
                    shading.point.shadow_end_outside(span)
                } else {
                    shading.point.shadow_end_inside(span)
                };
                let ray = light.shadow_ray(end, shading.path.seed, subscript);
                // The volumes around a lamp are not known; those around a lit surface are.
                let media =
                    if span == Vec3::ZERO { shading.path.media.clone() } else { MediaStack::default() };
                let source = (shading.route, subscript);
                self.shadows.push(source, ray, shading.path.sample, (contribution, media));
            }
        }
    }

    /// Diffuse light from all around, and what rough lobes see of it; unoccluded but for the occlusion map.
    fn environment(&mut self, shading: &Shading<'_, '_>) {
        let environment = self.world.environment;
        let Shading { point, material, albedos, .. } = shading;
        let normal = point.shading_normal;
        let mut diffuse = albedos.diffuse * environment.irradiance(normal);
        if albedos.sheen != Vec3::ZERO {
            diffuse += albedos.sheen * environment.irradiance(normal);
        }
        if albedos.diffuse_transmission != Vec3::ZERO {
            diffuse += albedos.diffuse_transmission * environment.irradiance(-normal);
        }
        let mut radiance = diffuse * std::f32::consts::FRAC_1_PI;
        let dull = 1.0 - shading.sharpness;
        if dull > 0.0 {
            radiance += self.dull_reflection(shading) * dull;
            for (spectrum, bsdf) in shading.ways_through() {
                let through = albedos.transmission * spectrum.mask();
                if through != Vec3::ZERO
                    && let Some(direction) = bsdf.refract(shading.wo)
                {
                    let direction = shading.world_from_local * direction;
                    radiance += through * environment.prefiltered(direction, material.roughness) * dull;
                }
            }
        }
        self.add(shading.path, shading.weight_below * radiance * material.occlusion);
        if let Some(coat) = &shading.coat
            && coat.sharpness < 1.0
        {
            let seen = environment.prefiltered(coat.mirrored, coat.roughness);
            let weight = coat.albedo * (1.0 - coat.sharpness) * material.occlusion;
            self.add(shading.path, shading.weight * seen * weight);
        }
    }

    /// What the specular lobe sees of the environment.
    fn dull_reflection(&self, shading: &Shading<'_, '_>) -> Vec3 {
        let (environment, roughness) = (self.world.environment, shading.material.roughness);
        if shading.material.anisotropy.is_none() {
            let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
            return shading.albedos.specular * environment.prefiltered(mirrored, roughness);
        }
        let mut seen = Vec3::ZERO;
        for (wi, share) in shading.bsdf.stretched_reflections(shading.wo) {
            seen += share * environment.prefiltered(shading.world_from_local * wi, roughness);
        }
        seen
    }

    /// Mirror rays of the specular lobe and of the coat; one for both where they run the same way.
    fn mirror(&mut self, shading: &Shading<'_, '_>) {
        let scatters_coat = self.scatter_coat(shading);
        let scatters = self.scatter_reflection(shading);
        let mirrored = mirror_direction(shading.point.wo, shading.point.shading_normal);
        let mut weight = Vec3::ZERO;
        if !scatters {
            weight = shading.weight_below * shading.albedos.specular * shading.sharpness;
        }
        if let Some(coat) = &shading.coat
            && !scatters_coat
        {
            let weight_of_coat = shading.weight * (coat.albedo * coat.sharpness);
            if coat.mirrored == mirrored {
                weight += weight_of_coat;
            } else {
                self.send_mirrored(shading, coat.mirrored, weight_of_coat);
            }
        }
        self.send_mirrored(shading, mirrored, weight);
    }

    fn send_mirrored(&mut self, shading: &Shading<'_, '_>, direction: Vec3, weight: Vec3) {
        if self.may_send(shading.path, weight) {
            let ray = Ray::new(shading.point.origin_outside(), direction);
            let seed = shading.path.seed.child(Purpose::Reflection, 0, 1);
            let spectrum = shading.path.spectrum;
            self.send(shading, Child { ray, weight, class: PathClass::Reflection, spectrum, seed });
        }
    }

    fn refract(&mut self, shading: &Shading<'_, '_>) {
        if shading.albedos.transmission == Vec3::ZERO || self.scatter_transmission(shading) {
            return;
        }
        for (spectrum, bsdf) in shading.ways_through() {
            let weight =
                shading.weight_below * shading.albedos.transmission * shading.sharpness * spectrum.mask();
            if weight == Vec3::ZERO {
                continue;
            }
            let Some(direction) = bsdf.refract(shading.wo) else { continue };
            if !self.may_send(shading.path, weight) {
                continue;
            }
            // Thin walls and equal media leave the direction exactly as it was.
            let unbent = direction == -shading.wo;
            let direction =
                if unbent { -shading.point.wo } else { (shading.world_from_local * direction).normalize() };
            let ray = Ray::new(shading.point.origin_inside(), direction);
            let seed = shading.path.seed.child(Purpose::Refraction, 0, 1);
            self.send(shading, Child { ray, weight, class: PathClass::Refraction, spectrum, seed });
        }
    }

    /// Whether a child of `parent` would count, and is neither too deep nor too faint; else its weight is lost.
    pub(super) fn may_send(&mut self, parent: &Path, weight: Vec3) -> bool {
        let largest = weight.max_element();
        if largest == 0.0 {
            return false;
        }
        // Of many rays each counts little.
        let least = LEAST_WEIGHT / self.world.settings.glossy_samples.max(1) as f32;
        if parent.depth >= self.world.settings.max_depth || largest < least {
            self.statistics.dropped_weight += f64::from(largest);
            return false;
        }
        true
    }

    /// Makes a child ray.
    pub(super) fn send(&mut self, shading: &Shading<'_, '_>, child: Child) {
        let Child { ray, weight, class, spectrum, seed } = child;
        let parent = shading.path;
        let (posed, point) = (self.world.posed, shading.point);
        let (media, touching, footprint) = match class {
            PathClass::Refraction => (
                shading.behind.media.clone(),
                shading.behind.touching,
                point.refracted_footprint(posed, &parent.footprint, ray.direction, shading.relative_ior),
            ),
            PathClass::Camera | PathClass::Reflection => {
                (parent.media.clone(), None, point.reflected_footprint(posed, &parent.footprint))
            }
        };
        let depth = parent.depth + 1;
        let path = Path { footprint, media, touching, weight, class, spectrum, depth, seed, ..*parent };
        self.children.push(shading.route.then(class), ray, path);
    }

    /// What lies behind a surface that lets light through. A refracted ray starts beyond every face that touches this one,
    /// so all of their volumes are crossed here, up to the first surface that is none.
    fn behind(&mut self, path: &Path, point: &SurfacePoint<'_>, material: &MaterialSample) -> Behind {
        let posed = self.world.posed;
        let mut behind = Behind { media: path.media.clone(), touching: None };
        let medium = self.world.interiors.medium(point.shape);
        if let Some(medium) = medium {
            behind.media.cross(medium, point.facing);
        } else if material.transmission == 0.0 {
            return behind;
        }
        // From the start of mirrored rays to that of refracted ones.
        let start = point.origin_outside();
        let probe = Ray { t_max: 1.0, ..Ray::new(start, point.origin_inside() - start) };
        let there = |hit: &Hit| alpha_at(posed, hit) > 0.0 && !catches_shadows(posed, hit);
        let (bvh, touching) = (self.world.bvh, &mut self.touching);
        touching.clear();
        let collect = |hit: &Hit| {
            if there(hit) {
                touching.add(0, hit);
            }
            false
        };
        if bvh.occluded(&probe, collect, &mut self.counters) || touching.is_overfull() {
            // Solid surfaces were not collected: one query for each.
            let one = |after| bvh.closest_surface(&probe, after, there, &mut self.counters);
            cross_touching(self.world, &mut behind, point, one);
        } else {
            touching.sort(|_| true);
            cross_touching(self.world, &mut behind, point, touching.along(0));
        }
        behind
    }
}

/// Crosses the volumes that touch at `point` behind its own, up to the first surface that is none. `next` gives the
/// surfaces between the two sides.
fn cross_touching(
    world: &World<'_>,
    behind: &mut Behind,
    point: &SurfacePoint<'_>,
    mut next: impl FnMut(Option<HitOrder>) -> Option<Hit>,
) {
    let frame = world.posed.frame;
    let mut after = None;
    while let Some(hit) = next(after) {
        after = Some(hit.order());
        let shape = frame.shape(hit.primitive);
        // This surface itself, or a neighbour beside whose edge the point lies.
        if std::ptr::eq(shape, point.shape) && hit.facing == point.facing {
            continue;
        }
        let flags = frame.flags[hit.primitive as usize];
        match world.interiors.medium(shape) {
            Some(medium) => behind.media.cross(medium, hit.facing),
            None if hit.facing == Facing::Back && flags.has(PrimitiveFlags::SINGLE_SIDED) => {}
            None => {
                behind.touching = Some(Hit { t: 0.0, ..hit });
                break;
            }
        }
    }
}

/// What lies behind a surface.
struct Behind {
    /// The volumes there.
    media: MediaStack,
    /// A surface that bounds no volume and touches this one.
    touching: Option<Hit>,
}

/// Index of refraction on the viewer's side. A back face of a volume is seen from within, even where the surface is not
/// closed and the ray never entered.
fn ior_before(path: &Path, inside: Option<Medium>, facing: Facing, spectrum: Spectrum) -> f32 {
    match inside {
        Some(medium) if facing == Facing::Back && !path.media.holds(medium.volume) => medium.ior_of(spectrum),
        _ => path.media.ior(spectrum),
    }
}

/// Index of refraction behind the surface: what fills the space there, or for walls and solids the material's own.
fn ior_behind(material: &MaterialSample, media_behind: &MediaStack, spectrum: Spectrum) -> f32 {
    if material.thin { material.ior } else { media_behind.ior(spectrum) }
}

/// The mirror ray, geometrically above the surface thanks to the bent normal.
pub(super) fn mirror_direction(wo: Vec3, normal: Vec3) -> Vec3 {
    (normal * (2.0 * wo.dot(normal)) - wo).normalize()
}

/// An orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
pub(super) fn local_frame(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

/// A frame around a unit normal whose first axis runs along a direction as far as it can.
fn frame_along(normal: Vec3, direction: Vec3) -> Mat3 {
    match unit(direction - normal * normal.dot(direction)) {
        Some(tangent) => Mat3::from_cols(tangent, normal.cross(tangent), normal),
        None => local_frame(normal),
    }
}

/// Share of a lobe that rays follow.
pub(super) fn sharpness(roughness: f32) -> f32 {
    1.0 - smoothstep(SHARP_ROUGHNESS, DULL_ROUGHNESS, roughness)
}

/// The albedos of each colour's own lobes.
fn by_color(parted: &[Bsdf; 3], wo: Vec3) -> Albedos {
    let mut sum = Albedos::default();
    for (bsdf, spectrum) in parted.iter().zip(Spectrum::COLORS) {
        let (albedos, mask) = (bsdf.albedos(wo), spectrum.mask());
        sum.specular += albedos.specular * mask;
        sum.diffuse += albedos.diffuse * mask;
        sum.transmission += albedos.transmission * mask;
        sum.diffuse_transmission += albedos.diffuse_transmission * mask;
        sum.sheen += albedos.sheen * mask;
    }
    sum
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let s = ((x - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
