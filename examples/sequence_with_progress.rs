//! Renders a sequence and prints its progress:
//! `cargo run --release --example sequence_with_progress -- robot.glb out/robot.####.exr`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use rayframe::Renderer;
use rayframe::sequence::SequenceEvent;

fn main() -> rayframe::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().unwrap_or_else(|| "scenes/demo/whitted_1980.gltf".to_owned());
    let output = arguments.next().unwrap_or_else(|| "out/example.####.exr".to_owned());
    let sequence = Renderer::open(&scene)?.size(320, 180).set("frames", "0-3")?.sequence(&output)?;
    let summary = sequence.run(|event| match event {
        SequenceEvent::FrameWritten(report) => println!("frame {} {}", report.frame, report.path.display()),
        SequenceEvent::FrameFailed(planned, error) => println!("frame {} failed: {error}", planned.frame),
        _ => {}
    })?;
    println!("{} frames in {:.1} s", summary.written.len(), summary.seconds);
    Ok(())
}
