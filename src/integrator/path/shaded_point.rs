//! A surface of a path, prepared for scattering.

use glam::{Mat3, Vec3};

use crate::integrator::ray_state::ArrivingState;
use crate::integrator::transmission_side::TransmissionSide;
use crate::integrator::wavefront::RaySignature;
use crate::integrator::{ColorChannels, LightPass, MediaStack};
use crate::interaction::{MaterialSample, SurfacePoint};

use super::VisibleEntry;
use super::dimensions::BounceSamples;
use super::guiding::Guidance;
use crate::integrator::last_scatter::LastScatter;

/// A surface with its lobes, seen by one path.
pub(super) struct ShadedPoint<'p, 'a> {
    /// Its lane in the block that is shaded.
    pub(super) lane: usize,
    /// Signature of the ray.
    pub(super) signature: RaySignature,
    pub(super) state: ArrivingState<'p>,
    /// See [`crate::integrator::surface_hit::SurfaceHit::light_pass`].
    pub(super) light_pass: Option<LightPass>,
    /// See [`crate::integrator::surface_hit::SurfaceHit::share`].
    pub(super) share: f32,
    pub(super) point: &'p SurfacePoint<'a>,
    pub(super) material: &'p MaterialSample,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    /// Multiplies radiance that leaves the surface towards the viewer.
    pub(super) weight: Vec3,
    /// The colour channels that go on.
    pub(super) channels: ColorChannels,
    pub(super) transmission_side: TransmissionSide,
    /// Whether a surface touches this one from behind and stops the light of lamps that rays cannot hit.
    pub(super) hides_lamps: bool,
    /// Index of refraction on the other side over the one on this side.
    pub(super) relative_ior: f32,
    /// Whether the surface scatters light from its other side.
    pub(super) transmits: bool,
    /// How the surface guides its rays.
    pub(super) guidance: Option<Guidance<'p>>,
    /// What the surface sees of the environment.
    pub(super) visible: Option<VisibleEntry>,
    pub(super) samples: BounceSamples,
    /// The surface that sampled the ray.
    pub(super) last: Option<LastScatter>,
}

impl ShadedPoint<'_, '_> {
    /// The normal by which lights are bounded.
    pub(super) fn light_normal(&self) -> Option<Vec3> {
        (!self.transmits).then_some(self.point.shading_normal)
    }

    /// Whether a world-space direction is on the viewer's side.
    pub(super) fn is_outside(&self, wi: Vec3) -> bool {
        self.point.geometric_normal.dot(wi) > 0.0
    }

    /// The local direction of light from the world-space direction `wi`; `None` where normals disagree about its side, unless a coat reflects
    /// it, and where another surface touches this one on that side: sampled rays find what is behind it.
    pub(super) fn local(&self, wi: Vec3) -> Option<Vec3> {
        self.local_unless(wi, self.transmission_side.touching.is_some())
    }

    /// The same for light of a lamp that rays cannot hit. Where a surface lets no light through, its shading normal alone decides about the side, so that
    /// smooth meshes of few triangles have a smooth terminator: no sampled ray has to follow the direction.
    pub(super) fn local_of_lamp(&self, wi: Vec3) -> Option<Vec3> {
        if self.transmits {
            return self.local_unless(wi, self.hides_lamps);
        }
        let local = self.local_direction(wi);
        (local.z > 0.0 || self.is_lit_through_coat(wi)).then_some(local)
    }

    fn local_unless(&self, wi: Vec3, is_covered: bool) -> Option<Vec3> {
        let local = self.local_direction(wi);
        let agrees = local.z * self.point.geometric_normal.dot(wi) > 0.0;
        let is_on_a_side = agrees || self.is_lit_through_coat(wi);
        (is_on_a_side && (self.is_outside(wi) || !is_covered)).then_some(local)
    }

    fn local_direction(&self, wi: Vec3) -> Vec3 {
        self.world_from_local.transpose() * wi
    }

    fn is_lit_through_coat(&self, wi: Vec3) -> bool {
        self.is_outside(wi) && self.material.clear_coat.is_some()
    }

    /// Whether the light of a lamp that rays cannot hit reached an earlier surface straight through this one, from the world-space direction `wi`.
    pub(super) fn has_passed_straight(&self, wi: Vec3) -> bool {
        !self.is_outside(wi) && self.material.transmission > 0.0 && self.state.has_lamps
    }

    /// Start of shadow rays towards light from the world-space direction `wi`.
    pub(super) fn shadow_start(&self, wi: Vec3, span: Vec3) -> Vec3 {
        if self.is_outside(wi) {
            self.point.shadow_end_outside(span)
        } else {
            self.point.shadow_end_inside(span)
        }
    }

    /// The shadow ray's end and the volumes there for light of a lamp that rays cannot hit, which comes from the world-space direction `wi` over `span`.
    pub(super) fn lamp_shadow_end(&self, wi: Vec3, span: Vec3) -> (Vec3, MediaStack) {
        if self.transmits {
            return (self.shadow_start(wi, span), self.media_towards(wi));
        }
        (self.point.shadow_end_outside(span), self.state.media.clone())
    }

    /// The volumes on the side of a world-space direction.
    pub(super) fn media_towards(&self, wi: Vec3) -> MediaStack {
        if self.is_outside(wi) { self.state.media.clone() } else { self.transmission_side.media.clone() }
    }
}
