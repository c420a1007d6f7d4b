//! Measured traces of hierarchies.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use rayframe::bvh::{Bvh, TraversalCounters};
use rayframe::geometry::Ray;

use crate::chunks::{best_seconds, processor_seconds};
use crate::ray_set::Query;

/// Measurements; the best counts.
const RUNS: usize = 3;
/// Rays per batch: a tile of 16x16 pixels if rays are in Z order.
pub const BATCH: usize = 256;
/// Answer of a miss.
const MISS: u32 = u32::MAX;

/// Time and counters of a trace.
pub struct Traced {
    /// Processor seconds over threads.
    pub seconds: f64,
    /// Rays that hit something.
    pub hits: usize,
    /// Counters of one pass over all rays.
    pub counters: TraversalCounters,
    rays: usize,
}

impl Traced {
    /// Millions of rays per second.
    pub fn mega_rays(&self) -> f64 {
        self.rays as f64 / self.seconds / 1e6
    }
}

/// Traces every ray by itself.
pub fn single(bvh: &Bvh, rays: &[Ray], query: Query, threads: usize) -> Traced {
    measure(rays, threads, |rays, ids, counters| {
        for (ray, id) in rays.iter().zip(ids) {
            let answer = match query {
                Query::Closest => {
                    bvh.closest_hit(ray, None, |_| true, counters).map_or(MISS, |hit| hit.triangle)
                }
                Query::Occluded => {
                    if bvh.occluded(ray, |_| true, counters) {
                        0
                    } else {
                        MISS
                    }
                }
            };
            id.store(answer, Ordering::Relaxed);
        }
    })
}

/// Traces [`BATCH`] consecutive rays at a time. Each batch is first copied to a small buffer, where a renderer would create it, so that
/// main memory is not measured.
pub fn batches(bvh: &Bvh, rays: &[Ray], query: Query, threads: usize) -> Traced {
    measure(rays, threads, |rays, ids, counters| {
        let mut buffer = [Ray::new(Vec3::ZERO, Vec3::X); BATCH];
        let mut hits = [None; BATCH];
        let mut occluded = [false; BATCH];
        for (rays, ids) in rays.chunks(BATCH).zip(ids.chunks(BATCH)) {
            let buffer = &mut buffer[..rays.len()];
            buffer.copy_from_slice(rays);
            match query {
                Query::Closest => {
                    bvh.closest_hits(buffer, |_, _| true, &mut hits[..rays.len()], counters);
                    for (hit, id) in hits.iter().zip(ids) {
                        id.store(hit.map_or(MISS, |hit| hit.triangle), Ordering::Relaxed);
                    }
                }
                Query::Occluded => {
                    bvh.occluded_rays(buffer, |_, _| true, &mut occluded[..rays.len()], counters);
                    for (occluded, id) in occluded.iter().zip(ids) {
                        id.store(if *occluded { 0 } else { MISS }, Ordering::Relaxed);
                    }
                }
            }
        }
    })
}

fn measure(
    rays: &[Ray],
    threads: usize,
    trace: impl Fn(&[Ray], &[AtomicU32], &mut TraversalCounters) + Sync,
) -> Traced {
    let ids: Vec<AtomicU32> = rays.iter().map(|_| AtomicU32::new(MISS)).collect();
    let sum = Mutex::new(TraversalCounters::default());
    let mut runs = 0;
    let seconds = best_seconds(RUNS, || {
        runs += 1;
        processor_seconds(threads, rays.len(), |range| {
            let mut counters = TraversalCounters::default();
            trace(&rays[range.clone()], &ids[range], &mut counters);
            if let Ok(mut sum) = sum.lock() {
                sum.rays += counters.rays;
                sum.nodes += counters.nodes;
                sum.triangles += counters.triangles;
            }
        })
    });
    let hits = ids.iter().filter(|id| id.load(Ordering::Relaxed) != MISS).count();
    let sum = sum.into_inner().unwrap_or_default();
    let counters =
        TraversalCounters { rays: sum.rays / runs, nodes: sum.nodes / runs, triangles: sum.triangles / runs };
    Traced { seconds, hits, counters, rays: rays.len() }
}
