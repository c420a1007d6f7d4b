//! Photons: their rays, and what diffuse surfaces store of them.

use glam::Vec3;

use crate::geometry::Ray;
use crate::integrator::RayState;
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::zsobol::SampleSequence;

/// Photons that are traced together.
pub(super) const BATCH: u32 = 1024;
/// The most that a batch stores.
pub(super) const STORED_BY_BATCH: usize = 4 * BATCH as usize;
/// Surfaces after which a photon ends. What it would still bring is smooth.
const MOST_BOUNCES: u32 = 8;

/// The ray that carries a photon away from its source.
#[derive(Debug)]
pub(in crate::integrator) struct PhotonRay {
    pub(in crate::integrator) ray: Ray,
    pub(in crate::integrator) state: RayState,
    /// A scatter event at the source. Clear thin walls leave it as it is.
    pub(in crate::integrator) last: LastScatter,
    /// Sample points of the surfaces that it reaches.
    pub(in crate::integrator) sequence: SampleSequence,
}

/// What is between the source of a photon and the surface that stores it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::integrator) enum PhotonPath {
    /// Nothing that bends it. Shadow rays find this light.
    Direct,
    /// Mirrors and clear glass alone.
    Caustic,
    /// Some surface that scatters light.
    Indirect,
}

/// A photon at a diffuse surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::integrator) struct Photon {
    pub(in crate::integrator) position: Vec3,
    /// Unit vector, on the side where the photon arrives.
    pub(in crate::integrator) normal: Vec3,
    /// Unit vector to where it came from.
    pub(in crate::integrator) direction: Vec3,
    pub(in crate::integrator) path: PhotonPath,
    /// Luminance of its power.
    pub(in crate::integrator) power: f32,
    /// Luminance of the radiance of its source.
    pub(in crate::integrator) source_luminance: f32,
    /// Index in its batch.
    pub(in crate::integrator) index: u32,
}

/// The photons that surfaces store.
#[derive(Debug, Default)]
pub(in crate::integrator) struct PhotonStore {
    /// All but those of [`PhotonPath::Direct`].
    pub(super) photons: Vec<Photon>,
    /// Power of those.
    pub(super) direct_power: f32,
}

impl PhotonStore {
    /// Stores a photon at a surface.
    pub(in crate::integrator) fn store(&mut self, photon: Photon) {
        if photon.path == PhotonPath::Direct {
            self.direct_power += photon.power;
        } else if self.photons.len() < STORED_BY_BATCH {
            self.photons.push(photon);
        }
    }

    /// Whether a photon goes on after some number of bounces.
    pub(in crate::integrator) fn goes_on(depth: u32) -> bool {
        depth < MOST_BOUNCES
    }
}
