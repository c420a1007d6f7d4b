//! The papers' tables: `cargo bench --bench papers [-- SCENE… --size N --factors A,B,C --threads N --no-overlap --output FOLDER]`.
//!
//! Compares the systems of Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies" (2007), and those of the survey of
//! parallel construction (Lemmon 2016), on any scene. A SCENE is `scan`, `mirror-hall`, `mirror-hall-fine`, `plant`, a `.tri` file with a
//! `.cam` file beside it, or a glTF file; all generated scenes by default. One camera ray goes through each of `--size` squared pixels (1000),
//! and from its hit a shadow ray and a mirror ray. Rays are traced one by one on one thread; hierarchies are built by `--threads` (1).
//!
//! Every system must give the hits of the product, to the last bit; otherwise the run fails. The columns:
//!
//! * `R`: references a triangle;
//! * `T_build`: milliseconds of building, splitting included;
//! * `N_node`, `N_triangle`, `T_ray`: nodes visited and triangles tested by a camera ray, and its microseconds;
//! * `S`, `S_lbvh`: speed-up of camera rays over the unsplit SAH BVH and the unsplit LBVH;
//! * `frame`: microseconds a ray, over camera, shadow and mirror rays;
//! * `SAH`, `EPO`, `depth`, `nodes`, `B/tri`: cost, end-point overlap, levels, nodes, and bytes a triangle.
//!
//! "early 16" splits boxes above 16 times the area of the scene's box over the number of triangles. `*` marks the product's own choice. Rows of
//! the product count wide nodes, which test eight boxes. With `--output`, the tables are written as CSV, JSON and Markdown, too.

mod clip;
mod hierarchy;
mod kd_tree;
mod late_split;
mod lbvh;
mod measure;
mod overlap;
mod rays;
mod references;
mod sah_bvh;
mod scenes;
mod systems;
mod table;

use std::io::Write as _;
use std::path::PathBuf;

use scenes::TestScene;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Command-line options.
#[derive(Debug)]
pub(crate) struct Options {
    scenes: Vec<String>,
    size: u32,
    /// SA_max of early splits, as multiples of the scene's area over its triangles.
    factors: Vec<f64>,
    threads: usize,
    has_overlap: bool,
    output: Option<PathBuf>,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let (mut out, mut progress) = (std::io::stdout(), std::io::stderr());
    let mut tables = Vec::new();
    for name in &options.scenes {
        let scene = TestScene::open(name)?;
        let mut on_row = |row: &measure::Row| {
            let _ = writeln!(progress, "{name}: {} {:.2} us a ray", row.system, row.primary.microseconds);
        };
        let table = measure::measure(&scene, &options, &pool, &mut on_row)?;
        writeln!(out, "{}", table::text(&table))?;
        tables.push(table);
    }
    if let Some(folder) = &options.output {
        std::fs::create_dir_all(folder)?;
        let markdown: Vec<_> = tables.iter().map(table::markdown).collect();
        std::fs::write(folder.join("papers.csv"), table::csv(&tables))?;
        std::fs::write(folder.join("papers.json"), serde_json::to_string_pretty(&tables)? + "\n")?;
        std::fs::write(folder.join("papers.md"), markdown.join("\n"))?;
    }
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let mut options = Options {
        scenes: Vec::new(),
        size: 1000,
        factors: vec![64.0, 16.0, 4.0],
        threads: 1,
        has_overlap: true,
        output: None,
    };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--size" => options.size = value()?.parse()?,
            "--threads" => options.threads = value()?.parse()?,
            "--factors" => {
                options.factors =
                    value()?.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?;
            }
            "--no-overlap" => options.has_overlap = false,
            "--output" => options.output = Some(value()?.into()),
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            scene => options.scenes.push(scene.to_owned()),
        }
    }
    if options.size == 0 || options.factors.is_empty() {
        return Err("--size and --factors need at least one".into());
    }
    if options.scenes.is_empty() {
        options.scenes = scenes::GENERATED.map(str::to_owned).to_vec();
    }
    Ok(options)
}
