//! The rays of one generation, in order, and apart by how they came about.
//!
//! What a sample adds up follows the order of its rays; what the hierarchy is asked in one batch should be rays of one kind
//! that are neighbours on screen. So rays lie in groups by route, and a list remembers their order.

use crate::bvh::{Bvh, Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::{RayKind, RayState};

/// How a ray came about: one bit a bounce below a leading one, set for refraction. Of long routes, the last bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RaySignature(u8);

/// Bounces that a route tells apart.
const BOUNCES: u8 = 5;

impl RaySignature {
    /// From the camera.
    pub(super) const CAMERA: Self = Self(1);

    /// The route of a child.
    pub(super) fn then(self, kind: RayKind) -> Self {
        let signature = self.0 << 1 | u8::from(kind == RayKind::Refraction);
        let longest = 1 << BOUNCES;
        Self(if signature < 2 * longest { signature } else { longest | (signature % longest) })
    }

    /// A small number, different for every route.
    pub(super) fn subscript(self) -> usize {
        usize::from(self.0)
    }
}

/// Where a ray lies in its generation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its group.
    pub(super) signature: RaySignature,
    index: u32,
}

/// Rays of one depth.
#[derive(Debug, Default)]
pub(super) struct Wavefront {
    /// By route.
    groups: Vec<Group>,
    order: Vec<Place>,
}

/// Rays of one route, each with its path and its closest hit.
#[derive(Debug, Default)]
struct Group {
    rays: Vec<Ray>,
    states: Vec<RayState>,
    hits: Vec<Option<Hit>>,
}

impl Wavefront {
    /// Adds a ray behind all others.
    pub(super) fn push(&mut self, signature: RaySignature, ray: Ray, state: RayState) {
        let subscript = signature.subscript();
        if subscript >= self.groups.len() {
            self.groups.resize_with(subscript + 1, Group::default);
        }
        let group = &mut self.groups[subscript];
        self.order.push(Place { signature, index: group.rays.len() as u32 });
        group.rays.push(ray);
        group.states.push(state);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Forgets all rays, not the memory.
    pub(super) fn clear(&mut self) {
        self.order.clear();
        for group in &mut self.groups {
            group.rays.clear();
            group.states.clear();
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

    /// Where all rays lie, in the order in which they were added.
    pub(super) fn in_order(&self) -> &[Place] {
        &self.order
    }

    /// A ray and its path.
    pub(super) fn ray(&self, place: Place) -> (&Ray, &RayState) {
        let group = &self.groups[place.signature.subscript()];
        (&group.rays[place.index as usize], &group.states[place.index as usize])
    }

    /// What [`Wavefront::find_hits`] found.
    pub(super) fn hit(&self, place: Place) -> Option<Hit> {
        self.groups[place.signature.subscript()].hits[place.index as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn routes_are_told_apart_until_they_are_long() {
        let walk = |bounces: &[RayKind]| {
            bounces.iter().fold(RaySignature::CAMERA, |signature, kind| signature.then(*kind))
        };
        let (mirror, glass) = (RayKind::Reflection, RayKind::Refraction);
        assert_ne!(walk(&[mirror]), walk(&[mirror, mirror]));
        assert_ne!(walk(&[mirror, glass]), walk(&[glass, mirror]));
        // Six bounces are the same as the last five of them behind any others.
        assert_eq!(
            walk(&[glass, mirror, glass, glass, mirror, glass]),
            walk(&[mirror, mirror, glass, glass, mirror, glass])
        );
        assert_ne!(walk(&[mirror; 5]), walk(&[glass; 5]));
    }
}
