//! Cost model of [`BuilderKind::Auto`]: chooses between the radix tree and PLOC.
//!
//! PLOC costs more per reference than the radix tree ([`super::lbvh`]) and saves a part of each ray's time. Morton order knows only
//! centres and puts large boxes among small ones; PLOC separates them. So it saves nothing where all boxes have one size, as
//! in a finely divided mesh.
//!
//! Measured on Zen 4: PLOC takes some 30 ns per reference more. Rays visit 0.45 to 0.95 times as many nodes in scenes whose
//! areas have an unevenness of 13 and more, and as many as before in spheres of even triangles, at 1.1.

use crate::bvh::references::Measures;
use crate::bvh::settings::BuilderKind;

/// Nanoseconds per reference that PLOC takes beyond the radix tree.
const PLOC_NS_PER_REFERENCE: f64 = 30.0;
/// Nanoseconds per ray that PLOC saves: a seventh of a ray's time in batches.
const SAVED_NS_PER_RAY: f64 = 6.0;
/// Unevenness of areas from which PLOC pays.
const MIN_UNEVENNESS: f64 = 4.0;

/// Builder with the least expected time of build and trace together.
pub(crate) fn choose(references: &Measures, expected_rays: u64) -> BuilderKind {
    let cost = references.count as f64 * PLOC_NS_PER_REFERENCE;
    let saving = expected_rays as f64 * SAVED_NS_PER_RAY;
    if references.unevenness() >= MIN_UNEVENNESS && cost < saving {
        BuilderKind::Ploc
    } else {
        BuilderKind::Lbvh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measures of `count` references, of which `large` have area 100 and the others area 1.
    fn measures(count: usize, large: usize) -> Measures {
        let [small, large] = [count - large, large].map(|count| count as f64);
        let (area_sum, area_square_sum) = (small + 100.0 * large, small + 10_000.0 * large);
        Measures { count, area_sum, area_square_sum, ..Measures::NONE }
    }

    #[test]
    fn ploc_is_chosen_for_many_rays_and_few_references() {
        let uneven = |count| measures(count, count / 100);
        assert_eq!(choose(&uneven(70_000), 3 << 20), BuilderKind::Ploc);
        assert_eq!(choose(&uneven(1_000_000), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(70_000), 10_000), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(1_000_000), 100 << 20), BuilderKind::Ploc);
    }

    #[test]
    fn even_meshes_get_the_radix_tree() {
        assert_eq!(choose(&measures(70_000, 0), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&Measures::NONE, 3 << 20), BuilderKind::Lbvh);
    }
}
