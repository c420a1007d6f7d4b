//! Settings of a build. They change build and trace times, never the answers of queries.

use super::simd::SimdLevel;

/// Algorithm that builds the hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuilderKind {
    /// Karras' radix tree, clustered as far as the cost model expects to be fastest for the frame.
    #[default]
    Auto,
    /// Karras' radix tree over Morton codes, not clustered.
    Lbvh,
    /// Karras' radix tree, built node by node as in the paper: the reference implementation of [`BuilderKind::Lbvh`].
    Karras,
    /// Karras' radix tree, whose nodes merge the nearest clusters of their children (H-PLOC), under a top split by the surface
    /// area heuristic. Rays visit fewer nodes, and the build takes longer.
    Ploc,
    /// No hierarchy: every ray tests every triangle. Reference implementation for tests.
    BruteForce,
}

/// Triangles that are split before the hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// None.
    Off,
    /// Where boxes overlap heavily and the frame's rays save the time: those whose boxes waste most area (Karras and Aila 2013).
    Auto,
    /// Those whose box has a surface area above this many square metres (SA_max of Ernst and Greiner 2007). Below zero is zero.
    Area(f32),
}

/// Condition for refitting the last frame's hierarchy to moved triangles instead of rebuilding it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refit {
    /// Never refit.
    Off,
    /// Refit while the frame's rays lose less time than the rebuild would take.
    Auto,
    /// Refit while the SAH cost is at most this many times the least since the hierarchy was built.
    UpTo(f32),
}

/// Settings of [`crate::bvh::Builder::build`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildSettings {
    /// Algorithm that builds the hierarchy.
    pub builder: BuilderKind,
    /// Triangles that are split first.
    pub split: Split,
    /// Upper limit of references per triangle, on average, that splitting creates.
    pub reference_budget: f32,
    /// Rays of all kinds expected in the frame ([`crate::render::expected_rays`]); for more rays, [`BuilderKind::Auto`] builds a better tree,
    /// [`Split::Auto`] splits, and [`Refit::Auto`] rebuilds sooner.
    pub expected_rays: u64,
    /// Instruction set that traversal uses.
    pub simd: SimdLevel,
    /// Condition for refitting a recycled hierarchy.
    pub refit: Refit,
}

impl Default for BuildSettings {
    fn default() -> Self {
        Self {
            builder: BuilderKind::Auto,
            split: Split::Auto,
            reference_budget: 4.0,
            // An image of a million pixels with a shadow ray and a mirror ray each.
            expected_rays: 3 << 20,
            simd: SimdLevel::best(),
            refit: Refit::Auto,
        }
    }
}
