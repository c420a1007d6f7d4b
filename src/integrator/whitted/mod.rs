//! Whitted's recursive ray tracer (Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980).
//!
//! [`super::tracing`] follows the rays; here is what surfaces do with them.
//!
//! There is no ambient term. Smooth lobes are followed by mirror and refraction rays, rough lobes look up the prefiltered
//! environment, and in between both are blended by roughness. Shadow rays towards the environment take sampled directions, as do
//! lenses, sized lights and glossy samples. Frosted glass sends one sampled ray, or one by a sampled facet (`frosted_glass`), and rough metals
//! without an environment another (`rough_reflection`). Nothing else is random.

mod block_lookups;
mod buffers;
mod coat;
mod direct_light;
mod environment;
mod environment_lookup;
mod environment_shadows;
mod frosted_glass;
mod glossy;
mod lamps_through_glass;
mod lookup_keys;
mod lookup_rays;
mod occluder_buffers;
mod occluder_light;
mod occluder_surface;
mod opaque_block;
mod reflected_environment;
mod reflected_lobe;
mod rough_reflection;
mod sampled_lookups;
mod secondary_rays;
mod shade;
mod shade_block;
mod shading;
mod traced_share;
mod untraced_transmittance;

pub(super) use buffers::WhittedBuffers;
