//! Photons, which are traced as the rays of paths are.

use super::LastScatter;
use super::guiding::{LandedPhoton, PhotonPath};
use super::shaded_point::ShadedPoint;
use crate::color::luminance;
use crate::geometry::Ray;
use crate::integrator::RayState;
use crate::integrator::whitted::{RaySignature, Tracer};
use crate::integrator::zsobol::SampleSequence;

impl Tracer<'_, '_> {
    /// Follows photons to all diffuse surfaces where they land. The first surface of each is as far as thin walls the last that
    /// scattered it.
    pub(super) fn follow_photons(
        mut self,
        photons: impl Iterator<Item = (Ray, RayState, LastScatter, SampleSequence)>,
    ) -> Vec<LandedPhoton> {
        self.landed_photons = Some(Vec::new());
        self.sequences.clear();
        for (ray, state, last, sequence) in photons {
            self.sequences.push(sequence);
            self.children.push_scattered(RaySignature::CAMERA, ray, state, Some(last));
        }
        self.trace_children();
        self.landed_photons.unwrap_or_default()
    }

    /// Records a photon at a surface.
    pub(super) fn land_photon(&mut self, shaded: &ShadedPoint<'_, '_>) {
        let Some(landed) = &mut self.landed_photons else { return };
        if shaded.transmits || shaded.scattering.diffuse_probability() <= 0.0 {
            return;
        }
        let state = shaded.state;
        // Only smooth surfaces leave a share of what guides the denoising.
        let path = match (state.guide_share > 0.0, shaded.last) {
            (true, Some(_)) => PhotonPath::Straight,
            (true, None) => PhotonPath::Focused,
            (false, _) => PhotonPath::Scattered,
        };
        landed.push(LandedPhoton {
            position: shaded.point.position,
            normal: shaded.point.geometric_normal,
            direction: shaded.point.wo,
            path,
            power: luminance(shaded.weight),
            source_luminance: 0.0,
            index: state.sample,
        });
    }
}
