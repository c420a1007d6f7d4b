//! Compares a render with its reference image, as a test of an asset does:
//! `cargo run --release --example compare_in_test`, or with a scene and an EXR file of it after `--`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::path::Path;

use rayframe::Renderer;
use rayframe::image::Image;
use rayframe::output::Aov;
use rayframe::regression::{Preset, compare};

/// Fails with the differences that a person would see between a render of `scene` and `reference`.
fn assert_looks_like(scene: &str, reference: &Path) -> rayframe::Result<()> {
    let reference = Image::read(reference)?;
    let window = reference.display_window;
    let renderer = Renderer::open(scene)?.size(window.width(), window.height());
    // The AOVs of the reference are compared, too.
    let rendered = renderer.aovs([Aov::ObjectId, Aov::MaterialId]).frame(0)?.image()?.rounded_to_halves();
    let comparison = compare(&rendered, &reference, &Preset::Visual.limits());
    assert!(comparison.passes(), "{scene}: {}", comparison.failures().join("; "));
    Ok(())
}

fn main() -> rayframe::Result<()> {
    let mut words = std::env::args().skip(1);
    let scene = words.next().unwrap_or_else(|| "scenes/demo/whitted_1980.gltf".to_owned());
    let reference = words.next().unwrap_or_else(|| "reference_images/demo/whitted_1980.0000.exr".to_owned());
    assert_looks_like(&scene, Path::new(&reference))?;
    println!("{scene} looks like {reference}");
    Ok(())
}
