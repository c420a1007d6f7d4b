//! Tracing single rays through obvhs's structures with its triangle for processors.

use std::sync::atomic::{AtomicU32, Ordering};

use obvhs::ray::{Ray, RayHit};

use crate::chunks::{best_seconds, processor_seconds};
use crate::obvhs_build::{Nodes, Tree};
use crate::ray_set::{Query, RaySet};

/// Measurements, of which the best counts.
const RUNS: usize = 3;
/// The answer that nothing was hit.
const MISS: u32 = u32::MAX;

/// Rays in the library's form, reciprocal directions included.
pub(crate) fn rays(set: &RaySet) -> Vec<Ray> {
    let convert = |ray: &rayframe::geometry::Ray| {
        let [origin, direction] =
            [ray.origin, ray.direction].map(|vector| glam_simd::Vec3A::from(vector.to_array()));
        Ray::new(origin, direction, ray.t_min, ray.t_max)
    };
    set.rays.iter().map(convert).collect()
}

/// Millions of rays a second and how many hit.
pub(crate) fn single(tree: &Tree, rays: &[Ray], query: Query, threads: usize) -> (f64, usize) {
    let ids: Vec<AtomicU32> = rays.iter().map(|_| AtomicU32::new(MISS)).collect();
    let seconds = best_seconds(RUNS, || {
        processor_seconds(threads, rays.len(), |range| {
            for (ray, id) in rays[range.clone()].iter().zip(&ids[range]) {
                let answer = match query {
                    Query::Closest => tree.closest(*ray),
                    Query::Occluded => tree.occluded(*ray),
                };
                id.store(answer, Ordering::Relaxed);
            }
        })
    });
    let hits = ids.iter().filter(|id| id.load(Ordering::Relaxed) != MISS).count();
    (rays.len() as f64 / seconds / 1e6, hits)
}

impl Tree {
    /// The place of the closest triangle in the order of leaves.
    #[inline]
    fn closest(&self, ray: Ray) -> u32 {
        let mut hit = RayHit::none();
        let meet = |ray: &Ray, place: usize| self.triangles[place].intersect(ray);
        let found = match &self.nodes {
            Nodes::Binary(binary) => binary.ray_traverse(ray, &mut hit, meet),
            Nodes::Compressed(compressed) => compressed.ray_traverse(ray, &mut hit, meet),
        };
        if found { hit.primitive_id } else { MISS }
    }

    #[inline]
    fn occluded(&self, ray: Ray) -> u32 {
        let meet = |ray: &Ray, place: usize| self.triangles[place].intersect(ray);
        let missed = match &self.nodes {
            Nodes::Binary(binary) => binary.ray_traverse_miss(ray, meet),
            Nodes::Compressed(compressed) => compressed.ray_traverse_miss(ray, meet),
        };
        if missed { MISS } else { 0 }
    }
}
