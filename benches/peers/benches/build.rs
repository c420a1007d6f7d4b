//! Build times of hierarchies by phase: `cargo bench -p peers --bench build [-- --size N… --threads N… SCENE…]`.
//!
//! Builds every scene of [`peers::test_scenes`], by default with 1 k, 10 k, 100 k, 1 M and 4 M triangles, on one and on two
//! threads. A row is one configuration. Its columns:
//!
//! * `triangles`, `references`: boxes that the hierarchy is built over, after early split clipping;
//! * `fresh`: wall-clock time of the first build with a new builder;
//! * `rebuild`: the best of six rebuilds, with the builder and the memory of the last hierarchy reused;
//! * `bounds`, `split`, `sort`, `tree`, `collapse`: phases of that rebuild (see [`rayframe::bvh::BuildStatistics`]);
//! * `Mtri/s`: millions of triangles per second of `rebuild`;
//! * `speedup`: `rebuild` on the first number of threads over this one;
//! * `B/tri`, `depth`, `sah`: bytes per triangle; depth and SAH cost of the binary tree;
//! * `/NAME`: `rebuild` of obvhs's preset NAME in the same run, over that of rayframe: above one, rayframe is
//!   faster. obvhs reuses its memory where it offers that, and orders its triangles by leaf, as rayframe does. Compiled without
//!   `RUSTFLAGS='-C target-cpu=native'`, it uses SSE2 only.
//!
//! Times are in milliseconds.

use std::error::Error;
use std::io::Write as _;

use peers::build::Cost;
use peers::configuration::CONFIGURATIONS;
use peers::obvhs_preset::{LIBRARY, Preset};
use peers::soup::Soup;
use peers::test_scenes::{self, TestScene};
use peers::{build, obvhs_build, obvhs_preset};
use rayon::{ThreadPool, ThreadPoolBuilder};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Presets of obvhs with comparable build times: a Morton-ordered tree, and its best trees for fast builds.
const PRESETS: [&str; 2] = ["bvh2-fastest", "bvh2-fast"];
const SIZES: [usize; 5] = [1_000, 10_000, 100_000, 1_000_000, 4_000_000];

/// Command-line options.
struct Options {
    scenes: Vec<String>,
    sizes: Vec<usize>,
    threads: Vec<usize>,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    let pools = options.threads.iter().map(|&threads| ThreadPoolBuilder::new().num_threads(threads).build());
    let pools: Vec<ThreadPool> = pools.collect::<std::result::Result<_, _>>()?;
    let presets = obvhs_preset::presets(|name| PRESETS.contains(&name));
    writeln!(std::io::stdout(), "milliseconds; ratios against {LIBRARY}\n{}", heading(&presets))?;
    for &size in &options.sizes {
        for scene in test_scenes::all(size) {
            if options.scenes.is_empty() || options.scenes.iter().any(|name| name == scene.name) {
                measure(scene, &pools, &presets)?;
            }
        }
    }
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let mut options = Options { scenes: Vec::new(), sizes: Vec::new(), threads: Vec::new() };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--size" => options.sizes.push(value()?.parse()?),
            "--threads" => options.threads.push(value()?.parse()?),
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            _ => options.scenes.push(argument),
        }
    }
    if options.sizes.is_empty() {
        options.sizes = SIZES.to_vec();
    }
    if options.threads.is_empty() {
        options.threads = vec![1, 2];
    }
    Ok(options)
}

/// Rows of one scene: every configuration on every number of threads.
fn measure(scene: TestScene, pools: &[ThreadPool], presets: &[Preset]) -> Result<()> {
    let theirs = obvhs_build::triangles(&scene.triangles);
    let soup = Soup::new(scene.triangles);
    let peers: Vec<Vec<f64>> = pools
        .iter()
        .map(|pool| {
            let seconds = |preset| obvhs_build::measure(&theirs, preset, pool).1[1];
            presets.iter().map(seconds).collect()
        })
        .collect();
    for configuration in &CONFIGURATIONS {
        let mut first_seconds = None;
        for (pool, peers) in pools.iter().zip(&peers) {
            let (_, cost) = build::measure(&soup, &configuration.settings(), pool)?;
            let speedup = *first_seconds.get_or_insert(cost.rebuild_seconds) / cost.rebuild_seconds;
            let key = (scene.name, configuration.name, pool.current_num_threads());
            writeln!(std::io::stdout(), "{}", row(key, &cost, speedup, peers))?;
        }
    }
    Ok(())
}

fn heading(presets: &[Preset]) -> String {
    let columns = ["fresh", "rebuild", "bounds", "split", "sort", "tree", "collapse", "Mtri/s", "speedup"];
    let columns: Vec<_> = columns.iter().map(|name| format!("{name:>9}")).collect();
    let ratios: Vec<_> =
        presets.iter().map(|preset| format!("{:>14}", format!("/{}", preset.name))).collect();
    let (columns, ratios) = (columns.concat(), ratios.concat());
    let key = format!("{:<8}{:<13}{:>3}{:>10}{:>11}", "scene", "config", "thr", "triangles", "references");
    format!("{key}{columns}{:>7}{:>7}{:>9}{ratios}", "B/tri", "depth", "sah")
}

fn row(key: (&str, &str, usize), cost: &Cost, speedup: f64, peers: &[f64]) -> String {
    let (scene, configuration, threads) = key;
    let tree = cost.fastest;
    let seconds = [
        cost.build_seconds,
        cost.rebuild_seconds,
        tree.bounds_seconds,
        tree.split_seconds,
        tree.sort_seconds,
        tree.tree_seconds,
        tree.collapse_seconds,
    ];
    let times: Vec<_> = seconds.iter().map(|seconds| format!("{:>9.2}", seconds * 1e3)).collect();
    let ratios: Vec<_> =
        peers.iter().map(|seconds| format!("{:>14.2}", seconds / cost.rebuild_seconds)).collect();
    let (times, ratios) = (times.concat(), ratios.concat());
    let speed = tree.triangles as f64 / cost.rebuild_seconds / 1e6;
    let bytes = tree.bytes as f64 / tree.triangles as f64;
    let key =
        format!("{scene:<8}{configuration:<13}{threads:>3}{:>10}{:>11}", tree.triangles, tree.references);
    format!(
        "{key}{times}{speed:>9.2}{speedup:>9.2}{bytes:>7.1}{:>7}{:>9.1}{ratios}",
        tree.depth, tree.sah_cost
    )
}
