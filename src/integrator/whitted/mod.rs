//! Whitted's recursive ray tracer (Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980), breadth first.
//!
//! A batch of samples is traced in wavefronts, one for each depth: closest hits of all rays, shadows on the ground and on shadow
//! catchers, shading, all other shadow rays, and child rays with their weights, which are the next wavefront. A sample sums weight · radiance in the order of wavefronts
//! and, within one, in the order of its own rays. So its value does not depend on the other samples of the batch.
//!
//! Each batch query of the hierarchy holds rays of one kind: closest hits by ray signature, shadow rays by signature and light,
//! those of the ground and of catchers by light.
//! Neighbours in a batch are neighbours on screen as far as the camera rays were.
//!
//! There is no ambient term. Smooth lobes are followed by mirror and refraction rays, rough lobes look up the prefiltered
//! environment, and in between both are blended by roughness. Shadow rays towards the environment take sampled directions, as do
//! lenses, sized lights and glossy samples; nothing else is random.

mod block_lookups;
mod camera_hits;
mod coat;
mod direct_light;
mod environment;
mod environment_lookup;
mod environment_shadows;
mod frosted_glass;
mod glossy;
mod ground;
mod lamps_through_glass;
mod least_weights;
mod lookup_keys;
mod occluder_buffers;
mod occluder_light;
mod opaque_block;
mod receiver_shadows;
mod receivers;
mod reflected_environment;
mod reflected_lobe;
mod rough_reflection;
mod secondary_rays;
mod shade;
mod shade_block;
mod shading;
mod shading_order;
mod shadow_catcher;
mod shadow_queue;
mod touching_surfaces;
mod traced_share;
mod tracer;
mod transmission_probes;
mod untraced_transmittance;
mod visibility;

pub(super) use shadow_queue::ShadowRay;
pub use tracer::{SampleValue, Tracer};

#[cfg(test)]
pub(super) mod tests;
