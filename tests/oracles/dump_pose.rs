//! Prints the world-space corners of every triangle of a scene at given times, for comparison with other importers:
//! `cargo run --release -p oracles --bin dump_pose -- SCENE CLIP|#I|all|none TIME…`.
//!
//! It prints a line `time SECONDS TRIANGLES` for each time, then a line of nine numbers for each triangle.

use std::io::{BufWriter, Write};
use std::path::Path;

use glam::Vec3;
use rayframe::frame::Frame;
use rayframe::gltf::{self, ImportOptions};
use rayframe::scene::{ClipSelection, NameOrIndex, Selection, SelectionRequest};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene_path, clip, times @ ..] = arguments.as_slice() else {
        return Err("usage: dump_pose SCENE CLIP|#I|all|none TIME…".into());
    };
    let scene = gltf::import(Path::new(scene_path), &ImportOptions::default())?;
    let clips = match clip.as_str() {
        "all" => ClipSelection::All,
        "none" => ClipSelection::None,
        name => ClipSelection::One(match name.strip_prefix('#').and_then(|index| index.parse().ok()) {
            Some(index) => NameOrIndex::Index(index),
            None => NameOrIndex::Name(name.to_owned()),
        }),
    };
    let request = SelectionRequest { clips, ..Default::default() };
    let (selection, _) = Selection::resolve(&request, &scene)?;
    let mut output = BufWriter::new(std::io::stdout().lock());
    let mut frame = Frame::default();
    for time in times {
        frame.pose(&scene, &selection, time.parse()?);
        writeln!(output, "time {time} {}", frame.triangles.len())?;
        for triangle in &frame.triangles {
            let numbers = triangle.vertices.iter().flat_map(Vec3::to_array);
            let line: Vec<String> = numbers.map(|number| number.to_string()).collect();
            writeln!(output, "{}", line.join(" "))?;
        }
    }
    Ok(())
}
