//! Statistics of builds and counters of queries.

use super::settings::BuilderKind;

/// Work done by queries, summed over rays by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalCounters {
    /// Rays traced.
    pub rays: u64,
    /// Wide nodes whose child boxes were tested; a visit by a packet counts once.
    pub nodes: u64,
    /// Triangles tested; a test of up to sixteen rays of a packet counts once.
    pub triangles: u64,
}

/// How the hierarchy of a frame was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildKind {
    /// It was built.
    Built(RebuildReason),
    /// The last frame's hierarchy was refitted.
    Refitted {
        /// SAH cost over the least since the hierarchy was built.
        cost_ratio: f32,
    },
}

/// Why a hierarchy was built rather than refitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RebuildReason {
    /// No previous hierarchy exists, or it is a single leaf.
    NoPreviousTree,
    /// Refitting is off.
    RefittingOff,
    /// The set of traced triangles changed.
    OtherTriangles,
    /// Parts of split triangles take longer to follow than to build anew.
    SplitTriangles,
    /// After refitting, rays would lose more time than a rebuild takes.
    CostRatioTooHigh,
    /// Recent attempts failed, so no attempt was made in this frame.
    Pausing,
}

/// Result, size and phase times of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStatistics {
    /// Algorithm that was used; never `Auto`.
    pub builder: BuilderKind,
    /// Built or refitted.
    pub kind: BuildKind,
    /// Triangles that are neither hidden nor degenerate.
    pub triangles: usize,
    /// Boxes over which the hierarchy was built; `references / triangles` is R of Ernst and Greiner.
    pub references: usize,
    /// The SA_max that was used, square metres; infinite unless an area was set.
    pub sa_max: f32,
    /// Whether the reference budget raised the SA_max that was set.
    pub budget_reached: bool,
    /// Levels of the binary tree; a single leaf has depth 0.
    pub depth: u32,
    /// Surface area heuristic cost of the binary tree, with unit costs for nodes and triangles.
    pub sah_cost: f32,
    /// Bytes of the traversal structure.
    pub bytes: usize,
    /// Seconds spent on the boxes of whole triangles.
    pub bounds_seconds: f64,
    /// Seconds spent on splitting.
    pub split_seconds: f64,
    /// Seconds spent on Morton codes and sorting.
    pub sort_seconds: f64,
    /// Seconds spent on the binary tree with its boxes.
    pub tree_seconds: f64,
    /// Seconds spent on the collapse to the wide tree.
    pub collapse_seconds: f64,
    /// Seconds spent on refitting, failed attempts included.
    pub refit_seconds: f64,
}

impl BuildStatistics {
    /// The same statistics with all phase times zero but that of refitting.
    pub(super) fn without_build_seconds(&self) -> Self {
        Self {
            bounds_seconds: 0.0,
            split_seconds: 0.0,
            sort_seconds: 0.0,
            tree_seconds: 0.0,
            collapse_seconds: 0.0,
            ..*self
        }
    }
}

impl Default for BuildKind {
    fn default() -> Self {
        Self::Built(RebuildReason::NoPreviousTree)
    }
}
