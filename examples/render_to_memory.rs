//! Renders one frame to memory, prints its mean radiance and writes a PNG file where one is named:
//! `cargo run --release --example render_to_memory -- robot.glb robot.png`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use rayframe::Renderer;
use rayframe::scene::BuiltInLight;
use rayframe::settings::EnvironmentSource;

fn main() -> rayframe::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "scenes/demo/whitted_1980.gltf".to_owned());
    let light = EnvironmentSource::BuiltIn(BuiltInLight::Studio);
    let frame = Renderer::open(&path)?.size(320, 180).environment(light).frame(0)?;
    let count = frame.pixels().len() as f32;
    let sum = frame.pixels().iter().fold([0.0; 3], |sum, [r, g, b, _]| [sum[0] + r, sum[1] + g, sum[2] + b]);
    println!("{path}: mean radiance {:?}", sum.map(|channel| channel / count));
    std::env::args().nth(2).map_or(Ok(()), |png| frame.write_png(png))
}
