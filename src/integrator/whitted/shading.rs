//! A surface prepared for shading: its lobes, its coat and its local frame, as one ray sees them.

use std::cell::OnceCell;

use glam::{Mat3, Vec3};

use super::coat::CoatShading;
use super::traced_share::traced_share;
use crate::bsdf::{AlbedoTerms, Albedos, Bsdf, Scattering};
use crate::integrator::transmission_side::TransmissionSide;
use crate::integrator::wavefront::RaySignature;
use crate::integrator::{ColorChannels, LightPass, RayKind, RayState};
use crate::interaction::{MaterialSample, SurfacePoint};

/// A surface where a ray arrives.
#[derive(Clone, Copy)]
pub(super) struct Arrival<'p, 'a> {
    /// Signature of the ray.
    pub(super) signature: RaySignature,
    pub(super) state: &'p RayState,
    /// See [`crate::integrator::surface_hit::SurfaceHit::light_pass`].
    pub(super) light_pass: Option<LightPass>,
    pub(super) point: &'p SurfacePoint<'a>,
}

/// A surface with its lobes, seen by one ray.
pub(super) struct Shading<'p, 'a> {
    /// Signature of the ray.
    pub(super) signature: RaySignature,
    pub(super) state: &'p RayState,
    /// See [`crate::integrator::surface_hit::SurfaceHit::light_pass`].
    pub(super) light_pass: Option<LightPass>,
    /// Index of the point in its block.
    pub(super) index: usize,
    pub(super) point: &'p SurfacePoint<'a>,
    pub(super) material: &'p MaterialSample,
    pub(super) bsdf: &'p Bsdf,
    /// Albedo terms of the lobes.
    pub(super) terms: AlbedoTerms,
    /// See [`Shading::scattering`].
    pub(super) scattering: OnceCell<Scattering>,
    /// Directional albedos of the lobes.
    pub(super) albedos: Albedos,
    /// Columns are tangent, bitangent and normal.
    pub(super) world_from_local: Mat3,
    /// Local direction to the viewer.
    pub(super) wo: Vec3,
    /// Multiplies radiance that leaves the surface towards the viewer.
    pub(super) weight: Vec3,
    /// Multiplies radiance that leaves from below the coat.
    pub(super) weight_below: Vec3,
    pub(super) coat: Option<&'p CoatShading>,
    /// The lobes of the single colour channels, where the surface is dispersive.
    pub(super) dispersed: Option<&'p [Bsdf; 3]>,
    /// The other side of the surface.
    pub(super) transmission_side: &'p TransmissionSide,
    /// Indices of refraction on this side and on the other.
    pub(super) iors: [f32; 2],
    /// Share of the reflected lobe that rays follow; the prefiltered environment has the rest.
    pub(super) traced_share: f32,
    /// Whether sampled rays follow the transmitted lobe.
    pub(super) follows_transmission: bool,
    /// Share of the transmitted lobe that the refraction ray follows where sampled rays do not.
    pub(super) traced_share_transmitted: f32,
    /// Share of the sampled rays that follow facets, see [`super::tracer::Tracer::facet_share`].
    pub(super) facet_share: f32,
}

impl<'p, 'a> Shading<'p, 'a> {
    /// The ray and the point.
    pub(super) fn arrival(&self) -> Arrival<'p, 'a> {
        let Self { signature, state, light_pass, point, .. } = *self;
        Arrival { signature, state, light_pass, point }
    }

    /// Index of refraction on the other side over the one on this side. An index of 0 bends nothing.
    pub(super) fn relative_ior(&self) -> f32 {
        let [outside, inside] = self.iors;
        if outside > 0.0 && inside > 0.0 { inside / outside } else { 1.0 }
    }

    /// Whether the surface of a volume is seen from the side of higher index, where light is reflected totally.
    pub(super) fn is_on_denser_side(&self) -> bool {
        !self.material.thin && self.material.transmission > 0.0 && self.relative_ior() < 1.0
    }

    /// Whether light that arrives through the surface brings the environment's peaks. Thin walls show these as highlights, and what facets
    /// reflected within a volume had them as highlights there.
    pub(super) fn transmits_peaks(&self) -> bool {
        let was_reflected = self.facet_share > 0.0 && self.state.kind == RayKind::Reflection;
        !self.material.thin && !was_reflected
    }

    /// Whether the surface is glass that scatters what it transmits, and so shows the lamps beyond.
    pub(super) fn is_frosted(&self) -> bool {
        self.material.transmission > 0.0
            && traced_share(self.bsdf.widest_transmission_roughness()) < 1.0
            && (self.material.thin || !self.bsdf.is_refraction_smooth())
    }

    /// All lobes below the coat towards the viewer, for what single albedos do not tell.
    pub(super) fn scattering(&self) -> &Scattering {
        self.scattering.get_or_init(|| Scattering::by_terms(*self.bsdf, self.wo, self.terms))
    }

    /// The lobes that transmit light, each with its colour channels.
    pub(super) fn transmission_lobes(&self) -> impl Iterator<Item = (ColorChannels, &Bsdf)> {
        let together = self.dispersed.is_none().then_some((self.state.channels, self.bsdf));
        let apart =
            self.dispersed.into_iter().flat_map(|dispersed| ColorChannels::SINGLE.into_iter().zip(dispersed));
        together.into_iter().chain(apart)
    }
}
