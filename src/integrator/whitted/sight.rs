//! What the rays of a generation see: surfaces, through see-through ones too, or what surrounds the scene.

use std::time::Instant;

use super::generation::{Generation, Place};
use super::{LEAST_WEIGHT, Tracer, seconds_since};
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::integrator::{LightPass, PASS_THROUGH_LIMIT, Path, PathClass};
use crate::interaction::{alpha_at, catches_shadows};

/// A surface that a ray sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// The ray.
    pub(super) place: Place,
    pub(super) hit: Hit,
    /// Share of the ray that see-through surfaces in front and the surface's own coverage leave.
    pub(super) share: f32,
    /// See [`Path::part`]; what lies behind see-through surfaces is a part by itself.
    pub(super) part: Option<LightPass>,
}

impl Tracer<'_, '_> {
    /// Finds everything that a generation sees, in the order of rays and along each ray.
    pub(super) fn find_sights(&mut self, generation: &mut Generation) {
        // First hits, all rays of a kind at once
        let posed = self.world.posed;
        let start = Instant::now();
        generation.find_hits(self.world.bvh, |hit| alpha_at(posed, hit) > 0.0, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);

        // What follows from them, ray by ray
        self.sights.clear();
        for &place in generation.in_order() {
            let (ray, path) = generation.ray(place);
            let first = path.touching.or(generation.hit(place));
            match path.class {
                PathClass::Camera => {
                    self.statistics.camera_rays += 1;
                    self.statistics.camera_hits += u64::from(first.is_some());
                }
                PathClass::Reflection => self.statistics.reflection_rays += 1,
                PathClass::Refraction => self.statistics.refraction_rays += 1,
            }
            self.follow(place, (ray, path), first);
        }
    }

    /// Follows one ray from its first hit through see-through surfaces up to a solid one or out of the scene.
    fn follow(&mut self, place: Place, (ray, path): (&Ray, &Path), first: Option<Hit>) {
        let posed = self.world.posed;
        let weight = path.weight.max_element();
        let mut through = 1.0_f32;
        let mut part = path.part;
        let mut next = first;
        for _ in 0..PASS_THROUGH_LIMIT {
            let Some(hit) = next else {
                return self.escape((ray, path), through, part);
            };
            let alpha = if catches_shadows(posed, &hit) {
                self.caught_shadow(ray, path, &hit)
            } else {
                let alpha = alpha_at(posed, &hit);
                let sight = Sight { place, hit, share: through * alpha, part };
                self.records.cover(posed, path, &sight);
                self.sights.push(sight);
                part = part.or(Some(LightPass::Transparency));
                alpha
            };
            through *= 1.0 - alpha;
            if weight * through < LEAST_WEIGHT {
                self.statistics.dropped_weight += f64::from(weight * through);
                return self.cover(path, 1.0);
            }
            let there = |hit: &Hit| alpha_at(posed, hit) > 0.0;
            next = self.world.bvh.closest_hit(ray, Some(hit.order()), there, &mut self.counters);
        }
        self.statistics.pass_through_limit_reached += 1;
        self.cover(path, 1.0);
    }

    /// What is left of a ray leaves the scene.
    fn escape(&mut self, (ray, path): (&Ray, &Path), through: f32, part: Option<LightPass>) {
        if path.class == PathClass::Camera && !self.world.settings.show_background {
            return self.cover(path, 1.0 - through);
        }
        let weight = path.weight * path.media.transmittance(f32::INFINITY) * through;
        let environment = self.world.environment;
        let turns = path.footprint.direction;
        let radiance = match path.class {
            PathClass::Camera => environment.background_over(ray.direction, turns),
            PathClass::Reflection | PathClass::Refraction => environment.radiance_over(ray.direction, turns),
        };
        self.add(path.sample, part.unwrap_or(LightPass::Environment), weight * radiance);
        self.cover(path, 1.0);
    }

    fn cover(&mut self, path: &Path, coverage: f32) {
        if path.class == PathClass::Camera {
            self.values[path.sample as usize].coverage = coverage;
        }
    }
}
