//! The acceleration structure: early split clipping, Morton order, Karras' radix tree, and its traversal.
//!
//! [`Builder::build`] turns a frame's triangles into a [`Bvh`]; three queries trace it. The builders know only boxes,
//! the traversal knows only triangles and their [`PrimitiveFlags`]; neither knows what a material is.
//! Whatever the settings, a query gives the same answer to the last bit: what a hit is, is defined in
//! [`crate::geometry`], and of hits with equal `t` the lowest primitive id wins.

mod binary_tree;
mod brute_force;
mod builder;
mod clusters;
mod collapse;
mod cost_model;
mod fit;
mod karras;
mod lanes;
mod lbvh;
mod linear_pass;
mod morton;
mod ploc;
mod query;
mod radix_sort;
mod references;
mod split_budget;
mod split_clip;
mod split_priority;
mod split_threshold;
mod splits;
mod sweep;
mod traverse;
mod validate;
mod wide;

use crate::geometry::{Facing, Ray};

pub use builder::Builder;

use brute_force::TriangleList;
use query::{Any, Nearest, Visitor};
use traverse::Walk;
use wide::WideTree;

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

/// Early split clipping: which triangles are split before the hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// None.
    Off,
    /// Those whose box area exceeds a threshold chosen from the scene.
    Auto,
    /// Those whose box surface area exceeds this many square metres (SA_max of Ernst and Greiner 2007).
    Area(f32),
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
}

/// Instruction sets that traversal can use; each gives the same answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SimdLevel {
    /// Plain Rust, on every machine.
    Scalar,
    /// x86-64 with AVX2: eight lanes.
    Avx2,
}

/// What a query did, summed over rays by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalCounters {
    /// Rays traced.
    pub rays: u64,
    /// Wide nodes whose child boxes were tested.
    pub nodes: u64,
    /// Triangles tested.
    pub triangles: u64,
}

/// What was built and how long each phase took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStatistics {
    /// Which hierarchy it is; never `Auto`.
    pub built: BuilderKind,
    /// Triangles that are not hidden.
    pub triangles: usize,
    /// Boxes over which the hierarchy was built; `references / triangles` is R of Ernst and Greiner.
    pub references: usize,
    /// The SA_max that was used, square metres; infinite when nothing is split.
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
}

/// A hierarchy over one frame's triangles.
#[derive(Debug)]
pub struct Bvh {
    structure: Structure,
    simd: SimdLevel,
    statistics: BuildStatistics,
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
        self.nearest(ray, Nearest::<_, true>::new(ray, after, filter), counters)
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
        self.nearest(ray, Nearest::<_, false>::new(ray, after, filter), counters)
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
        let mut any = Any::new(ray, filter);
        self.walk(ray, &mut any, counters);
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
        for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            *hit = self.closest_hit(ray, None, |hit| filter(i, hit), counters);
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
        for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
            *occluded = self.occluded(ray, |hit| filter(i, hit), counters);
        }
    }

    #[inline]
    fn nearest<F: Fn(&Hit) -> bool, const CULL: bool>(
        &self,
        ray: &Ray,
        mut nearest: Nearest<F, CULL>,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        self.walk(ray, &mut nearest, counters);
        nearest.best
    }

    #[inline]
    fn walk(&self, ray: &Ray, visitor: &mut impl Visitor, counters: &mut TraversalCounters) {
        counters.rays += 1;
        match &self.structure {
            Structure::Wide(tree) => lanes::dispatch(self.simd, Walk { tree, ray, visitor }, counters),
            Structure::BruteForce(list) => list.walk(ray, visitor, counters),
        }
    }
}
