//! Media: the closed volumes that contain a ray, as a stack. Entering a volume pushes it, leaving removes it.

use std::rc::Rc;

use glam::Vec3;

use super::color_channels::ColorChannels;
use crate::geometry::Facing;
use crate::scene::{MaterialIndex, NodeIndex};

/// The closed surface that bounds a volume: the primitives of one node instance that share a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumeId {
    /// The node of the surface.
    pub node: NodeIndex,
    /// Index of the instance of the node.
    pub instance: u32,
    /// The material of the surface.
    pub material: MaterialIndex,
}

/// The medium inside a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// The bounding surface.
    pub volume: VolumeId,
    /// Index of refraction of green light.
    pub ior: f32,
    /// Difference of the index for blue light, and minus that for red light (`KHR_materials_dispersion`).
    pub half_spread: f32,
    /// Extinction coefficient σ, per metre.
    pub extinction: Vec3,
}

impl Medium {
    /// Index of refraction for the given channels; white rays have that of green light.
    pub fn ior_of(&self, channels: ColorChannels) -> f32 {
        match channels {
            ColorChannels::White | ColorChannels::Green => self.ior,
            ColorChannels::Red => self.ior - self.half_spread,
            ColorChannels::Blue => self.ior + self.half_spread,
        }
    }

    /// Transmittance over `distance` metres, which may be infinite (Beer–Lambert).
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        self.extinction
            .map(|extinction| if extinction > 0.0 { libm::expf(-extinction * distance) } else { 1.0 })
    }
}

/// The volumes that contain a point. The last entered one fills the space.
///
/// Every ray has a stack and nearly all are empty: empty stacks allocate nothing, others are shared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MediaStack(Option<Rc<Vec<Medium>>>);

impl MediaStack {
    /// A stack of `volumes`, the last entered one last.
    pub(super) fn new(volumes: Vec<Medium>) -> Self {
        Self((!volumes.is_empty()).then(|| Rc::new(volumes)))
    }

    fn volumes(&self) -> &[Medium] {
        self.0.as_deref().map(Vec::as_slice).unwrap_or_default()
    }

    /// Whether there are no volumes.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// The medium that fills the space; `None` is vacuum.
    pub fn current(&self) -> Option<&Medium> {
        self.volumes().last()
    }

    /// Index of refraction of the space; 1 in vacuum.
    pub fn ior(&self, channels: ColorChannels) -> f32 {
        self.current().map_or(1.0, |medium| medium.ior_of(channels))
    }

    /// Whether the medium of the space is dispersive.
    pub fn disperses(&self) -> bool {
        self.current().is_some_and(|medium| medium.half_spread > 0.0)
    }

    /// Transmittance of the space over `distance` metres.
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        self.current().map_or(Vec3::ONE, |medium| medium.transmittance(distance))
    }

    /// Whether the stack contains this volume.
    pub fn holds(&self, volume: VolumeId) -> bool {
        self.volumes().iter().any(|medium| medium.volume == volume)
    }

    /// Crosses the surface of `medium`: a front face enters, a back face leaves.
    pub fn cross(&mut self, medium: Medium, facing: Facing) {
        let mut volumes = self.volumes().to_vec();
        match facing {
            Facing::Front => volumes.push(medium),
            Facing::Back => {
                if let Some(last) = volumes.iter().rposition(|held| held.volume == medium.volume) {
                    volumes.remove(last);
                }
            }
        }
        *self = Self::new(volumes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(material: u32, ior: f32) -> Medium {
        let volume = VolumeId { node: NodeIndex(0), instance: 0, material: MaterialIndex(material) };
        Medium { volume, ior, half_spread: 0.0, extinction: Vec3::ZERO }
    }

    #[test]
    fn leaving_restores_the_volume_below() {
        let (glass, water) = (medium(0, 1.5), medium(1, 1.33));
        let mut stack = MediaStack::default();
        stack.cross(glass, Facing::Front);
        stack.cross(water, Facing::Front);
        assert_eq!(stack.ior(ColorChannels::White), 1.33);
        // Leaving the outer volume first keeps the inner one.
        let mut overlapping = stack.clone();
        overlapping.cross(glass, Facing::Back);
        assert_eq!(overlapping.ior(ColorChannels::White), 1.33);
        stack.cross(water, Facing::Back);
        assert_eq!(stack.ior(ColorChannels::White), 1.5);
        stack.cross(glass, Facing::Back);
        assert_eq!(stack, MediaStack::default());
    }
}
