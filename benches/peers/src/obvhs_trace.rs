//! Single-ray traces of obvhs, with its triangle type for CPUs.

use std::sync::atomic::{AtomicU32, Ordering};

use obvhs::ray::{Ray, RayHit};

use crate::chunks::{best_seconds, processor_seconds};
use crate::obvhs_build::{Nodes, Tree};
use crate::ray_set::{Query, RaySet};

/// Measurements; the best counts.
const RUNS: usize = 3;
/// Answer of a miss.
const MISS: u32 = u32::MAX;

/// Converts rays to those of obvhs, with reciprocal directions.
pub fn rays(set: &RaySet) -> Vec<Ray> {
    let convert = |ray: &rayframe::geometry::Ray| {
        let [origin, direction] =
            [ray.origin, ray.direction].map(|vector| glam_simd::Vec3A::from(vector.to_array()));
        Ray::new(origin, direction, ray.t_min, ray.t_max)
    };
    set.rays.iter().map(convert).collect()
}

/// Millions of rays per second, and number of hits.
pub fn single(tree: &Tree, rays: &[Ray], query: Query, threads: usize) -> (f64, usize) {
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
    /// Position of the closest triangle in the order of leaves.
    #[inline]
    fn closest(&self, ray: Ray) -> u32 {
        let mut hit = RayHit::none();
        let intersect = |ray: &Ray, position: usize| self.triangles[position].intersect(ray);
        let found = match &self.nodes {
            Nodes::Binary(binary) => binary.ray_traverse(ray, &mut hit, intersect),
            Nodes::Compressed(compressed) => compressed.ray_traverse(ray, &mut hit, intersect),
        };
        if found { hit.primitive_id } else { MISS }
    }

    #[inline]
    fn occluded(&self, ray: Ray) -> u32 {
        let intersect = |ray: &Ray, position: usize| self.triangles[position].intersect(ray);
        let missed = match &self.nodes {
            Nodes::Binary(binary) => binary.ray_traverse_miss(ray, intersect),
            Nodes::Compressed(compressed) => compressed.ray_traverse_miss(ray, intersect),
        };
        if missed { MISS } else { 0 }
    }
}
