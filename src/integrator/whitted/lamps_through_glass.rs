//! The light of lamps that surfaces transmit. Shadow rays pass glass straight, so each lamp counts once along a path: where frosted glass or a sampled reflection shows it
//! first.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::secondary_rays::ChildRay;
use super::shading::{Arrival, Shading};
use crate::bsdf::Scattering;
use crate::geometry::Facing;
use crate::integrator::light_set::LightSet;
use crate::integrator::lights::{Incidence, PreparedLight};
use crate::integrator::tracing::Tracer;
use crate::integrator::{GlassShadows, IntegratorContext};
use crate::interaction::SurfacePoint;

/// The light of lamps that one surface transmits.
pub(super) struct TransmittedLampLight {
    /// The lobes of frosted glass.
    frosted: Option<Scattering>,
    /// Albedo of diffuse transmission.
    diffuse: Vec3,
    is_thin: bool,
    /// Whether another surface touches this one from behind and stops the light.
    is_covered: bool,
    /// The lamps whose light passed the surface straight and counted at an earlier one.
    shown: LightSet,
}

impl TransmittedLampLight {
    /// The light that a surface transmits.
    pub(super) fn of(context: &IntegratorContext<'_>, shading: &Shading<'_, '_>) -> Self {
        Self {
            frosted: shading.is_frosted().then(|| *shading.scattering()),
            diffuse: shading.albedos.diffuse_transmission,
            is_thin: shading.material.thin,
            is_covered: shading.transmission_side.stops_lamps(context),
            shown: lamps_shown_through_glass(context, shading),
        }
    }

    /// f · |cos θ_i| for a lamp in the local direction `wi` behind a surface of frosted glass; `None` on other surfaces. A volume sends rays that see the peaks of the
    /// environment.
    pub(super) fn scattered(
        &self,
        (index, light): (usize, &PreparedLight),
        (point, incidence): (&SurfacePoint<'_>, &Incidence),
        wi: Vec3,
    ) -> Option<Vec3> {
        if self.is_covered {
            return Some(Vec3::ZERO);
        }
        if self.shown.contains(index) {
            return Some(self.diffuse * (-wi.z * FRAC_1_PI));
        }
        let frosted = self.frosted.as_ref().filter(|_| self.is_thin || !light.is_peak())?;
        // Normals may disagree about the side of the light.
        let is_behind = point.geometric_normal.dot(incidence.wi) < 0.0;
        Some(if is_behind { frosted.eval(wi) } else { Vec3::ZERO })
    }
}

/// The lamps that an earlier surface showed straight through this one.
fn lamps_shown_through_glass(context: &IntegratorContext<'_>, shading: &Shading<'_, '_>) -> LightSet {
    let passes_straight = context.settings.glass_shadows == GlassShadows::Straight;
    let is_glass = shading.material.transmission > 0.0;
    if passes_straight && is_glass { shading.state.shown_lamps } else { LightSet::default() }
}

impl Tracer<'_, '_> {
    /// Whether light that arrives through the surface brings the environment's peaks: not those that an earlier surface showed as lamps.
    pub(super) fn transmits_peaks(&self, shading: &Shading<'_, '_>) -> bool {
        let shown = lamps_shown_through_glass(self.context, shading);
        let is_shown = |(index, light): (usize, &PreparedLight)| light.is_peak() && shown.contains(index);
        shading.transmits_peaks() && !self.context.lights.iter().enumerate().any(is_shown)
    }

    /// The lamps that count no more where a refracted ray goes on: those that frosted glass shows, too.
    pub(super) fn shown_beyond(&self, shading: &Shading<'_, '_>) -> LightSet {
        let shown = shading.state.shown_lamps;
        if !shading.is_frosted() {
            return shown;
        }
        let is_thin = shading.material.thin;
        let normals = [shading.point.shading_normal, shading.point.geometric_normal];
        let is_shown = |light: &PreparedLight, wi: Vec3| {
            (is_thin || !light.is_peak()) && normals.iter().all(|normal| wi.dot(*normal) < 0.0)
        };
        shown.union(self.lights_at(shading.point, is_shown))
    }

    /// The lamps that count no more where a reflected ray goes on: those whose highlights its sampled lobe has, and within glass those of the ray before. A mirror outside
    /// begins anew.
    pub(super) fn shown_before(&self, arrival: &Arrival<'_, '_>, child: &ChildRay) -> LightSet {
        let point = arrival.point;
        let is_within =
            point.facing == Facing::Back && self.context.interiors.medium(point.instance).is_some();
        let shown = if is_within { arrival.state.shown_lamps } else { LightSet::default() };
        if !child.is_sampled {
            return shown;
        }
        shown.union(self.lights_at(point, |_, wi| wi.dot(point.shading_normal) > 0.0))
    }

    /// The lights that reach a point and of which `is_shown` holds, by their direction.
    fn lights_at(
        &self,
        point: &SurfacePoint<'_>,
        is_shown: impl Fn(&PreparedLight, Vec3) -> bool,
    ) -> LightSet {
        let mut set = LightSet::default();
        for (index, light) in self.context.lights.iter().enumerate() {
            if let Some(incidence) = light.incidence(point.position)
                && is_shown(light, incidence.wi)
            {
                set.insert(index);
            }
        }
        set
    }
}
