//! Short rays across surfaces that transmit light, to the surfaces that touch these.

use crate::geometry::Ray;
use crate::integrator::transparent_hits::TransparentHits;

/// Probes of the transmission sides of a block of points, and the surfaces along them. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct TransmissionProbes {
    /// From the start of mirror rays to that of refraction rays, one for each point that transmits light.
    pub(super) rays: Vec<Ray>,
    /// Index of each point's probe.
    pub(super) of_point: Vec<Option<u32>>,
    /// Whether there is a surface along a probe that the query does not collect.
    pub(super) is_occluded: Vec<bool>,
    pub(super) touching: TransparentHits,
}
