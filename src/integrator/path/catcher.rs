//! Light of the environment on shadow catchers and the ground.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::bsdf::cosine_direction;
use crate::color::luminance;
use crate::integrator::Integrator;
use crate::integrator::whitted::{Receiver, Tracer, local_frame};

/// Directions of each kind among which one is chosen.
const CANDIDATES: u32 = 4;

impl Tracer<'_, '_> {
    /// A direction from which light of the environment reaches a receiver; `None` where none does. Its density is nearly that of the light: one of
    /// several candidates is chosen by their light (Talbot, Cline and Egbert, "Importance Resampling for Global Illumination", 2005), half of them
    /// sampled by the environment, half by the cosine.
    pub(in crate::integrator) fn environment_direction(&self, receiver: &Receiver) -> Option<Vec3> {
        if self.context.settings.integrator != Integrator::Path {
            return None;
        }
        let environment = self.context.view.environment;
        let world_from_local = local_frame(receiver.normal);
        let point = |number| receiver.environment_point(self.context.lights.len(), number);
        let (mut u, mut sum, mut chosen) = (point(0).x, 0.0_f32, None);
        for number in 1..=2 * CANDIDATES {
            let point = point(number);
            let wi = if number % 2 == 0 {
                world_from_local * cosine_direction(point)
            } else if let Some((wi, _)) = environment.sample(point) {
                wi
            } else {
                continue;
            };
            let cosine = wi.dot(receiver.normal);
            let pdf = cosine * FRAC_1_PI + environment.pdf(wi);
            if cosine <= 0.0 {
                continue;
            }
            let weight = luminance(environment.radiance(wi)) * cosine / pdf;
            if !(weight > 0.0 && weight < f32::INFINITY) {
                continue;
            }
            sum += weight;
            let probability = weight / sum;
            if u < probability {
                chosen = Some(wi);
                u /= probability;
            } else {
                u = (u - probability) / (1.0 - probability);
            }
        }
        chosen
    }
}
