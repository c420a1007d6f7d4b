//! A surface of a path, prepared for scattering.

use glam::{Mat3, Vec3};

use crate::bsdf::Scattering;
use crate::integrator::whitted::{RaySignature, TransmissionSide};
use crate::integrator::zsobol::SampleSequence;
use crate::integrator::{ColorChannels, LightPass, RayState};
use crate::interaction::SurfacePoint;

use super::mis::LastScatter;

/// A surface with its lobes, seen by one path.
pub(super) struct ShadedPoint<'p, 'a> {
    /// Signature of the ray.
    pub(super) signature: RaySignature,
    pub(super) state: &'p RayState,
    /// See [`crate::integrator::whitted::SurfaceHit::light_pass`].
    pub(super) light_pass: Option<LightPass>,
    pub(super) point: &'p SurfacePoint<'a>,
    pub(super) scattering: Scattering,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    /// Multiplies radiance that leaves the surface towards the viewer.
    pub(super) weight: Vec3,
    /// The colour channels that go on.
    pub(super) channels: ColorChannels,
    pub(super) transmission_side: TransmissionSide,
    /// Index of refraction on the other side over the one on this side.
    pub(super) relative_ior: f32,
    /// Whether the surface scatters light from its other side.
    pub(super) transmits: bool,
    pub(super) sequence: SampleSequence,
    /// The surface that sampled the ray.
    pub(super) last: Option<LastScatter>,
}

impl ShadedPoint<'_, '_> {
    /// The normal that bounds the directions of light.
    pub(super) fn light_normal(&self) -> Option<Vec3> {
        (!self.transmits).then_some(self.point.shading_normal)
    }

    /// The local direction of light from the world-space direction `wi`; `None` where normals disagree about its side.
    pub(super) fn local(&self, wi: Vec3) -> Option<Vec3> {
        let local = self.world_from_local.transpose() * wi;
        (local.z * self.point.geometric_normal.dot(wi) > 0.0).then_some(local)
    }

    /// Start of shadow rays towards light from the local direction `wi`.
    pub(super) fn shadow_start(&self, wi: Vec3, span: Vec3) -> Vec3 {
        if wi.z > 0.0 { self.point.shadow_end_outside(span) } else { self.point.shadow_end_inside(span) }
    }
}
