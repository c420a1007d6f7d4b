//! What one surface sends back along a ray: its own light, lights, the environment, and the rays it sends on.

use glam::{Mat3, Vec3};

use super::generation::{Generation, Route};
use super::sight::Sight;
use super::{LEAST_WEIGHT, Tracer};
use crate::bsdf::{Albedos, Bsdf};
use crate::bvh::{Hit, HitOrder, PrimitiveFlags};
use crate::geometry::{Facing, Ray};
use crate::integrator::random::Purpose;
use crate::integrator::{Footprint, MediaStack, Medium, Path, PathClass, World};
use crate::interaction::{MaterialSample, SurfacePoint, alpha_at, material_at};

/// Below this roughness a lobe is followed by rays only.
const SHARP_ROUGHNESS: f32 = 0.1;
/// Above this roughness a lobe only looks the environment up.
const DULL_ROUGHNESS: f32 = 0.4;

/// A surface with its lobes, seen by one ray.
struct Shading<'p, 'a> {
    /// How the ray came about.
    route: Route,
    ray: &'p Ray,
    path: &'p Path,
    point: &'p SurfacePoint<'a>,
    material: MaterialSample,
    bsdf: Bsdf,
    /// Of the lobes, as seen by the ray.
    albedos: Albedos,
    /// Columns are tangent, bitangent and normal.
    world_from_local: Mat3,
    wo: Vec3,
    /// What radiance that leaves towards the eye counts for.
    weight: Vec3,
    /// What lies on the other side.
    behind: Behind,
    /// Share of each lobe that rays follow; the environment lookup has the rest.
    sharpness: f32,
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
        let point = SurfacePoint::new(posed, ray, hit, path.footprint.width_at(hit.t));
        let material = material_at(posed, &point);
        let weight = path.weight * path.media.transmittance(hit.t) * *share;
        if material.unlit {
            self.add(path, weight * material.base_color);
            return;
        }
        self.add(path, weight * material.emission);

        let behind = self.behind(path, &point, &material);
        let bsdf = Bsdf::new(
            &material,
            ior_before(path, self.world.interiors.medium(point.shape), point.facing),
            ior_behind(&material, &behind.media),
        );
        let world_from_local = local_frame(point.shading_normal);
        let wo = world_from_local.transpose() * point.wo;
        let sharpness = 1.0 - smoothstep(SHARP_ROUGHNESS, DULL_ROUGHNESS, material.roughness);
        let shading = Shading {
            route: place.route,
            ray,
            path,
            point: &point,
            albedos: bsdf.albedos(wo.z),
            material,
            bsdf,
            world_from_local,
            wo,
            weight,
            behind,
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
            let contribution = shading.weight * scattered * incidence.irradiance;
            if contribution.max_element() > 0.0 {
                let span = light.shadow_span(shading.point.position);
                let end = if wi.z > 0.0 {
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
        let Shading { point, material, bsdf, albedos, wo, .. } = shading;
        let irradiance = environment.irradiance(point.shading_normal);
        let mut radiance = albedos.diffuse * irradiance * std::f32::consts::FRAC_1_PI;
        let dull = 1.0 - shading.sharpness;
        if dull > 0.0 {
            let mirrored = mirror_direction(point);
            radiance += albedos.specular * environment.prefiltered(mirrored, material.roughness) * dull;
            let through = albedos.transmission;
            if through != Vec3::ZERO
                && let Some(direction) = bsdf.refract(*wo)
            {
                let direction = shading.world_from_local * direction;
                radiance += through * environment.prefiltered(direction, material.roughness) * dull;
            }
        }
        self.add(shading.path, shading.weight * radiance * material.occlusion);
    }

    fn mirror(&mut self, shading: &Shading<'_, '_>) {
        let weight = shading.weight * shading.albedos.specular * shading.sharpness;
        if self.may_send(shading.path, weight) {
            let ray = Ray::new(shading.point.origin_outside(), mirror_direction(shading.point));
            self.send(shading, ray, weight, PathClass::Reflection);
        }
    }

    fn refract(&mut self, shading: &Shading<'_, '_>) {
        let weight = shading.weight * shading.albedos.transmission * shading.sharpness;
        if weight == Vec3::ZERO {
            return;
        }
        let Some(direction) = shading.bsdf.refract(shading.wo) else { return };
        if !self.may_send(shading.path, weight) {
            return;
        }
        // Thin walls and equal media leave the direction exactly as it was.
        let unbent = direction == -shading.wo;
        let direction =
            if unbent { -shading.point.wo } else { (shading.world_from_local * direction).normalize() };
        let ray = Ray::new(shading.point.origin_inside(), direction);
        self.send(shading, ray, weight, PathClass::Refraction);
    }

    /// Whether a child of `parent` would count, and is neither too deep nor too faint; else its weight is lost.
    fn may_send(&mut self, parent: &Path, weight: Vec3) -> bool {
        let largest = weight.max_element();
        if largest == 0.0 {
            return false;
        }
        if parent.depth >= self.world.settings.max_depth || largest < LEAST_WEIGHT {
            self.statistics.dropped_weight += f64::from(largest);
            return false;
        }
        true
    }

    /// Makes a child ray.
    fn send(&mut self, shading: &Shading<'_, '_>, ray: Ray, weight: Vec3, class: PathClass) {
        let parent = shading.path;
        let travelled = (shading.point.position - shading.ray.origin).length();
        let footprint = Footprint { width: parent.footprint.width_at(travelled), ..parent.footprint };
        let (media, touching) = match class {
            PathClass::Refraction => (shading.behind.media.clone(), shading.behind.touching),
            PathClass::Camera | PathClass::Reflection => (parent.media.clone(), None),
        };
        let depth = parent.depth + 1;
        let purpose = match class {
            PathClass::Refraction => Purpose::Refraction,
            PathClass::Camera | PathClass::Reflection => Purpose::Reflection,
        };
        let seed = parent.seed.child(purpose, 0, 1);
        let path = Path { footprint, media, touching, weight, class, depth, seed, ..*parent };
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
        let there = |hit: &Hit| alpha_at(posed, hit) > 0.0;
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
fn ior_before(path: &Path, inside: Option<Medium>, facing: Facing) -> f32 {
    match inside {
        Some(medium) if facing == Facing::Back && !path.media.holds(medium.volume) => medium.ior,
        _ => path.media.ior(),
    }
}

/// Index of refraction behind the surface: what fills the space there, or for walls and solids the material's own.
fn ior_behind(material: &MaterialSample, media_behind: &MediaStack) -> f32 {
    if material.thin { material.ior } else { media_behind.ior() }
}

/// The mirror ray, geometrically above the surface thanks to the bent shading normal.
fn mirror_direction(point: &SurfacePoint<'_>) -> Vec3 {
    let normal = point.shading_normal;
    (normal * (2.0 * point.wo.dot(normal)) - point.wo).normalize()
}

/// An orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn local_frame(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let s = ((x - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
