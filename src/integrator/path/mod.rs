//! Path tracing (Kajiya, "The Rendering Equation", SIGGRAPH 1986): light that bounces, and shadows of environments.
//!
//! Rays are followed by [`super::tracing`], through the same transparent surfaces and media as those of Whitted's tree, and the material model is the
//! same. What differs is what a surface does: it sends one ray, sampled among all of its lobes, and one shadow ray to each kind of light.
//!
//! * **Lights that rays can hit**, the environment and emissive triangles, are found in two ways: by shadow rays to sampled points (next-event
//!   estimation) and by the sampled rays. Both are weighted by the power heuristic (Veach, "Robust Monte Carlo Methods for Light
//!   Transport Simulation", 1997, section 9.2).
//! * **Lights that rays cannot hit**, those of `KHR_lights_punctual` and key lights, are found by shadow rays alone, which pass glass straight, as in
//!   Whitted's tree. Shadow rays to the other lights end at glass, except at clear thin walls; the sampled rays bring the light that glass bends.
//! * **Light that mirrors and glass focus** is found by sampled rays alone, which photons guide.
//! * Paths end by Russian roulette on the weight that they would have without guiding, so that the mean stays what it is; once
//!   they were guided, not in mirrors and clear glass.
//!
//! A sample's numbers are points of one sequence (`zsobol`), by (pixel, sample, dimension): they do not depend on batches and threads.

mod buffers;
mod coverage;
mod dimensions;
mod emission;
mod emissive_triangles;
mod emitter_covers;
mod emitters;
mod guided_direction;
mod guiding;
mod mis;
mod next_event;
mod normal_axis;
mod path_block;
mod photon_tracing;
mod scatter;
mod shade;
mod shaded_point;
mod triangle_part;
mod visible_environment;

pub(super) use buffers::PathBuffers;
pub(super) use emissive_triangles::EmissiveTriangles;
pub(super) use guiding::PathGuide;
pub(crate) use guiding::most_photon_bytes;
pub(super) use visible_environment::{VisibleEntry, VisibleEnvironment};

#[cfg(test)]
mod tests;
