//! From triangles to a hierarchy, phase by phase.

use std::time::Instant;

use super::binary_tree::BinaryTree;
use super::brute_force::TriangleList;
use super::collapse::{self, Source};
use super::morton::MortonOrder;
use super::references::{Input, Reference};
use super::wide::WideTree;
use super::{
    BuildSettings, BuildStatistics, BuilderKind, Bvh, PrimitiveFlags, SimdLevel, Structure, cost_model,
    karras, linear_pass, ploc, splits,
};
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Triangle;

/// Builds hierarchies and keeps its scratch memory between frames.
#[derive(Debug, Default)]
pub struct Builder {
    split: splits::Scratch,
    references: Vec<Reference>,
    order: MortonOrder,
    tree: BinaryTree,
    karras: karras::Scratch,
    ploc: ploc::Scratch,
    collapse: collapse::Scratch,
}

/// Measures the seconds of one phase after the other.
struct Lap(Instant);

impl Builder {
    /// Builds the hierarchy of `triangles`, in parallel on the current rayon pool.
    ///
    /// `flags` has one entry a triangle. Hidden and degenerate triangles are left out; ids are places in `triangles`,
    /// of which there are fewer than 2²⁸. Memory of `recycled`, the last frame's hierarchy, is used again.
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
            BuilderKind::Auto | BuilderKind::Lbvh | BuilderKind::Karras | BuilderKind::Ploc => {
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
        let mut lap = Lap(Instant::now());
        let cancel = input.cancel;

        // Boxes of triangles, or of their parts.
        let gathered = splits::gather(input, settings, &mut self.split, &mut self.references)?;
        let measures = gathered.measures;
        let scale = measures.scale();
        let split_seconds = lap.seconds() - gathered.bounds_seconds;

        // Morton order.
        self.order.sort(&self.references, &measures.centers, cancel)?;
        let sort_seconds = lap.seconds();

        // The binary tree.
        let built = match settings.builder {
            BuilderKind::Auto => cost_model::choose(measures.count, settings.expected_rays),
            named => named,
        };
        let Self { references, order, tree, .. } = self;
        match built {
            BuilderKind::Karras => {
                karras::build(tree, order, references, &mut self.karras, (scale, cancel))?;
            }
            BuilderKind::Ploc => {
                ploc::build(tree, order, references, &mut self.ploc, (scale, cancel))?;
            }
            _ => linear_pass::build(tree, order, references, scale, cancel)?,
        }
        let tree_seconds = lap.seconds();

        // The tree that rays walk.
        let has_copies = measures.count != gathered.triangles;
        let source = Source { tree, input, scale, has_copies };
        wide.collapse(source, &mut self.collapse)?;
        let widen_seconds = lap.seconds();

        Ok(BuildStatistics {
            built,
            triangles: gathered.triangles,
            references: measures.count,
            sa_max: gathered.sa_max as f32,
            budget_reached: gathered.budget_reached,
            depth: self.tree.depth(),
            sah_cost: self.tree.sah_cost(&measures),
            bytes: wide.bytes(),
            bounds_seconds: gathered.bounds_seconds,
            split_seconds,
            sort_seconds,
            tree_seconds,
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
        built: BuilderKind::BruteForce,
        triangles: list.len(),
        references: list.len(),
        sa_max: f32::INFINITY,
        sah_cost: list.len() as f32,
        bytes: list.bytes(),
        ..BuildStatistics::default()
    };
    Bvh { structure: Structure::BruteForce(list), simd, statistics }
}
