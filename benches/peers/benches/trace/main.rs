//! Trace speed of hierarchies: `cargo bench -p peers --bench trace [-- --size N --side N --threads N --config NAME… SCENE…]`.
//!
//! Traces every scene of [`peers::test_scenes`], with 100 k triangles, and the rays of an image of 512x512 pixels (see `views`), on
//! one thread. A row is one configuration of the hierarchy and one set of rays. Its columns:
//!
//! * `rays`: number of rays; `hits`: share of rays with a hit;
//! * `single`: millions of rays per second, one query per ray. Threads pull chunks of 8192 rays; the time is their processor
//!   time, summed over threads, over their number; the best of three passes;
//! * `batch`: the same by batch queries of 256 consecutive rays; shadow rays start at the light there (see `ray_set`);
//! * `nodes`, `tris`: wide nodes visited and triangles tested per ray, single rays; `b.nodes`, `b.tris`: in batches;
//! * `/NAME`: `single` over that of obvhs's preset NAME on the same rays in the same run: above one, rayframe is
//!   faster. Compiled without `RUSTFLAGS='-C target-cpu=native'`, obvhs uses SSE2 only.

mod views;

use std::error::Error;
use std::io::Write as _;

use peers::configuration::{CONFIGURATIONS, Configuration};
use peers::hierarchy::hierarchy;
use peers::obvhs_preset::{LIBRARY, Preset};
use peers::ray_set::RaySet;
use peers::soup::Soup;
use peers::test_scenes::{self, TestScene};
use peers::{obvhs_build, obvhs_preset, obvhs_trace, trace};
use rayframe::bvh::{BuildSettings, Bvh};
use rayon::ThreadPoolBuilder;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Presets of obvhs that trace fastest.
const PRESETS: [&str; 2] = ["bvh2-medium+split", "cwbvh-medium+split"];

/// Command-line options.
struct Options {
    scenes: Vec<String>,
    configurations: Vec<String>,
    size: usize,
    side: u32,
    threads: usize,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    let presets = obvhs_preset::presets(|name| PRESETS.contains(&name));
    writeln!(
        std::io::stdout(),
        "millions of rays a second, {} threads; ratios against {LIBRARY}\n{}",
        options.threads,
        heading(&presets)
    )?;
    for scene in test_scenes::all(options.size) {
        if options.scenes.is_empty() || options.scenes.iter().any(|name| name == scene.name) {
            measure(scene, &options, &presets)?;
        }
    }
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let (scenes, configurations) = (Vec::new(), Vec::new());
    let mut options = Options { scenes, configurations, size: 100_000, side: 512, threads: 1 };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--size" => options.size = value()?.parse()?,
            "--side" => options.side = value()?.parse()?,
            "--threads" => options.threads = value()?.parse()?,
            "--config" => options.configurations.push(value()?),
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            _ => options.scenes.push(argument),
        }
    }
    if !options.side.is_power_of_two() || options.side > 4096 || options.threads == 0 {
        return Err("--side is a power of two up to 4096, --threads at least 1".into());
    }
    Ok(options)
}

/// Rows of one scene: every configuration and every set of rays.
fn measure(scene: TestScene, options: &Options, presets: &[Preset]) -> Result<()> {
    let TestScene { name, triangles } = scene;
    let theirs = obvhs_build::triangles(&triangles);
    let soup = Soup::new(triangles);
    let bvh = hierarchy(&soup, &BuildSettings::default())?;
    let sets = views::ray_sets(&soup, &bvh, options.side);
    let peers = peers(&theirs, presets, &sets, options.threads)?;
    let wanted = |configuration: &&Configuration| {
        let names = &options.configurations;
        names.is_empty() || names.iter().any(|wanted| wanted == configuration.name)
    };
    for configuration in CONFIGURATIONS.iter().filter(wanted) {
        let bvh = hierarchy(&soup, &configuration.settings())?;
        for (set, peers) in sets.iter().zip(&peers).filter(|(set, _)| !set.rays.is_empty()) {
            let key = format!("{name:<8}{:<13}{:<9}", configuration.name, set.name);
            writeln!(std::io::stdout(), "{key}{}", row(&bvh, set, options.threads, peers))?;
        }
    }
    Ok(())
}

/// Millions of rays per second of each set and preset.
fn peers(
    triangles: &[obvhs::triangle::Triangle],
    presets: &[Preset],
    sets: &[RaySet],
    threads: usize,
) -> Result<Vec<Vec<f64>>> {
    let pool = ThreadPoolBuilder::new().build()?;
    let trees: Vec<_> =
        presets.iter().map(|preset| obvhs_build::measure(triangles, preset, &pool).0).collect();
    let rates = |set: &RaySet| {
        let rays = obvhs_trace::rays(set);
        trees.iter().map(|tree| obvhs_trace::single(tree, &rays, set.query, threads).0).collect()
    };
    Ok(sets.iter().map(rates).collect())
}

fn heading(presets: &[Preset]) -> String {
    let columns = ["rays", "hits", "single", "batch", "nodes", "tris", "b.nodes", "b.tris"];
    let columns: Vec<_> = columns.iter().map(|name| format!("{name:>9}")).collect();
    let ratios: Vec<_> =
        presets.iter().map(|preset| format!("{:>20}", format!("/{}", preset.name))).collect();
    format!("{:<8}{:<13}{:<9}{}{}", "scene", "config", "set", columns.concat(), ratios.concat())
}

fn row(bvh: &Bvh, set: &RaySet, threads: usize, peers: &[f64]) -> String {
    let single = trace::single(bvh, &set.rays, set.query, threads);
    let batch = trace::batches(bvh, set.batched(), set.query, threads);
    let count = set.rays.len() as f64;
    let columns = [
        single.hits as f64 / count,
        single.mega_rays(),
        batch.mega_rays(),
        single.counters.nodes as f64 / count,
        single.counters.triangles as f64 / count,
        batch.counters.nodes as f64 / count,
        batch.counters.triangles as f64 / count,
    ];
    let columns: Vec<_> = columns.iter().map(|value| format!("{value:>9.2}")).collect();
    let ratios: Vec<_> = peers.iter().map(|rate| format!("{:>20.2}", single.mega_rays() / rate)).collect();
    format!("{:>9}{}{}", set.rays.len(), columns.concat(), ratios.concat())
}
