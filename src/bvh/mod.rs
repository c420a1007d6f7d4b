//! The acceleration structure: split triangles, Morton order, Karras' radix tree or a merged one, refitting, and traversal.
//!
//! [`Builder::build`] turns a frame's triangles into a [`Bvh`]; three queries trace it ray by ray, two of them also by batch.
//! The builders know only boxes, the traversal knows only triangles and their [`PrimitiveFlags`]; neither knows what a
//! material is. Whatever the settings, a query gives the same answer to the last bit: what a hit is, is defined in
//! [`crate::geometry`], and of hits with equal `t` the lowest primitive id wins.

mod binary_tree;
mod brute_force;
mod builder;
mod clusters;
mod collapse;
mod cost_model;
mod fit;
mod karras;
mod lbvh;
mod linear_pass;
mod morton;
mod ploc;
mod query;
mod radix_sort;
mod references;
mod refit;
mod simd;
mod split_budget;
mod split_clip;
mod split_cut;
mod split_priority;
mod split_threshold;
mod splits;
mod sweep;
mod traverse;
mod validate;
mod wide;

use crate::geometry::{Facing, Ray};

pub use builder::Builder;
pub use refit::Reason;
pub use simd::SimdLevel;

use brute_force::TriangleList;
use query::{Any, Judge, Nearest};
use refit::Refitter;
use wide::WideTree;

/// Most triangles that a hierarchy can number.
pub const MOST_TRIANGLES: usize = wide::MOST_REFERENCES;

/// What traversal must know of a triangle besides its corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct PrimitiveFlags(pub u8);

impl PrimitiveFlags {
    /// The back face is invisible to [`Bvh::closest_hit`]; the other queries see it.
    pub const SINGLE_SIDED: Self = Self(1);
    /// Whether a hit counts is asked of the query's filter.
    pub const FILTERED: Self = Self(2);
    /// The triangle is kept out of the structure (hidden, or of zero area); its id stays taken.
    pub const HIDDEN: Self = Self(4);

    /// Both sets of flags.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all flags of `other` are set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Where a ray meets the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// Index of the triangle in the frame.
    pub primitive: u32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex.
    pub v: f32,
    /// The side that was met.
    pub facing: Facing,
}

impl Hit {
    /// The place of this hit in the order that all hits along one ray have.
    pub fn order(&self) -> HitOrder {
        HitOrder { t: self.t, primitive: self.primitive }
    }
}

/// The total order of hits along a ray: by `t`, then by primitive id.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct HitOrder {
    /// Ray parameter.
    pub t: f32,
    /// Index of the triangle in the frame.
    pub primitive: u32,
}

/// How the hierarchy is built. The answers of queries do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuilderKind {
    /// What is fastest for the frame.
    #[default]
    Auto,
    /// Karras' radix tree over Morton codes, by a pass that gives the same tree faster.
    Lbvh,
    /// Karras' radix tree, node by node as in the paper.
    Karras,
    /// Neighbours in Morton order merged upward, under a top divided by the surface area heuristic: a better tree for
    /// some more time.
    Ploc,
    /// No hierarchy: every ray tests every triangle. The slow twin for tests.
    BruteForce,
}

/// Which triangles are split before the hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// None.
    Off,
    /// Where boxes overlap massively, those whose boxes waste most area (Karras and Aila 2013).
    Auto,
    /// Those whose box surface area exceeds this many square metres (SA_max of Ernst and Greiner 2007).
    Area(f32),
}

/// Whether the last frame's hierarchy is fitted to triangles that moved instead of building another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refit {
    /// Never.
    Off,
    /// Where it costs the frame's rays less than it saves.
    Auto,
    /// While the SAH cost is at most this many times the least since the hierarchy was built.
    UpTo(f32),
}

/// Settings of [`Builder::build`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildSettings {
    /// Which hierarchy.
    pub builder: BuilderKind,
    /// Which triangles are split.
    pub split: Split,
    /// Most references a triangle on average that splitting may make.
    pub reference_budget: f32,
    /// Rays that will be traced, of all kinds: many are worth a better tree ([`BuilderKind::Auto`]).
    pub expected_rays: u64,
    /// Lanes that traversal uses.
    pub simd: SimdLevel,
    /// Whether a recycled hierarchy is refitted.
    pub refit: Refit,
}

/// What a query did, summed over rays by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalCounters {
    /// Rays traced.
    pub rays: u64,
    /// Wide nodes whose child boxes were tested; rays that are traced together count one.
    pub nodes: u64,
    /// Triangles tested; each counts one for up to sixteen rays that are traced together.
    pub triangles: u64,
}

/// How a hierarchy came to fit its triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// It was built for them.
    Built(Reason),
    /// The last frame's was fitted to them; its SAH cost over the least since it was built.
    Refitted(f32),
}

/// What was built and how long each phase took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStatistics {
    /// Which hierarchy it is; never `Auto`.
    pub built: BuilderKind,
    /// Built or refitted, and why.
    pub origin: Origin,
    /// Triangles that are not hidden.
    pub triangles: usize,
    /// Boxes over which the hierarchy was built; `references / triangles` is R of Ernst and Greiner.
    pub references: usize,
    /// The SA_max that was used, square metres; infinite unless an area was asked for.
    pub sa_max: f32,
    /// Whether the reference budget raised an explicit SA_max.
    pub budget_reached: bool,
    /// Levels of the binary tree; a single leaf has depth 0.
    pub depth: u32,
    /// Surface area heuristic cost of the binary tree with unit costs for nodes and triangles.
    pub sah_cost: f32,
    /// Bytes of the traversal structure.
    pub bytes: usize,
    /// Seconds of the boxes of whole triangles.
    pub bounds_seconds: f64,
    /// Seconds of splitting.
    pub split_seconds: f64,
    /// Seconds of Morton codes and sorting.
    pub sort_seconds: f64,
    /// Seconds of building the binary tree with its boxes.
    pub tree_seconds: f64,
    /// Seconds of collapsing to the wide tree.
    pub widen_seconds: f64,
    /// Seconds of refitting, also where it came to nothing.
    pub refit_seconds: f64,
}

impl BuildStatistics {
    /// The same of a hierarchy that took no time to build.
    fn without_seconds(&self) -> Self {
        Self {
            bounds_seconds: 0.0,
            split_seconds: 0.0,
            sort_seconds: 0.0,
            tree_seconds: 0.0,
            widen_seconds: 0.0,
            ..*self
        }
    }
}

impl Default for Origin {
    fn default() -> Self {
        Self::Built(Reason::First)
    }
}

/// A hierarchy over one frame's triangles.
#[derive(Debug)]
pub struct Bvh {
    structure: Structure,
    level: fearless_simd::Level,
    statistics: BuildStatistics,
    refitter: Refitter,
}

#[derive(Debug)]
enum Structure {
    Wide(WideTree),
    BruteForce(TriangleList),
}

impl Default for BuildSettings {
    fn default() -> Self {
        Self {
            builder: BuilderKind::Auto,
            split: Split::Auto,
            reference_budget: 4.0,
            // A picture of a million pixels with a shadow ray and a mirror ray each.
            expected_rays: 3 << 20,
            simd: SimdLevel::best(),
            refit: Refit::Auto,
        }
    }
}

impl Bvh {
    /// What was built.
    pub fn statistics(&self) -> BuildStatistics {
        self.statistics
    }

    /// The first visible hit of `ray` after `after`: back faces of single-sided triangles do not count, and those of
    /// filtered triangles only where `filter` says so.
    pub fn closest_hit(
        &self,
        ray: &Ray,
        after: Option<HitOrder>,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        self.nearest(ray, Nearest::<true>::new(ray, after, &filter), counters)
    }

    /// The first hit of `ray` after `after` on either side of any triangle that `filter` lets count. Here `filter` is
    /// asked about filtered triangles only, too.
    pub fn closest_surface(
        &self,
        ray: &Ray,
        after: Option<HitOrder>,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        self.nearest(ray, Nearest::<false>::new(ray, after, &filter), counters)
    }

    /// Whether any triangle, from either side, meets `ray`; filtered ones only where `filter` says so.
    ///
    /// The order in which `filter` is asked is not defined.
    pub fn occluded(
        &self,
        ray: &Ray,
        filter: impl Fn(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        counters.rays += 1;
        let mut any = Any::new(ray, &filter);
        match &self.structure {
            Structure::Wide(tree) => traverse::walk(self.level, &Judge { tree, ray }, &mut any, counters),
            Structure::BruteForce(list) => list.walk(ray, &mut any, counters),
        }
        any.found
    }

    /// [`Bvh::closest_hit`] of every ray of a batch, into the places of `hits`; `filter` is told the ray's subscript.
    ///
    /// Rays that stand together should run together: neighbours in the batch share their walks where they can.
    pub fn closest_hits(
        &self,
        rays: &[Ray],
        filter: impl Fn(usize, &Hit) -> bool,
        hits: &mut [Option<Hit>],
        counters: &mut TraversalCounters,
    ) {
        counters.rays += rays.len() as u64;
        match &self.structure {
            Structure::Wide(tree) => {
                let batch = traverse::Batch { level: self.level, tree, rays, filter: &filter };
                traverse::closest_hits(batch, hits, counters);
            }
            Structure::BruteForce(list) => {
                for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
                    let filter = |hit: &Hit| filter(i, hit);
                    let mut nearest = Nearest::<true>::new(ray, None, &filter);
                    list.walk(ray, &mut nearest, counters);
                    *hit = nearest.exact();
                }
            }
        }
    }

    /// [`Bvh::occluded`] of every ray of a batch, into the places of `occluded`; `filter` is told the ray's subscript.
    pub fn occluded_rays(
        &self,
        rays: &[Ray],
        filter: impl Fn(usize, &Hit) -> bool,
        occluded: &mut [bool],
        counters: &mut TraversalCounters,
    ) {
        counters.rays += rays.len() as u64;
        match &self.structure {
            Structure::Wide(tree) => {
                let batch = traverse::Batch { level: self.level, tree, rays, filter: &filter };
                traverse::occluded_rays(batch, occluded, counters);
            }
            Structure::BruteForce(list) => {
                for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
                    let filter = |hit: &Hit| filter(i, hit);
                    let mut any = Any::new(ray, &filter);
                    list.walk(ray, &mut any, counters);
                    *occluded = any.found;
                }
            }
        }
    }

    fn nearest<const CULL: bool>(
        &self,
        ray: &Ray,
        mut nearest: Nearest<CULL>,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        counters.rays += 1;
        match &self.structure {
            Structure::Wide(tree) => {
                let judge = Judge { tree, ray };
                traverse::walk(self.level, &judge, &mut nearest, counters);
                nearest.finish(&judge)
            }
            Structure::BruteForce(list) => {
                list.walk(ray, &mut nearest, counters);
                nearest.exact()
            }
        }
    }
}
