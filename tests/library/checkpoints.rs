//! Checkpoints of frames whose pixels show more mesh instances than the estimate of memory expects.

use std::path::Path;

use glam::{Mat4, Vec3};
use rayframe::cancel::CancelFlag;
use rayframe::output::{Aov, AovSet};
use rayframe::render::Integrator;
use rayframe::scene::{Environment, Projection, SelectedCamera};
use rayframe::sequence::{Plan, SequenceEvent, SequenceJob, Summary, estimated_bytes, run};

use crate::stage::{Stage, rectangle, sequence_job, unlit};

/// Rectangles along each side of an image of 8x8 pixels.
const RECTANGLES: u16 = 40;

/// A job with Cryptomattes and a checkpoint, whose pixels show 25 instances and more each.
fn crowded_job(folder: &Path) -> SequenceJob {
    let mut stage = Stage::new();
    let at = |index: u16| (f32::from(index) + 0.5) / f32::from(RECTANGLES) * 2.0 - 1.0;
    for (x, y) in (0..RECTANGLES).flat_map(|y| (0..RECTANGLES).map(move |x| (x, y))) {
        let center = Vec3::new(at(x), at(y), 0.0);
        stage.add(rectangle(center, Vec3::X * 0.02, Vec3::Y * 0.02), unlit(Vec3::ONE));
    }
    let world_from_camera = Mat4::from_translation(Vec3::Z * 4.0);
    let projection =
        Projection::Perspective { fov_y_radians: 0.49, aspect_ratio: None, z_near: 0.0, z_far: None };
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (8, 8), &folder.join("a.exr"));
    job.environment = Environment::Constant(Vec3::splat(0.5));
    job.render.integrator = Integrator::Path;
    job.render.samples = 256;
    job.exr.aovs = AovSet::new(&[Aov::Beauty, Aov::CryptoObject]);
    job.render.aovs = job.exr.aov_flags();
    job.checkpoint = true;
    job
}

/// Renders under a limit, and is cancelled after `share` of the samples.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(job: &mut SequenceJob, max_memory_bytes: u64, share: f32) -> Summary {
    job.max_memory_bytes = max_memory_bytes;
    let plan = Plan::new(job).unwrap();
    plan.prepare().unwrap();
    let cancel = CancelFlag::new();
    run(job, &plan, &cancel, &|event| match event {
        SequenceEvent::FrameProgress(_, progress) if progress.share > share => cancel.raise(),
        _ => {}
    })
}

/// Asserts that a run under the least limit of the estimate ends with 77 and `words`.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn assert_refused(job: &mut SequenceJob, words: [&str; 2]) {
    let least = u64::try_from(estimated_bytes(job)).unwrap();
    let error = render(job, least, 1.0).outcome().unwrap_err();
    let said = error.to_string();
    assert_eq!(error.exit_code(), 77, "{said}");
    assert!(said.contains("a.exr.checkpoint: ") && said.contains("more than the limit of "), "{said}");
    assert!(words.into_iter().all(|words| said.contains(words)), "{said}");
}

#[test]
fn passes_that_need_more_than_the_limit_are_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = crowded_job(folder.path());
    let checkpoint = folder.path().join("a.exr.checkpoint");
    assert!(render(&mut job, 1 << 30, 0.6).is_interrupted);
    let kept = std::fs::read(&checkpoint).unwrap();

    assert_refused(&mut job, ["continuing this frame needs about ", "remove it to begin anew"]);
    assert!(std::fs::read(&checkpoint).unwrap() == kept);
    assert!(!folder.path().join("a.exr").exists());

    let written = render(&mut job, 1 << 30, 1.0).written;
    assert!(written.len() == 1 && !checkpoint.exists());
    let fresh = tempfile::tempdir().unwrap();
    let mut whole = crowded_job(fresh.path());
    assert_eq!(render(&mut whole, 1 << 30, 1.0).written[0].sha256, written[0].sha256);
}

#[test]
fn passes_before_the_limit_stay_for_a_run_with_a_higher_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = crowded_job(folder.path());
    assert_refused(&mut job, ["keeping the passes of this frame needs about ", "; raise "]);
    assert!(folder.path().join("a.exr.checkpoint").is_file());
    assert_eq!(render(&mut job, 1 << 30, 1.0).written.len(), 1);
    assert!(!folder.path().join("a.exr.checkpoint").exists());
}
