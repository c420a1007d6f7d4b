//! Material values of a block that the metallic-roughness lobes need.

use glam::Vec3;

use super::MaterialSample;
use crate::geometry::{F32Lanes, Vec3Lanes};

/// The values of [`MaterialSample`] that decide about the lobes of opaque metallic-roughness surfaces, lane by lane.
#[derive(Debug, Default)]
pub(crate) struct BaseMaterialLanes {
    base_color: Vec3Lanes,
    metallic: F32Lanes,
    roughness: F32Lanes,
    specular: F32Lanes,
    specular_color: Vec3Lanes,
}

impl BaseMaterialLanes {
    /// Replaces the values of a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, sample: &MaterialSample) {
        self.base_color.set(lane, sample.base_color);
        self.metallic[lane] = sample.metallic;
        self.roughness[lane] = sample.roughness;
        self.specular[lane] = sample.specular;
        self.specular_color.set(lane, sample.specular_color);
    }

    /// The values of a lane, whose material has the index of refraction `ior`; all others have their defaults.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize, ior: f32) -> MaterialSample {
        MaterialSample {
            base_color: self.base_color.get(lane),
            metallic: self.metallic[lane],
            roughness: self.roughness[lane],
            specular: self.specular[lane],
            specular_color: self.specular_color.get(lane),
            ior,
            ..MaterialSample::default()
        }
    }

    /// Linear base colour of a lane.
    #[inline(always)]
    pub(crate) fn base_color(&self, lane: usize) -> Vec3 {
        self.base_color.get(lane)
    }

    /// Metallic shares of all lanes.
    #[inline(always)]
    pub(crate) fn metallic(&self) -> &F32Lanes {
        &self.metallic
    }

    /// Perceptual roughness of all lanes.
    #[inline(always)]
    pub(crate) fn roughness(&self) -> &F32Lanes {
        &self.roughness
    }
}
