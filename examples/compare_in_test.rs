//! Compares a render with a reference image, as a test of an asset does: `cargo run --release --example compare_in_test`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::path::Path;

use rayframe::Renderer;
use rayframe::image::Image;
use rayframe::regression::{Preset, compare};

/// Fails with the differences that a person would see between a render of `scene` and `reference`.
fn assert_looks_like(scene: &str, reference: &Path) -> rayframe::Result<()> {
    let rendered = Renderer::open(scene)?.size(160, 90).frame(0)?.image()?.rounded_to_halves();
    let comparison = compare(&rendered, &Image::read(reference)?, &Preset::Visual.limits());
    assert!(comparison.passes(), "{scene}: {}", comparison.failures().join("; "));
    Ok(())
}

fn main() -> rayframe::Result<()> {
    let scene = "scenes/demo/whitted_1980.gltf";
    let reference = std::env::temp_dir().join("rayframe_reference.exr");
    Renderer::open(scene)?.size(160, 90).frame(0)?.write_exr(&reference)?;
    assert_looks_like(scene, &reference)?;
    println!("{scene} looks like {}", reference.display());
    Ok(())
}
