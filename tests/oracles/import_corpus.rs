//! Imports every glTF file below the folders named on the command line. Prints a line for each file: time, exit code,
//! warnings, and the error message or a summary of the scene. Tests the importer on collections of real and malformed files.

#![expect(clippy::print_stdout, reason = "an example that prints a table")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayframe::gltf::{ImportOptions, import};
use rayframe::scene::Scene;

fn main() {
    let mut files = Vec::new();
    for argument in std::env::args_os().skip(1) {
        collect(Path::new(&argument), &mut files);
    }
    files.sort();
    for file in files {
        let start = Instant::now();
        let result = import(&file, &ImportOptions::default());
        let milliseconds = start.elapsed().as_millis();
        match result {
            Ok(scene) => {
                println!("ok   {milliseconds:>5} ms  {}  {}", file.display(), summary(&scene));
                for warning in &scene.warnings {
                    println!("       warning: {warning}");
                }
            }
            Err(error) => println!("{:<4} {milliseconds:>5} ms  {error}", error.exit_code()),
        }
    }
}

/// Adds `path` if it is a glTF file, or all glTF files below it if it is a folder.
fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if let Ok(folder) = std::fs::read_dir(path) {
        for entry in folder.flatten() {
            collect(&entry.path(), files);
        }
    } else if path.extension().is_some_and(|kind| kind == "gltf" || kind == "glb") {
        files.push(path.to_owned());
    }
}

fn summary(scene: &Scene) -> String {
    let primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let triangles: usize = primitives.map(|primitive| primitive.triangles.len()).sum();
    format!(
        "{} nodes, {} meshes, {triangles} triangles, {} images, {} skins, {} clips",
        scene.nodes.len(),
        scene.meshes.len(),
        scene.images.len(),
        scene.skins.len(),
        scene.animations.len()
    )
}
