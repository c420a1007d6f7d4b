//! Photons, which are traced as the rays of paths are.

use super::guiding::{Photon, PhotonPath, PhotonRay, PhotonStore};
use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::color::luminance;
use crate::integrator::tracing::Tracer;
use crate::integrator::wavefront::RaySignature;

impl Tracer<'_, '_> {
    /// Traces photons to all diffuse surfaces that they reach.
    pub(super) fn trace_photons(mut self, photons: impl Iterator<Item = PhotonRay>) -> PhotonStore {
        self.path.photon_store = Some(PhotonStore::default());
        self.sequences.clear();
        for PhotonRay { ray, state, last, sequence } in photons {
            self.sequences.push(sequence);
            self.children.push_scattered(RaySignature::CAMERA, ray, state, Some(last));
        }
        self.trace_children();
        self.path.photon_store.unwrap_or_default()
    }

    /// Stores a photon at a surface; `false` where it ends.
    pub(super) fn store_photon(&mut self, shaded: &ShadedPoint<'_, '_>, block: &PathBlock) -> bool {
        let Some(store) = &mut self.path.photon_store else { return false };
        let state = &*shaded.state;
        if !shaded.transmits && block.diffuse_probability(shaded.lane) > 0.0 {
            // Smooth surfaces alone pass on a share of what guides the denoising.
            let path = match (state.guide_share > 0.0, shaded.last) {
                (true, Some(_)) => PhotonPath::Direct,
                (true, None) => PhotonPath::Caustic,
                (false, _) => PhotonPath::Indirect,
            };
            store.store(Photon {
                position: shaded.point.position,
                normal: shaded.point.geometric_normal,
                direction: shaded.point.wo,
                path,
                power: luminance(shaded.weight),
                source_luminance: 0.0,
                index: state.sample,
            });
        }
        PhotonStore::goes_on(state.depth)
    }
}
