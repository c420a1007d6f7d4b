//! The rays of one generation, in order, and apart by how they came about.
//!
//! What a sample adds up follows the order of its rays; what the hierarchy is asked in one batch should be rays of one kind
//! that are neighbours on screen. So rays lie in groups by route, and a list remembers their order.

use crate::bvh::{Bvh, Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::{Path, PathClass};

/// How a ray came about: one bit a bounce below a leading one, set for refraction. Of long routes, the last bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Route(u8);

/// Bounces that a route tells apart.
const BOUNCES: u8 = 5;

impl Route {
    /// From the camera.
    pub(super) const CAMERA: Self = Self(1);

    /// The route of a child.
    pub(super) fn then(self, class: PathClass) -> Self {
        let route = self.0 << 1 | u8::from(class == PathClass::Refraction);
        let longest = 1 << BOUNCES;
        Self(if route < 2 * longest { route } else { longest | (route % longest) })
    }
}

/// Where a ray lies in its generation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its group.
    pub(super) route: Route,
    index: u32,
}

/// Rays of one depth.
#[derive(Debug, Default)]
pub(super) struct Generation {
    /// By route.
    groups: Vec<Group>,
    order: Vec<Place>,
}

/// Rays of one route, each with its path and its closest hit.
#[derive(Debug, Default)]
struct Group {
    rays: Vec<Ray>,
    paths: Vec<Path>,
    hits: Vec<Option<Hit>>,
}

impl Generation {
    /// Adds a ray behind all others.
    pub(super) fn push(&mut self, route: Route, ray: Ray, path: Path) {
        let subscript = usize::from(route.0);
        if subscript >= self.groups.len() {
            self.groups.resize_with(subscript + 1, Group::default);
        }
        let group = &mut self.groups[subscript];
        self.order.push(Place { route, index: group.rays.len() as u32 });
        group.rays.push(ray);
        group.paths.push(path);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Forgets all rays, not the memory.
    pub(super) fn clear(&mut self) {
        self.order.clear();
        for group in &mut self.groups {
            group.rays.clear();
            group.paths.clear();
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
    pub(super) fn ray(&self, place: Place) -> (&Ray, &Path) {
        let group = &self.groups[usize::from(place.route.0)];
        (&group.rays[place.index as usize], &group.paths[place.index as usize])
    }

    /// What [`Generation::find_hits`] found.
    pub(super) fn hit(&self, place: Place) -> Option<Hit> {
        self.groups[usize::from(place.route.0)].hits[place.index as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn routes_are_told_apart_until_they_are_long() {
        let walk =
            |bounces: &[PathClass]| bounces.iter().fold(Route::CAMERA, |route, class| route.then(*class));
        let (mirror, glass) = (PathClass::Reflection, PathClass::Refraction);
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
