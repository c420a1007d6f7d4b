//! Users' jobs as the program renders them: `cargo bench --bench jobs [-- JOB… --binary PATH… --rounds N -t N --memory]`.
//!
//! A job is a name of [`job::NAMES`] or a path of a scene or shot file. Without a job all named ones but `mesh-10m` are
//! measured. Without a binary it is the one that cargo built; of two, each job's ratio (the second over the first) is printed,
//! and the geometric mean of all. Binaries run in turn, and of all rounds the least time counts.
//!
//! The first table is one run each, with what it took from the machine:
//!
//! * `wall`, `CPU`: seconds of the whole process; CPU time is of all threads, user and system;
//! * `first`: seconds from the start of the process to the first finished tile;
//! * `Mrays/s`: millions of rays of all kinds per second of tracing and shading;
//! * `peak MB`: largest resident set;
//! * `faults`: page faults without disk access, in thousands.
//!
//! The second table has shares of `wall`:
//!
//! * `import`: from the start of the process to its first frame: reading, decoding, the automatic camera;
//! * `pose`, `build`: animation and triangles in world space; the hierarchy;
//! * `queries`: rays against the hierarchy; `shading`: all else of tracing;
//! * `output`: everything after: encoding and writing that no other frame's tracing hid.
//!
//! `--memory` prints bytes a triangle and a pixel instead: differences of peaks between two sizes.

mod job;
mod measure;
mod mesh;
mod report;

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use job::{Job, Workspace};
use measure::{Run, run};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Command-line options.
struct Options {
    jobs: Vec<String>,
    binaries: Vec<PathBuf>,
    rounds: usize,
    threads: usize,
    is_memory: bool,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    let workspace = Workspace::new()?;
    let mut out = std::io::stdout();
    let threads = options.threads;
    if options.is_memory {
        for binary in &options.binaries {
            let [triangle, pixel] = bytes_a_triangle_and_a_pixel(binary, &workspace, threads)?;
            let name = binary.display();
            writeln!(out, "{name}: {triangle:.0} bytes a triangle, {pixel:.0} bytes a pixel at the peak")?;
        }
        return Ok(());
    }
    let jobs = options.jobs.iter().map(|name| workspace.job(name)).collect::<Result<Vec<_>>>()?;
    let rounds = options.rounds;
    writeln!(out, "{threads} threads, the least of {rounds} rounds")?;
    let mut measured = Vec::new();
    for job in &jobs {
        let runs = least_of_rounds(job, &options)?;
        writeln!(std::io::stderr(), "{}: {:.2} s", job.name, runs[0].wall_seconds)?;
        measured.push((job.name.clone(), runs));
    }
    out.write_all(report::tables(&measured).as_bytes())?;
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut options =
        Options { jobs: Vec::new(), binaries: Vec::new(), rounds: 3, threads, is_memory: false };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--binary" => options.binaries.push(value()?.into()),
            "--rounds" => options.rounds = value()?.parse()?,
            "-t" | "--threads" => options.threads = value()?.parse()?,
            "--memory" => options.is_memory = true,
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            _ => options.jobs.push(argument),
        }
    }
    if options.rounds == 0 || options.threads == 0 || options.binaries.len() > 2 {
        return Err("--rounds and --threads are at least 1, and there are at most two binaries".into());
    }
    if options.jobs.is_empty() {
        options.jobs =
            job::NAMES.iter().filter(|name| **name != "mesh-10m").map(ToString::to_string).collect();
    }
    if options.binaries.is_empty() {
        options.binaries.push(env!("CARGO_BIN_EXE_rayframe").into());
    }
    Ok(options)
}

/// Runs a job by all binaries in turn.
fn least_of_rounds(job: &Job, options: &Options) -> Result<Vec<Run>> {
    let mut least: Vec<Option<Run>> = vec![None; options.binaries.len()];
    for _ in 0..options.rounds {
        for (binary, least) in options.binaries.iter().zip(&mut least) {
            let next = run(binary, job, options.threads)?;
            *least = Some(match least.take() {
                None => next,
                Some(least) => least.or_less(next),
            });
        }
    }
    Ok(least.into_iter().flatten().collect())
}

/// Growth of the peak from a mesh to one of four times the triangles, and from an image to one of four times the pixels.
fn bytes_a_triangle_and_a_pixel(binary: &Path, workspace: &Workspace, threads: usize) -> Result<[f64; 2]> {
    let peak = |job: &Job| Ok::<_, Box<dyn Error>>(run(binary, job, threads)?.peak_bytes);
    let mesh = |cells| workspace.mesh_job("mesh", cells, "64x36");
    let [few, many] = [[500, 250], [1000, 500]];
    let triangles = |[segments, sides]: [u32; 2]| f64::from(2 * segments * sides);
    let a_triangle = (peak(&mesh(many)?)? - peak(&mesh(few)?)?) / (triangles(many) - triangles(few));

    let image = |size| workspace.mesh_job("image", [8, 4], size);
    let pixels = f64::from(7680 * 4320 - 3840 * 2160);
    let a_pixel = (peak(&image("7680x4320")?)? - peak(&image("3840x2160")?)?) / pixels;
    Ok([a_triangle, a_pixel])
}
