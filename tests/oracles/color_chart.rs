//! Renders a chart of 24 known colours with the default settings, lit by the default studio or the given environment, and prints
//! how far each is from its base colour: `cargo run --release -p oracles --bin color_chart [ENV [CHART.png]]`.

#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::path::PathBuf;

use make_scenes::color_chart::{SIZE, color_chart, mean_delta_e, measure};
use rayframe::Renderer;
use rayframe::image_file::decode_png;

/// Columns and rows of pixels of a patch.
const PATCH: u32 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let scene = folder.path().join("chart.gltf");
    std::fs::write(&scene, color_chart())?;
    let environment = std::env::args().nth(1).unwrap_or_else(|| "studio".to_owned());
    let png = std::env::args_os().nth(2).map_or(folder.path().join("chart.png"), PathBuf::from);
    let renderer = Renderer::open(&scene)?.size(SIZE.0 * PATCH, SIZE.1 * PATCH).set("env", &environment)?;
    renderer.frame(0)?.write_png(&png)?;
    let image = decode_png(&png, &std::fs::read(&png)?)?;
    let patches = measure(image.size.0, &image.pixels);
    println!("{:<12} {:>11}  {:>11}  ΔE2000", "patch", "base", "shown");
    for patch in &patches {
        let [base, shown] =
            [patch.base.map(f64::from), patch.shown].map(|[r, g, b]| format!("{r:.0} {g:.0} {b:.0}"));
        println!("{:<12} {base:>11}  {shown:>11}  {:6.2}", patch.name, patch.delta_e);
    }
    println!("{:<12} {:>11}  {:>11}  {:6.2}", "mean", "", "", mean_delta_e(&patches));
    Ok(())
}
