//! The papers' tables and plots: `cargo bench --bench papers -- --help` lists the options.
//!
//! Compares the systems of Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies" (2007), and those of the survey of
//! parallel construction (Lemmon 2016), on any scene. One camera ray goes through each pixel, and from its hit a shadow ray and a mirror ray.
//! Rays are traced one by one on one thread.
//!
//! Every system must give the hits of the product, to the last bit; otherwise the run fails. The columns of tables and sweeps:
//!
//! * `R`: references a triangle;
//! * `T_build`: milliseconds of building, splitting included;
//! * `N_node`, `N_triangle`, `T_ray`: nodes visited and triangles tested by a camera ray, and its microseconds;
//! * `S`, `S_lbvh`: speed-up of camera rays over the unsplit SAH BVH and the unsplit LBVH;
//! * `frame`: microseconds a ray, over camera, shadow and mirror rays;
//! * `SAH`, `EPO`, `depth`, `nodes`, `B/tri`: cost, end-point overlap, levels, nodes, and bytes a triangle.
//!
//! "early 16" splits boxes above 16 times the area of the scene's box over the number of triangles. `*` marks the product's own choice. Rows of
//! the product count wide nodes, which test eight boxes.

mod clip;
mod gain;
mod hierarchy;
mod kd_tree;
mod late_split;
mod lbvh;
mod measure;
mod options;
mod overlap;
mod plot;
mod rays;
mod references;
mod sah_bvh;
mod scenes;
mod systems;
mod table;
mod throughput;

use std::io::Write as _;

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use measure::SceneTable;
use options::{HELP, Options, Report};
use scenes::TestScene;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let mut out = std::io::stdout();
    let Some(options) = Options::parse(std::env::args().skip(1))? else {
        return Ok(out.write_all(HELP.as_bytes())?);
    };
    if options.report == Report::Throughput {
        let points = throughput::measure(options.threads, options.repeats, &mut progress)?;
        let text = throughput::markdown(&points);
        writeln!(out, "{text}")?;
        save(&options, &points, &text, &throughput::csv(&points))?;
        return plotted(&options, |file| plot::throughput(file, &points));
    }
    let tables = tables(&options)?;
    if options.report == Report::Gain {
        let gains = gain::gains(&tables);
        let text = gain::markdown(&gains);
        writeln!(out, "{text}")?;
        save(&options, &gains, &text, &gain::csv(&gains))?;
        return plotted(&options, |file| plot::gain(file, &gains));
    }
    let markdown: Vec<_> = tables.iter().map(table::markdown).collect();
    save(&options, &tables, &markdown.join("\n"), &table::csv(&tables))?;
    if options.report == Report::Sweep {
        return plotted(&options, |file| plot::sweep(file, &tables));
    }
    Ok(())
}

/// Measures all scenes; prints the table of each but for gains.
fn tables(options: &Options) -> Result<Vec<SceneTable>> {
    let pool: ThreadPool = ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let mut tables = Vec::new();
    for name in &options.scenes {
        let mut scene = TestScene::open(name)?;
        scene.leave_out_large(options.largest)?;
        let mut on_row = |row: &measure::Row| {
            progress(&format!("{name}: {} {:.2} us a ray", row.system, row.primary.microseconds));
        };
        let table = measure::measure(&scene, options, &pool, &mut on_row)?;
        if options.report != Report::Gain {
            writeln!(std::io::stdout(), "{}", table::text(&table))?;
        }
        tables.push(table);
    }
    Ok(tables)
}

/// Prints a line of progress. A closed stderr is no reason to stop.
fn progress(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Writes results as CSV, JSON and Markdown.
fn save(options: &Options, results: &impl Serialize, markdown: &str, csv: &str) -> Result<()> {
    let Some(folder) = &options.output else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let file = |extension: &str| folder.join(options.report.name()).with_extension(extension);
    std::fs::write(file("csv"), csv)?;
    std::fs::write(file("json"), serde_json::to_string_pretty(results)? + "\n")?;
    Ok(std::fs::write(file("md"), markdown)?)
}

/// Writes a plot.
fn plotted(options: &Options, plot: impl Fn(&std::path::Path) -> Result<()>) -> Result<()> {
    let Some(folder) = &options.output else { return Ok(()) };
    plot(&folder.join(options.report.name()).with_extension("svg"))
}
