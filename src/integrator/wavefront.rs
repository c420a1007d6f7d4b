//! The rays of one depth, kept in order and grouped by signature.
//!
//! The sum of a sample follows the order of its rays. A batch query of the hierarchy, however, should hold rays of one kind that
//! are neighbours on screen. So rays are stored in groups by signature, and a list keeps their order.

use super::last_scatter::LastScatter;
use super::{RayKind, RayState};
use crate::bvh::{Bvh, Hit, TraversalCounters};
use crate::geometry::Ray;

/// The last bounces of a ray: below a leading one bit, one bit for each bounce, set for refraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RaySignature(u8);

/// Bounces that a signature keeps.
pub(super) const BOUNCES: u8 = 5;

impl RaySignature {
    /// The signature of camera rays.
    pub(super) const CAMERA: Self = Self(1);

    /// The signature of a child ray of the given kind.
    pub(super) fn then(self, kind: RayKind) -> Self {
        let signature = self.0 << 1 | u8::from(kind == RayKind::Refraction);
        let longest = 1 << BOUNCES;
        Self(if signature < 2 * longest { signature } else { longest | (signature % longest) })
    }

    /// A small number, different for every signature.
    pub(super) fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Position of a ray in its wavefront.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySlot {
    /// The signature of the ray, which selects its group.
    pub(super) signature: RaySignature,
    /// Index of the ray in its group.
    index: u32,
}

/// A ray of a wavefront that is followed to the surfaces that it sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct FollowedRay<'w> {
    pub(super) ray: &'w Ray,
    pub(super) state: &'w RayState,
    /// See [`Wavefront::last_scatter`].
    pub(super) last: Option<&'w LastScatter>,
}

/// Rays of one depth.
#[derive(Debug, Default)]
pub(super) struct Wavefront {
    /// By index of the signature.
    groups: Vec<RayGroup>,
    /// In the order in which the rays were added.
    order: Vec<RaySlot>,
}

/// Rays of one signature, each with its state and its closest hit.
#[derive(Debug, Default)]
struct RayGroup {
    rays: Vec<Ray>,
    states: Vec<RayState>,
    /// The surfaces that sampled the rays, as far as the weights of lights depend on them; shorter where the last rays have none.
    last_scatters: Vec<Option<LastScatter>>,
    hits: Vec<Option<Hit>>,
}

impl Wavefront {
    /// Adds a ray after all others.
    #[inline(always)]
    pub(super) fn push(&mut self, signature: RaySignature, ray: Ray, state: RayState) -> RaySlot {
        let group = group_mut(&mut self.groups, signature);
        let slot = RaySlot { signature, index: group.rays.len() as u32 };
        self.order.push(slot);
        group.rays.push(ray);
        group.states.push(state);
        slot
    }

    /// Adds rays of one signature after all others, with their states. These are made where they are kept: moving one costs more than making one.
    #[inline(always)]
    pub(super) fn extend(
        &mut self,
        signature: RaySignature,
        rays: impl ExactSizeIterator<Item = Ray>,
        states: impl ExactSizeIterator<Item = RayState>,
    ) {
        let group = group_mut(&mut self.groups, signature);
        let first = group.rays.len() as u32;
        self.order.extend((first..first + rays.len() as u32).map(|index| RaySlot { signature, index }));
        group.rays.extend(rays);
        group.states.extend(states);
    }

    /// Adds a ray of a path after all others, with the surface that sampled it.
    pub(super) fn push_scattered(
        &mut self,
        signature: RaySignature,
        ray: Ray,
        state: RayState,
        last: Option<LastScatter>,
    ) {
        let slot = self.push(signature, ray, state);
        let group = &mut self.groups[signature.index()];
        group.last_scatters.resize(slot.index as usize, None);
        group.last_scatters.push(last);
    }

    /// The surface that sampled a ray; `None` where the weights of lights do not depend on it.
    pub(super) fn last_scatter(&self, slot: RaySlot) -> Option<&LastScatter> {
        self.groups[slot.signature.index()].last_scatters.get(slot.index as usize)?.as_ref()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Removes all rays and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.order.clear();
        for group in &mut self.groups {
            group.rays.clear();
            group.states.clear();
            group.last_scatters.clear();
        }
    }

    /// Finds the closest hit of every ray, group by group.
    pub(super) fn find_hits(
        &mut self,
        bvh: &Bvh,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) {
        for group in self.groups.iter_mut().filter(|group| !group.rays.is_empty()) {
            group.hits.resize(group.rays.len(), None);
            bvh.closest_hits(&group.rays, |_, hit| filter(hit), &mut group.hits, counters);
        }
    }

    /// The slots of all rays, in the order in which they were added.
    pub(super) fn in_order(&self) -> &[RaySlot] {
        &self.order
    }

    /// A ray and its state.
    pub(super) fn ray(&self, slot: RaySlot) -> (&Ray, &RayState) {
        let group = &self.groups[slot.signature.index()];
        (&group.rays[slot.index as usize], &group.states[slot.index as usize])
    }

    /// A ray with all that following it depends on.
    pub(super) fn followed(&self, slot: RaySlot) -> FollowedRay<'_> {
        let (ray, state) = self.ray(slot);
        FollowedRay { ray, state, last: self.last_scatter(slot) }
    }

    /// The closest hit that [`Wavefront::find_hits`] found.
    pub(super) fn hit(&self, slot: RaySlot) -> Option<Hit> {
        self.groups[slot.signature.index()].hits[slot.index as usize]
    }
}

#[inline(always)]
fn group_mut(groups: &mut Vec<RayGroup>, signature: RaySignature) -> &mut RayGroup {
    let index = signature.index();
    if index >= groups.len() {
        groups.resize_with(index + 1, RayGroup::default);
    }
    &mut groups[index]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_differ_in_the_last_five_bounces() {
        let signature = |bounces: &[RayKind]| {
            bounces.iter().fold(RaySignature::CAMERA, |parent, kind| parent.then(*kind))
        };
        let (mirror, glass) = (RayKind::Reflection, RayKind::Refraction);
        assert_ne!(signature(&[mirror]), signature(&[mirror, mirror]));
        assert_ne!(signature(&[mirror, glass]), signature(&[glass, mirror]));
        // Of six bounces only the last five count.
        assert_eq!(
            signature(&[glass, mirror, glass, glass, mirror, glass]),
            signature(&[mirror, mirror, glass, glass, mirror, glass])
        );
        assert_ne!(signature(&[mirror; 5]), signature(&[glass; 5]));
    }
}
