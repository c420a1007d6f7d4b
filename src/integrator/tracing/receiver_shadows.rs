//! The shadow rays of receivers, and the light that they find.

use glam::Vec3;

use crate::geometry::Ray;
use crate::integrator::environment_directions::EnvironmentDirections;
use crate::integrator::media::SurfaceMedia;
use crate::integrator::shadow::ShadowBatch;
use crate::scene::Environment;

/// Luminance of the direct light on a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ReceivedLight {
    pub(super) unoccluded: f32,
    pub(super) arriving: f32,
}

/// The shadow rays of receivers. Keeps its memory.
#[derive(Debug, Default)]
pub(super) struct ReceiverShadows {
    /// For each light, then for the environment.
    pub(super) batches: Vec<ShadowBatch>,
    pub(super) rays: Vec<ReceiverRay>,
    pub(super) receivers: Vec<QueuedReceiver>,
    /// The last normal, and the irradiance of the environment on a surface of it: the ground has only one.
    irradiance: Option<(Vec3, EnvironmentIrradiance)>,
}

/// The irradiance of the environment on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct EnvironmentIrradiance {
    pub(super) exact: Vec3,
    /// That of the grid of directions.
    pub(super) of_grid: f32,
}

/// The end of a receiver's rays, and the luminance of light that arrives without any.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueuedReceiver {
    pub(super) end: usize,
    pub(super) certain: f32,
}

/// A shadow ray, and the irradiance that it decides about.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReceiverRay {
    pub(super) batch: usize,
    /// Index in its batch.
    pub(super) index: u32,
    pub(super) irradiance: Vec3,
}

impl ReceiverShadows {
    pub(super) fn clear(&mut self) {
        self.batches.iter_mut().for_each(ShadowBatch::clear);
        self.rays.clear();
        self.receivers.clear();
    }

    /// The irradiance of `environment` on a surface of this normal.
    pub(super) fn irradiance(
        &mut self,
        (environment, directions): (&Environment, &EnvironmentDirections),
        normal: Vec3,
    ) -> EnvironmentIrradiance {
        if let Some((known, irradiance)) = self.irradiance
            && known == normal
        {
            return irradiance;
        }
        let (exact, of_grid) = (environment.irradiance(normal), directions.grid.irradiance(normal));
        let irradiance = EnvironmentIrradiance { exact, of_grid };
        self.irradiance.insert((normal, irradiance)).1
    }

    /// Adds a shadow ray. `media` are the volumes around the receiver.
    pub(super) fn push(&mut self, batch: usize, (ray, media): (Ray, SurfaceMedia), irradiance: Vec3) {
        if batch >= self.batches.len() {
            self.batches.resize_with(batch + 1, ShadowBatch::default);
        }
        let index = self.batches[batch].push(ray, media);
        self.rays.push(ReceiverRay { batch, index, irradiance });
    }
}
