//! Builder: runs the phases of a build and measures them.

use std::time::Instant;

use fearless_simd::Level;

use super::build::binary_tree::BinaryTree;
use super::build::clustering::Input as ClusteringInput;
use super::build::collapse::{self, CollapseInput};
use super::build::morton::MortonOrder;
use super::build::{Attempt, Refitter, cost_model, hploc};
use super::hierarchy::{Bvh, Structure};
use super::reference::{TriangleList, karras};
use super::references::{Input, Reference};
use super::settings::{BuildSettings, BuilderKind};
use super::split;
use super::statistics::{BuildKind, BuildStatistics};
use super::triangle_flags::TriangleFlags;
use super::wide_tree::WideTree;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Triangle;

/// Builds hierarchies. Keeps its scratch memory between frames.
#[derive(Debug, Default)]
pub struct Builder {
    split: split::Scratch,
    references: Vec<Reference>,
    order: MortonOrder,
    tree: BinaryTree,
    karras: karras::Scratch,
    hploc: hploc::Scratch,
    collapse: collapse::Scratch,
}

/// Stopwatch of successive phases.
struct Lap(Instant);

impl Builder {
    /// Builds the hierarchy of `triangles`, in parallel on the current rayon pool.
    ///
    /// `flags` has one entry per triangle; there are at most [`crate::bvh::MAX_TRIANGLES`]. Hidden and degenerate triangles are
    /// left out; hits name triangles by their index in `triangles`. The last frame's hierarchy is `recycled`: it is refitted where
    /// that pays, and otherwise its memory is reused.
    pub fn build(
        &mut self,
        triangles: &[Triangle],
        flags: &[TriangleFlags],
        settings: &BuildSettings,
        cancel: &CancelFlag,
        recycled: Option<Bvh>,
    ) -> Result<Bvh, Cancelled> {
        debug_assert_eq!(triangles.len(), flags.len());
        cancel.check()?;
        let level = settings.simd.level();
        match settings.builder {
            BuilderKind::BruteForce => Ok(brute_force(triangles, flags, level)),
            BuilderKind::Auto | BuilderKind::Lbvh | BuilderKind::Karras | BuilderKind::Ploc => {
                let input = Input { triangles, flags, cancel };
                self.refit_or_build(input, settings, level, recycled)
            }
        }
    }

    /// Refits the recycled tree to the moved triangles, or builds a new one in its memory.
    fn refit_or_build(
        &mut self,
        input: Input,
        settings: &BuildSettings,
        level: Level,
        recycled: Option<Bvh>,
    ) -> Result<Bvh, Cancelled> {
        let mut lap = Lap(Instant::now());
        let (mut wide, mut refitter, last) = match recycled {
            Some(Bvh { structure: Structure::Wide(wide), refitter, statistics, .. }) => {
                (wide, refitter, statistics)
            }
            _ => (WideTree::default(), Refitter::default(), BuildStatistics::default()),
        };
        let attempt = refitter.attempt(&mut wide, &last, input, settings)?;
        let refit_seconds = lap.seconds();
        let statistics = match attempt {
            Attempt::Refitted { cost_ratio } => BuildStatistics {
                kind: BuildKind::Refitted { cost_ratio: cost_ratio as f32 },
                refit_seconds,
                ..last.without_build_seconds()
            },
            Attempt::Rebuild(reason) => {
                refitter.forget();
                let built = self.build_wide(input, settings, &mut wide)?;
                BuildStatistics { kind: BuildKind::Built(reason), refit_seconds, ..built }
            }
        };
        Ok(Bvh { structure: Structure::Wide(wide), level, statistics, refitter })
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
        let gathered = split::gather(input, settings, &mut self.split, &mut self.references)?;
        let measures = gathered.measures;
        let scale = measures.scale();
        let split_seconds = lap.seconds() - gathered.bounds_seconds;

        // Morton order.
        self.order.sort(&self.references, &measures.centers, cancel)?;
        let sort_seconds = lap.seconds();

        // The binary tree.
        let builder = match settings.builder {
            BuilderKind::Auto => cost_model::choose(&measures, settings.expected_rays),
            named => named,
        };
        let Self { references, order, tree, .. } = self;
        if builder == BuilderKind::Karras {
            karras::build(tree, order, references, &mut self.karras, scale, cancel)?;
        } else {
            let clustering = cost_model::clustering(builder);
            let input = ClusteringInput { order, references, scale, clustering, cancel };
            input.build(tree, &mut self.hploc)?;
        }
        let tree_seconds = lap.seconds();

        // The wide tree.
        let has_copies = measures.count != gathered.triangles;
        let source = CollapseInput { tree, input, scale, has_copies };
        wide.collapse(source, &mut self.collapse)?;
        let collapse_seconds = lap.seconds();

        Ok(BuildStatistics {
            builder,
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
            collapse_seconds,
            ..BuildStatistics::default()
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

fn brute_force(triangles: &[Triangle], flags: &[TriangleFlags], level: Level) -> Bvh {
    let list = TriangleList::new(triangles, flags);
    let statistics = BuildStatistics {
        builder: BuilderKind::BruteForce,
        triangles: list.len(),
        references: list.len(),
        sa_max: f32::INFINITY,
        sah_cost: list.len() as f32,
        bytes: list.bytes(),
        ..BuildStatistics::default()
    };
    Bvh { structure: Structure::BruteForce(list), level, statistics, refitter: Refitter::default() }
}
