//! Tracing the rays of a batch: at once, or in parts where they have more transparent surfaces than are kept.

use std::cell::Cell;
use std::ops::Range;

use super::{Occlusion, ShadowBatch, ShadowTransmittance, occlusion};
use crate::bvh::{Hit, TraversalCounters};
use crate::integrator::IntegratorContext;

impl ShadowBatch {
    /// Looks for opaque surfaces along all rays and collects the transparent ones.
    pub(in crate::integrator) fn trace(
        &mut self,
        context: &IntegratorContext<'_>,
        counters: &mut TraversalCounters,
    ) {
        let all = 0..self.rays.len();
        self.is_occluded.resize(all.end, false);
        self.is_tinted.clear();
        self.is_tinted.resize(all.end, Cell::new(false));
        self.found_in_parts.clear();
        self.collect(context, all.clone(), counters);
        if self.transparent_hits.is_overfull() && all.len() > 1 {
            self.found_in_parts.resize(all.end, ShadowTransmittance::NONE);
            self.trace_in_parts(context, all, counters);
        }
    }

    /// Looks for opaque surfaces along some of the rays and replaces the collected surfaces by theirs.
    fn collect(
        &mut self,
        context: &IntegratorContext<'_>,
        part: Range<usize>,
        counters: &mut TraversalCounters,
    ) {
        let Self { passage, rays, is_occluded, is_tinted, transparent_hits, .. } = self;
        self.first_collected = part.start as u32;
        let (rays, is_tinted) = (&rays[part.clone()], &is_tinted[part.clone()]);
        let is_occluded = &mut is_occluded[part];
        transparent_hits.clear();
        let solid = |index: usize, hit: &Hit| match occlusion(context, hit, *passage) {
            Occlusion::Opaque => true,
            Occlusion::Transparent => {
                is_tinted[index].set(true);
                transparent_hits.add(index, hit);
                false
            }
            Occlusion::Absent => false,
        };
        context.view.bvh.occluded_rays(rays, solid, is_occluded, counters);
        transparent_hits.sort(rays.len(), |index| !is_occluded[index]);
    }

    /// Finds the transmittances of rays of which more transparent surfaces were collected than are kept: in parts with fewer, so that no ray but
    /// one which has too many alone needs a query for each of its surfaces.
    fn trace_in_parts(
        &mut self,
        context: &IntegratorContext<'_>,
        rays: Range<usize>,
        counters: &mut TraversalCounters,
    ) {
        // Rays have unequal numbers of surfaces.
        let least_parts = self.transparent_hits.least_parts();
        let part_rays = rays.len().div_ceil(least_parts + least_parts.div_ceil(4));
        for first in rays.clone().step_by(part_rays) {
            let part = first..rays.end.min(first + part_rays);
            self.collect(context, part.clone(), counters);
            if self.transparent_hits.is_overfull() && part.len() > 1 {
                self.trace_in_parts(context, part, counters);
                continue;
            }
            for index in part {
                self.found_in_parts[index] = self.collected_transmittance(context, index as u32, counters);
            }
        }
    }
}
