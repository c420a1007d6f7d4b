//! Cost model of [`BuilderKind::Auto`]: how far Karras' radix tree is clustered.
//!
//! Clustering costs time per reference and saves a part of each ray's time. Morton order knows only centres and puts large boxes
//! among small ones; clustering separates them. So it saves less where most boxes have one size, as in a finely divided
//! mesh. The measure of that is the variance of the boxes' octaves of area, in which a few huge boxes hardly count.
//!
//! Measured on Zen 4 and 5: the variance is 0.3 for meshes of even triangles, even above a ground of two triangles, and from 9 to 100
//! for architecture and models in large environs. Rays visit 0.45 to 0.9 times as many nodes in the latter. Clustering takes 44 to 67 ns
//! per reference and saves 1.4 (a model in large environs) to 7 ns per ray (slabs and beams); interiors save 4 to 5. Of even meshes, a
//! scanned one saves nothing, a sphere 1 to 2, and many spheres side by side 5 to 7, whose neighbours Morton order mixes.

use super::clustering::Clustering;
use crate::bvh::references::Measures;
use crate::bvh::settings::BuilderKind;

/// Nanoseconds per reference that clustering takes beyond the radix tree. Refitting saves them where the tree is clustered.
pub(super) const CLUSTERING_NS_PER_REFERENCE: f64 = 60.0;
/// Nanoseconds per expected ray that clustering saves where areas are uneven and where they are even: the lower half of what was measured, since
/// a wrong choice for few rays costs more of the frame than one for many, and more rays are expected than pixels that see surfaces send.
/// If an even mesh gains nothing, clustering takes at most 1 ns a ray longer, about a hundredth of tracing and shading it.
const SAVED_NS_PER_RAY: [f64; 2] = [2.0, 1.0];
/// Variance of octaves from which areas are uneven.
const MIN_OCTAVE_VARIANCE: f64 = 1.0;

/// Clustering of a builder.
pub(crate) fn clustering(builder: BuilderKind) -> Clustering {
    match builder {
        BuilderKind::Ploc => Clustering::MERGED,
        _ => Clustering::NONE,
    }
}

/// Builder with the least expected time of build and trace together.
pub(crate) fn choose(references: &Measures, expected_rays: u64) -> BuilderKind {
    let cost = references.count as f64 * CLUSTERING_NS_PER_REFERENCE;
    let [uneven, even] = SAVED_NS_PER_RAY;
    let saved = if references.octave_variance() >= MIN_OCTAVE_VARIANCE { uneven } else { even };
    if references.count > 0 && cost < expected_rays as f64 * saved {
        BuilderKind::Ploc
    } else {
        BuilderKind::Lbvh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measures of `count` references, of which `large` are eight octaves above the others.
    fn measures(count: usize, large: usize) -> Measures {
        let large = large as u64;
        Measures { count, octave_sum: 8 * large, octave_square_sum: 64 * large, ..Measures::NONE }
    }

    #[test]
    fn clustering_is_chosen_for_many_rays_and_few_references() {
        let uneven = |count| measures(count, count / 10);
        assert_eq!(choose(&uneven(70_000), 3 << 20), BuilderKind::Ploc);
        assert_eq!(choose(&uneven(1_000_000), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(70_000), 10_000), BuilderKind::Lbvh);
        assert_eq!(choose(&uneven(1_000_000), 100 << 20), BuilderKind::Ploc);
    }

    #[test]
    fn even_meshes_are_clustered_for_more_rays() {
        assert_eq!(choose(&measures(70_000, 0), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&measures(70_000, 0), 9 << 20), BuilderKind::Ploc);
        // A ground of two triangles does not make a mesh uneven.
        assert_eq!(choose(&measures(70_000, 2), 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(&Measures::NONE, 3 << 20), BuilderKind::Lbvh);
    }
}
