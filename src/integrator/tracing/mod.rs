//! Tracing of batches of samples, breadth first.
//!
//! A batch of samples is traced in wavefronts, one for each depth: closest hits of all rays, shadows on the ground and on shadow
//! catchers, shading, all other shadow rays, and child rays with their weights, which are the next wavefront. A sample sums weight · radiance in the order of wavefronts
//! and, within one, in the order of its own rays. So its value does not depend on the other samples of the batch.
//!
//! Each batch query of the hierarchy holds rays of one kind: closest hits by ray signature, shadow rays by signature and light,
//! those of the ground and of catchers by light.
//! Neighbours in a batch are neighbours on screen as far as the camera rays were.
//!
//! What a surface does, [`super::whitted`] and [`super::path`] say: which shadow rays it queues, and which rays go on.

mod camera_hits;
mod ground;
mod receiver_shadows;
mod receivers;
mod shade_surfaces;
mod shading_order;
mod shadow_catcher;
mod shadow_light;
mod shadow_queue;
mod touching_surfaces;
mod tracer;
mod transmission_probes;
mod visibility;

pub(super) use shadow_queue::{ShadowRay, ShadowTask};
pub(super) use tracer::seconds_since;
pub use tracer::{SampleValue, Tracer};

#[cfg(test)]
pub(super) mod tests;
