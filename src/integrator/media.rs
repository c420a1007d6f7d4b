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
/// Every ray has a stack. Stacks share their volumes, also by `MediaCache`, so that rays rarely allocate where they enter one, and
/// read memory that is in the cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MediaStack(Option<Rc<Entered>>);

/// The volume that was entered last, and the ones around it.
#[derive(Debug, PartialEq)]
struct Entered {
    medium: Medium,
    around: MediaStack,
}

impl Drop for Entered {
    /// Drops one volume after the other: thousands may be nested.
    fn drop(&mut self) {
        let mut next = self.around.0.take();
        while let Some(mut entered) = next.and_then(Rc::into_inner) {
            next = entered.around.0.take();
        }
    }
}

/// The volumes around the surface of a shadow ray.
#[derive(Clone, Debug)]
pub(super) enum SurfaceMedia {
    /// The ray starts at the surface.
    AtStart(MediaStack),
    /// It ends there, as those of lamps that rays cannot hit.
    AtEnd(MediaStack),
}

impl Default for SurfaceMedia {
    fn default() -> Self {
        Self::AtStart(MediaStack::default())
    }
}

impl SurfaceMedia {
    /// The volumes around a surface for a shadow ray of a lamp that rays cannot hit: from the surface to a distant one, from any other to the surface.
    pub(super) fn of_lamp(is_distant: bool, media: MediaStack) -> Self {
        if is_distant { Self::AtStart(media) } else { Self::AtEnd(media) }
    }

    /// The volumes, whichever end they are at.
    pub(super) fn stack(&self) -> &MediaStack {
        match self {
            Self::AtStart(media) | Self::AtEnd(media) => media,
        }
    }
}

/// The stacks that were made last, for all rays that enter the same volumes.
#[derive(Debug, Default)]
pub(super) struct MediaCache {
    entered: [MediaStack; 4],
    /// Index of the one that is replaced next.
    oldest: usize,
}

impl MediaCache {
    fn entering(&mut self, around: MediaStack, medium: Medium) -> MediaStack {
        let is_it = |entered: &Entered| entered.medium == medium && entered.around.shares(&around);
        let mut known = self.entered.iter();
        if let Some(known) = known.find(|known| known.0.as_deref().is_some_and(is_it)) {
            return known.clone();
        }
        let entered = around.entering(medium);
        self.entered[self.oldest] = entered.clone();
        self.oldest = (self.oldest + 1) % self.entered.len();
        entered
    }
}

impl MediaStack {
    /// A stack of `volumes`, the last entered one last.
    pub(super) fn new(volumes: &[Medium]) -> Self {
        volumes.iter().fold(Self::default(), |around, medium| around.entering(*medium))
    }

    fn entering(self, medium: Medium) -> Self {
        Self(Some(Rc::new(Entered { medium, around: self })))
    }

    /// The volumes, the last entered one first.
    fn volumes(&self) -> impl Iterator<Item = &Medium> {
        let mut next = self.0.as_deref();
        std::iter::from_fn(move || {
            let entered = next?;
            next = entered.around.0.as_deref();
            Some(&entered.medium)
        })
    }

    /// Whether both stacks are the same memory.
    fn shares(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(a), Some(b)) => Rc::ptr_eq(a, b),
            _ => false,
        }
    }

    /// Whether there are no volumes.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// The medium that fills the space; `None` is vacuum.
    pub fn current(&self) -> Option<&Medium> {
        self.0.as_deref().map(|entered| &entered.medium)
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
        self.volumes().any(|medium| medium.volume == volume)
    }

    /// Crosses the surface of `medium`: a front face enters, a back face leaves.
    pub(super) fn cross(&mut self, medium: Medium, facing: Facing, cache: &mut MediaCache) {
        match facing {
            Facing::Front => *self = cache.entering(std::mem::take(self), medium),
            Facing::Back if self.holds(medium.volume) => *self = self.left(medium.volume),
            Facing::Back => {}
        }
    }

    /// Crosses the surface of `medium` against the direction in which it was hit.
    pub(super) fn cross_back(&mut self, medium: Medium, facing: Facing, cache: &mut MediaCache) {
        let opposite = match facing {
            Facing::Front => Facing::Back,
            Facing::Back => Facing::Front,
        };
        self.cross(medium, opposite, cache);
    }

    /// The stack without the last entered part of `volume`.
    fn left(&self, volume: VolumeId) -> Self {
        let mut kept = Vec::new();
        let mut next = &self.0;
        while let Some(entered) = next {
            if entered.medium.volume == volume {
                break;
            }
            kept.push(entered.medium);
            next = &entered.around.0;
        }
        let around = next.as_ref().map_or_else(Self::default, |entered| entered.around.clone());
        kept.iter().rev().fold(around, |around, medium| around.entering(*medium))
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
        let (mut stack, mut cache) = (MediaStack::default(), MediaCache::default());
        stack.cross(glass, Facing::Front, &mut cache);
        stack.cross(water, Facing::Front, &mut cache);
        assert_eq!(stack.ior(ColorChannels::White), 1.33);
        // Leaving the outer volume first keeps the inner one.
        let mut overlapping = stack.clone();
        overlapping.cross(glass, Facing::Back, &mut cache);
        assert_eq!(overlapping.ior(ColorChannels::White), 1.33);
        stack.cross(water, Facing::Back, &mut cache);
        assert_eq!(stack.ior(ColorChannels::White), 1.5);
        stack.cross(glass, Facing::Back, &mut cache);
        assert_eq!(stack, MediaStack::default());
    }

    #[test]
    fn rays_in_the_same_volumes_share_a_stack() {
        let (glass, water) = (medium(0, 1.5), medium(1, 1.33));
        let mut cache = MediaCache::default();
        let mut entered = |volumes: &[Medium]| {
            let mut stack = MediaStack::default();
            for volume in volumes {
                stack.cross(*volume, Facing::Front, &mut cache);
            }
            stack
        };
        let first = entered(&[glass, water]);
        assert!(first.shares(&entered(&[glass, water])));
        assert!(!first.shares(&entered(&[water, glass])));
        // More stacks than the cache holds
        for material in 2..20 {
            assert_eq!(entered(&[medium(material, 1.2), glass]).ior(ColorChannels::White), 1.5);
        }
        assert_eq!(entered(&[glass, water]), first);
    }

    #[test]
    fn thousands_of_nested_volumes_are_dropped() {
        let volumes: Vec<_> = (0..200_000).map(|material| medium(material, 1.5)).collect();
        let mut stack = MediaStack::new(&volumes);
        stack.cross(volumes[0], Facing::Back, &mut MediaCache::default());
        assert_eq!(stack.volumes().count(), volumes.len() - 1);
    }
}
