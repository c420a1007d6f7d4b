//! What each kind of hierarchy costs a frame, beside the automatic choice: `--kinds`.

use std::io::Write as _;

use rayframe::bvh::{BuildSettings, BuildStatistics, BuilderKind, Refit, Split};
use rayframe::render::expected_rays;

use super::{Options, Result, Subject};

/// A kind of hierarchy. All but the automatic one are built as if there were as many rays as could be: what overlaps is split.
const KINDS: [(&str, BuilderKind, Split); 5] = [
    ("auto", BuilderKind::Auto, Split::Auto),
    ("lbvh", BuilderKind::Lbvh, Split::Off),
    ("ploc", BuilderKind::Ploc, Split::Off),
    ("lbvh+split", BuilderKind::Lbvh, Split::Auto),
    ("ploc+split", BuilderKind::Ploc, Split::Auto),
];
/// Share of a frame that the automatic choice may take longer than the fastest kind.
const LIMIT: f64 = 0.03;

/// What the hierarchies of a scene cost.
struct KindCosts {
    trees: [BuildStatistics; KINDS.len()],
    /// Least seconds of building and of all queries on one thread.
    seconds: [f64; KINDS.len()],
    /// Least seconds of building and tracing by the automatic choice.
    frame_seconds: f64,
}

/// Prints the table.
pub(super) fn print_kinds(options: &Options) -> Result<()> {
    if options.threads > 1 {
        return Err("--kinds measures on one thread".into());
    }
    let mut out = std::io::stdout();
    let names = KINDS.map(|(name, ..)| format!("{name:>12}")).concat();
    writeln!(out, "build and queries in milliseconds on one thread, least of {} frames", options.frames)?;
    writeln!(out, "{:<32}{:>9}{:>12}{names}{:>9}{:>9}", "scene", "boxes", "chosen", "frame", "slower")?;
    let (mut largest, mut slower) = (0.0_f64, Vec::new());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for path in &options.scenes {
        let costs = pool.install(|| Subject::open(path, options.size)?.kind_costs(options.frames))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let excess = costs.excess();
        writeln!(out, "{name:<32}{}{:>8.1}%", costs.columns(), 100.0 * excess)?;
        largest = largest.max(excess);
        if excess > LIMIT {
            slower.push(name.into_owned());
        }
    }
    let names = if slower.is_empty() { "none".to_owned() } else { slower.join(", ") };
    writeln!(
        out,
        "at most {:.1} % of a frame slower; over {:.0} %: {names}",
        100.0 * largest,
        100.0 * LIMIT
    )?;
    Ok(())
}

impl Subject {
    fn kind_costs(&mut self, rounds: usize) -> rayframe::error::Result<KindCosts> {
        let mut costs = KindCosts {
            trees: Default::default(),
            seconds: [f64::INFINITY; KINDS.len()],
            frame_seconds: f64::INFINITY,
        };
        self.frame.pose(&self.scene, &self.selection, 0.0);
        let expected = expected_rays(&self.settings, 1, &self.frame, &self.environment());
        for _ in 0..rounds {
            for (kind, (_, builder, split)) in KINDS.into_iter().enumerate() {
                let expected_rays = if builder == BuilderKind::Auto { expected } else { u64::MAX };
                let build = BuildSettings {
                    builder,
                    split,
                    expected_rays,
                    refit: Refit::Off,
                    ..BuildSettings::default()
                };
                let (_, rays) = self.build_and_trace(&build)?;
                let tree = self.bvh.as_ref().map(rayframe::bvh::Bvh::statistics).unwrap_or_default();
                let building = tree.bounds_seconds
                    + tree.split_seconds
                    + tree.sort_seconds
                    + tree.tree_seconds
                    + tree.collapse_seconds;
                costs.trees[kind] = tree;
                costs.seconds[kind] = costs.seconds[kind].min(building + rays.integrator.query_seconds);
                if kind == 0 {
                    costs.frame_seconds = costs.frame_seconds.min(building + rays.trace_seconds);
                }
            }
        }
        Ok(costs)
    }
}

impl KindCosts {
    /// How much longer the frame takes with the automatic choice than with the fastest kind, as a share. Equal hierarchies take equally long.
    fn excess(&self) -> f64 {
        let of = |tree: &BuildStatistics| (tree.references, tree.sah_cost.to_bits(), tree.depth);
        let least = self.seconds.iter().copied().fold(f64::INFINITY, f64::min);
        let equal = self.trees.iter().zip(self.seconds).filter(|(tree, _)| of(tree) == of(&self.trees[0]));
        let automatic = equal.map(|(_, seconds)| seconds).fold(f64::INFINITY, f64::min);
        (automatic - least) / self.frame_seconds
    }

    fn columns(&self) -> String {
        let times = self.seconds.map(|seconds| format!("{:>12.2}", 1e3 * seconds)).concat();
        let BuildStatistics { builder, references, triangles, .. } = self.trees[0];
        let is = (builder == BuilderKind::Ploc, references > triangles);
        let chosen = match is {
            (true, true) => "ploc+split",
            (true, false) => "ploc",
            (false, true) => "lbvh+split",
            (false, false) => "lbvh",
        };
        format!("{:>9}{chosen:>12}{times}{:>9.1}", self.trees[0].references, 1e3 * self.frame_seconds)
    }
}
