//! Rayframe and obvhs on the scenes and rays of other tracers' measurements, with the same clocks:
//! `cargo bench -p peers --bench tracers -- WORKDIR --csv FILE [--lib rayframe|obvhs] [--config NAME] [--threads N] [SCENE…]`.
//!
//! WORKDIR holds `scenes/` and `rays/` (see `folder`). Rows `lib,scene,config,threads,metric,value` are appended to FILE, or
//! printed. Reading and conversion are not measured. The metrics:
//!
//! * `build_ms`: wall-clock time of the first build, with a new builder;
//! * `rebuild_ms`: the best of six rebuilds, with the builder and the memory of the last hierarchy reused;
//! * `references`, `bytes_per_triangle`: per triangle; `sah`, `depth`: of the binary tree;
//! * `mrays:SET:single`: millions of rays per second, one query per ray. Threads pull chunks of 8192 rays; the time is their
//!   processor time, summed over threads, over their number; the best of three passes, or one that takes over half a second;
//! * `mrays:SET:packet`: the same by batch queries of 256 consecutive rays. Batches of `shadow` start at the light, as in the
//!   renderer (see `ray_set`); `mrays:shadow:packet_surface` are batches of the rays as they are in the file;
//! * `hits:SET`: number of rays with a hit;
//! * `nodes:SET:…`, `triangles:SET:…`: wide nodes visited and triangles tested, per ray;
//! * `frame_ms:single`, `frame_ms:packet`: `rebuild_ms` and the times of primary, shadow and reflect;
//! * `trace_ms:render`, `trace_ms:rays`, `trace_ms:ratio`: see `product`; for `auto` only.
//!
//! obvhs's rows have lib `obvhs`, or `obvhs-native` where the benchmark is compiled for the machine it runs on.
//!
//! `--check [--sample N]` measures nothing. It compares answers (see `check`), and any difference is an error.

mod check;
mod folder;
mod options;
mod ours;
mod product;
mod table;
mod theirs;

use std::error::Error;
use std::io::Write as _;

use folder::Subject;
use options::Options;
use peers::configuration::CONFIGURATIONS;
use peers::obvhs_preset;
use table::Table;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let options = Options::parse(std::env::args().skip(1))?;
    if options.check { check_all(&options) } else { measure_all(&options) }
}

fn check_all(options: &Options) -> Result<()> {
    let mut differing = 0;
    for name in &options.scenes {
        let subject = Subject::read(&options.folder, name)?;
        differing += check::differences(&subject, options.sample, &mut std::io::stdout())?;
    }
    if differing == 0 { Ok(()) } else { Err(format!("{differing} answers differ").into()) }
}

fn measure_all(options: &Options) -> Result<()> {
    let mut table = Table::append_to(options.csv.as_deref())?;
    for name in &options.scenes {
        let subject = Subject::read(&options.folder, name)?;
        for &threads in &options.threads {
            measure_scene(&subject, threads, options, &mut table)?;
        }
    }
    Ok(())
}

/// Measures all selected configurations and prints a line for each on standard error.
fn measure_scene(subject: &Subject, threads: usize, options: &Options, table: &mut Table) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let announce = |library, name: &str| {
        writeln!(std::io::stderr(), "{} {threads} threads {library} {name}", subject.name)
    };
    for configuration in CONFIGURATIONS.iter().filter(|configuration| options.wants(configuration.name)) {
        if options.wants_library("rayframe") {
            announce("rayframe", configuration.name)?;
            ours::measure(subject, configuration, &pool, table)?;
        }
    }
    for preset in &obvhs_preset::presets(|name| options.wants(name)) {
        if options.wants_library("obvhs") {
            announce(obvhs_preset::LIBRARY, &preset.name)?;
            theirs::measure(subject, preset, &pool, table)?;
        }
    }
    Ok(())
}
