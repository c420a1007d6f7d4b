//! Light behind shadow rays: that of the queued rays which arrives.

use std::time::Instant;

use glam::Vec3;

use super::shadow_queue::{ShadowQueue, ShadowTask};
use super::tracer::{Tracer, seconds_since};
use crate::integrator::clamp::clamped;

impl Tracer<'_, '_> {
    /// Traces the queued shadow rays and adds the light that arrives.
    pub(super) fn trace_shadows(&mut self) {
        // Opaque surfaces, batch by batch
        let start = Instant::now();
        for batch in self.shadows.batches.iter_mut().filter(|batch| !batch.is_empty()) {
            batch.trace(self.context, &mut self.counters);
        }
        self.statistics.query_seconds += seconds_since(start);

        // What stopped those to the environment
        self.add_occluder_light();

        // Transparent surfaces and sums, in the order of tasks
        let ShadowQueue { batches, tasks, .. } = &mut self.shadows;
        self.statistics.shadow_rays += tasks.len() as u64;
        for task in tasks.drain(..) {
            let ShadowTask { sample, light_pass, batch, ray, contribution, for_hidden, environment_clamp } =
                task;
            let batch = &batches[batch as usize];
            let shadow = batch.transmittance(self.context, ray, &mut self.counters);
            self.statistics.transparency_limit_reached += u64::from(shadow.limit_reached);
            if for_hidden != Vec3::ZERO && shadow.hidden != Vec3::ONE {
                let absorbed = for_hidden * (Vec3::ONE - shadow.transmittance - shadow.hidden);
                self.values[sample as usize].radiance -= absorbed;
                self.aovs.add(sample, light_pass, -absorbed);
            }
            if shadow.transmittance == Vec3::ZERO {
                continue;
            }
            let mut arriving = contribution * shadow.transmittance;
            if let Some(limit) = environment_clamp {
                let radiance = self.context.view.environment.radiance(batch.direction(ray));
                arriving = clamped(arriving * radiance, limit);
            }
            self.values[sample as usize].radiance += arriving;
            self.aovs.add(sample, light_pass, arriving);
        }
        for batch in batches {
            batch.clear();
        }
    }
}
