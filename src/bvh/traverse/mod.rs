//! Ray traversal of the wide tree: one ray at a time, or in packets of neighbours.
//!
//! [`visitor`] defines what a traversal reports and [`closest_hit`] and [`any_hit`] what the queries make of it. [`single`]
//! traverses with one ray ([`lane_ray`], [`stack`]). [`batch`] cuts batches into packets ([`packet`], [`frustum`]), which
//! [`packet_walk`] traverses for the queries of [`packet_query`]; [`exact_hits`] computes their hits. Incoherent packets are
//! sorted by direction first ([`ray_bins`]). [`batch_answer`] states what each query does with a packet and with a single ray.
//! [`edge_functions`] are the triangle tests in single precision.

mod any_hit;
mod batch;
mod batch_answer;
mod closest_hit;
mod edge_functions;
mod exact_hits;
mod frustum;
mod lane_ray;
#[cfg(test)]
mod lane_tests;
mod packet;
mod packet_query;
mod packet_walk;
mod ray_bins;
mod single;
mod stack;
mod visitor;

pub(super) use any_hit::AnyHit;
pub(super) use batch::Batch;
pub(super) use closest_hit::ClosestHit;
pub(super) use single::traverse;
pub(super) use visitor::{LeafIntersector, Visitor};
