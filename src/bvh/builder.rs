//! From triangles to a hierarchy, phase by phase.

use std::time::Instant;

use super::brute_force::TriangleList;
use super::collapse::Source;
use super::fit::FittedBoxes;
use super::lbvh::RadixTree;
use super::radix_sort::Keyed;
use super::split_clip::{self, Input, Reference};
use super::wide::WideTree;
use super::{
    BuildSettings, BuildStatistics, BuilderKind, Bvh, PrimitiveFlags, Structure, morton, radix_sort,
};
use super::{SimdLevel, split_threshold};
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Triangle;

/// Builds hierarchies and keeps its scratch memory between frames.
#[derive(Debug, Default)]
pub struct Builder {
    split: split_clip::Scratch,
    references: Vec<Reference>,
    keys: Vec<Keyed>,
    sort: Vec<Keyed>,
    tree: RadixTree,
    boxes: FittedBoxes,
}

/// Measures the seconds of one phase after the other.
struct Lap(Instant);

impl Builder {
    /// Builds the hierarchy of `triangles`, in parallel on the current rayon pool.
    ///
    /// `flags` has one entry a triangle. Hidden and degenerate triangles are left out; ids are places in `triangles`,
    /// of which there are fewer than 2³¹. Memory of `recycled`, the last frame's hierarchy, is used again.
    pub fn build(
        &mut self,
        triangles: &[Triangle],
        flags: &[PrimitiveFlags],
        settings: &BuildSettings,
        cancel: &CancelFlag,
        recycled: Option<Bvh>,
    ) -> Result<Bvh, Cancelled> {
        debug_assert_eq!(triangles.len(), flags.len());
        cancel.check()?;
        let simd = if settings.simd.is_supported() { settings.simd } else { SimdLevel::Scalar };
        match settings.builder {
            BuilderKind::BruteForce => Ok(brute_force(triangles, flags, simd)),
            BuilderKind::Auto | BuilderKind::Lbvh => {
                let input = Input { triangles, flags, cancel };
                let mut wide = match recycled {
                    Some(Bvh { structure: Structure::Wide(wide), .. }) => wide,
                    _ => WideTree::default(),
                };
                let statistics = self.build_wide(input, settings, &mut wide)?;
                Ok(Bvh { structure: Structure::Wide(wide), simd, statistics })
            }
        }
    }

    fn build_wide(
        &mut self,
        input: Input,
        settings: &BuildSettings,
        wide: &mut WideTree,
    ) -> Result<BuildStatistics, Cancelled> {
        let Input { triangles, flags, cancel } = input;
        let mut lap = Lap(Instant::now());

        // Boxes of triangles, or of their parts.
        let threshold =
            split_threshold::gather_references(input, settings, &mut self.split, &mut self.references)?;
        let split_seconds = lap.seconds();

        // Morton order.
        morton::codes(&self.references, &mut self.keys, cancel)?;
        radix_sort::sort(&mut self.keys, &mut self.sort, cancel)?;
        let sort_seconds = lap.seconds();

        // Radix tree.
        self.tree.link(&self.keys, cancel)?;
        let link_seconds = lap.seconds();

        // Its boxes.
        self.boxes.fit(&self.tree, &self.keys, &self.references, cancel)?;
        let fit_seconds = lap.seconds();

        // The tree that rays walk.
        let source =
            Source { tree: &self.tree, boxes: &self.boxes, keys: &self.keys, references: &self.references };
        wide.collapse(source, triangles, flags, cancel)?;
        let widen_seconds = lap.seconds();

        Ok(BuildStatistics {
            triangles: split_clip::count_triangles(&self.references),
            references: self.references.len(),
            sa_max: threshold.sa_max as f32,
            budget_reached: threshold.budget_reached,
            depth: self.boxes.depth(),
            sah_cost: self.boxes.sah_cost(self.references.len()),
            bytes: wide.bytes(),
            split_seconds,
            sort_seconds,
            link_seconds,
            fit_seconds,
            widen_seconds,
        })
    }
}

impl Lap {
    /// Seconds since the last call.
    fn seconds(&mut self) -> f64 {
        let last = std::mem::replace(&mut self.0, Instant::now());
        self.0.duration_since(last).as_secs_f64()
    }
}

fn brute_force(triangles: &[Triangle], flags: &[PrimitiveFlags], simd: SimdLevel) -> Bvh {
    let list = TriangleList::new(triangles, flags);
    let statistics = BuildStatistics {
        triangles: list.len(),
        references: list.len(),
        sa_max: f32::INFINITY,
        sah_cost: list.len() as f32,
        bytes: list.bytes(),
        ..BuildStatistics::default()
    };
    Bvh { structure: Structure::BruteForce(list), simd, statistics }
}
