//! Which hierarchy [`BuilderKind::Auto`] builds.
//!
//! Merging ([`super::ploc`]) costs more than the linear pass for each reference, and saves a part of each ray's time. What it
//! saves are the large boxes that Morton order, which knows only centres, puts among small ones. So it saves nothing where
//! all are of one size, as in a finely divided mesh.
//!
//! Measured on Zen 4: merging takes some 30 ns a reference more, and rays visit 0.45 to 0.95 as many nodes in scenes
//! whose areas have an unevenness of 13 and more, and as many as before in spheres of even triangles, at 1.1.

use crate::bvh::references::Measures;
use crate::bvh::settings::BuilderKind;

/// Nanoseconds that merging costs a reference.
const PLOC_NS_PER_REFERENCE: f64 = 30.0;
/// Nanoseconds that it saves a ray: a seventh of what one takes in batches.
const SAVED_NS_PER_RAY: f64 = 6.0;
/// The unevenness of areas from which on it does.
const UNEVEN: f64 = 4.0;

/// The hierarchy for which build and trace together are expected to take the least time.
pub(crate) fn choose(references: &Measures, expected_rays: u64) -> BuilderKind {
    let cost = references.count as f64 * PLOC_NS_PER_REFERENCE;
    let saving = expected_rays as f64 * SAVED_NS_PER_RAY;
    if references.unevenness() >= UNEVEN && cost < saving { BuilderKind::Ploc } else { BuilderKind::Lbvh }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of so many references, all of area one but for a few of area 100.
    fn measures(count: usize, large: usize) -> Measures {
        let [small, large] = [count - large, large].map(|count| count as f64);
        let (area_sum, area_square_sum) = (small + 100.0 * large, small + 10_000.0 * large);
        Measures { count, area_sum, area_square_sum, ..Measures::NONE }
    }

    #[test]
    fn effort_grows_with_rays_and_shrinks_with_references() {
        let uneven = |count| measures(count, count / 100);
        assert_eq!(choose(&uneven(70_000), 3 << 20), BuilderKind::Ploc);
        assert_eq!(choose(&uneven(1_000_000), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(70_000), 10_000), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(1_000_000), 100 << 20), BuilderKind::Ploc);
    }

    #[test]
    fn even_meshes_need_no_effort() {
        assert_eq!(choose(&measures(70_000, 0), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&Measures::NONE, 3 << 20), BuilderKind::Lbvh);
    }
}
