//! Sequences through the library: the files that are written and kept, failures, cancellation, and the render hash.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Mutex;

use crate::stage::sequence_job;
use glam::Vec3;
use rayframe::bvh::{BuilderKind, Split};
use rayframe::cancel::CancelFlag;
use rayframe::film::PixelWindow;
use rayframe::render::{Adaptive, Aperture, Focus, GlassShadows, Lens, PixelFilter};
use rayframe::scene::{Environment, NodeIndex, Scene, SceneMemory, SelectedCamera, Selection};
use rayframe::sequence::{
    ExistingFiles, Exposure, FrameRate, OutputPattern, Plan, SequenceEvent, SequenceJob, Shutter, Summary,
    check_framing_memory, render_hash, run,
};

/// A job that renders an empty scene in a constant environment to `folder/name`.
pub(crate) fn job(folder: &Path, name: &str, frames: &[i64]) -> SequenceJob {
    let scene = Scene { path: PathBuf::from("empty.gltf"), ..Scene::default() };
    let mut job = sequence_job(scene, SelectedCamera::Auto, (40, 30), &folder.join(name));
    job.environment = Environment::Constant(Vec3::splat(0.5));
    job.frames = frames.to_vec();
    job.render.max_depth = 1;
    job
}

pub(crate) fn render(job: &SequenceJob) -> Result<Summary, rayframe::error::Error> {
    let plan = Plan::new(job)?;
    plan.prepare()?;
    Ok(run(job, &plan, &CancelFlag::new(), &|_| ()))
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn every_frame_has_its_file_and_no_temporary_file_remains() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "new/{frame}/a.####.exr", &[-1, 0, 2]);
    job.preview = true;
    let summary = render(&job).unwrap();
    assert_eq!(summary.written.iter().map(|report| report.frame).collect::<Vec<_>>(), [-1, 0, 2]);
    assert_eq!(names(&folder.path().join("new/2")), ["a.0002.exr", "a.0002.png"]);
    assert_eq!(names(&folder.path().join("new/-1")), ["a.-001.exr", "a.-001.png"]);
    assert!(summary.outcome().is_ok());
}

#[test]
fn finished_frames_of_the_same_job_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.####.exr", &[1, 2, 3]);
    render(&job).unwrap();
    let first = std::fs::read(job.output.path(1)).unwrap();

    // One frame is missing and one is truncated; the third is intact.
    std::fs::remove_file(job.output.path(1)).unwrap();
    std::fs::write(job.output.path(2), &first[..first.len() / 2]).unwrap();
    let error = Plan::new(&job).unwrap_err();
    assert_eq!(error.exit_code(), 73);
    let message = error.to_string();
    assert!(
        message.contains("`resume`") && message.contains("`overwrite`") && message.contains("a.0002.exr"),
        "{message}"
    );

    // Resuming lists the truncated frame as replaced, but not the missing one.
    job.existing = ExistingFiles::Resume;
    let replaced = Plan::new(&job).unwrap().replaced;
    assert_eq!(replaced.iter().map(|file| &file.path).collect::<Vec<_>>(), [&job.output.path(2)]);
    let summary = render(&job).unwrap();
    assert_eq!(summary.kept, [3]);
    assert!(std::fs::read(job.output.path(1)).unwrap() == first);

    // All frames are finished: nothing remains, unless existing files are overwritten.
    job.existing = ExistingFiles::Protect;
    assert_eq!(Plan::new(&job).unwrap().remaining(), 0);
    job.existing = ExistingFiles::Overwrite;
    assert_eq!(Plan::new(&job).unwrap().remaining(), 3);
}

#[test]
fn frames_of_other_settings_or_another_crop_are_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.####.exr", &[1]);
    render(&job).unwrap();
    job.render.window = PixelWindow { x0: 1, y0: 2, x1: 10, y1: 9 };
    assert_eq!(Plan::new(&job).unwrap_err().exit_code(), 73);
    job.existing = ExistingFiles::Resume;
    assert_eq!(render(&job).unwrap().written.len(), 1);
    assert_eq!(Plan::new(&job).unwrap().remaining(), 0);
    job.render.samples = 2;
    assert_eq!(Plan::new(&job).unwrap().remaining(), 1);
}

#[test]
fn previews_of_kept_frames_are_the_same_as_those_made_while_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.exr", &[0]);
    job.preview = true;
    render(&job).unwrap();
    let preview = folder.path().join("a.png");
    let made_while_rendering = std::fs::read(&preview).unwrap();
    std::fs::remove_file(&preview).unwrap();
    let summary = render(&job).unwrap();
    assert_eq!((summary.written.len(), summary.kept.as_slice()), (0, &[0][..]));
    assert!(std::fs::read(&preview).unwrap() == made_while_rendering);
}

#[test]
fn a_preview_does_not_replace_an_image_of_another_program() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.exr", &[0]);
    job.preview = true;
    let preview = folder.path().join("a.png");
    std::fs::write(&preview, "a painting").unwrap();
    let error = Plan::new(&job).unwrap_err();
    assert_eq!(error.exit_code(), 73);
    assert!(error.to_string().contains("a.png"), "{error}");
    assert_eq!(std::fs::read(&preview).unwrap(), b"a painting");

    // A preview that rayframe wrote is replaced if exposure or tone differ, but not if the render differs.
    job.existing = ExistingFiles::Overwrite;
    render(&job).unwrap();
    job.existing = ExistingFiles::Protect;
    job.exposure = Exposure::Ev(2.0);
    assert_eq!(Plan::new(&job).unwrap().remaining(), 0);
    std::fs::remove_file(folder.path().join("a.exr")).unwrap();
    job.render.samples += 1;
    assert_eq!(Plan::new(&job).unwrap_err().exit_code(), 73);
}

#[test]
fn png_output_resumes_and_depends_on_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.##.png", &[0, 1]);
    render(&job).unwrap();
    assert_eq!(Plan::new(&job).unwrap().remaining(), 0);
    job.exposure = Exposure::Ev(1.0);
    job.existing = ExistingFiles::Resume;
    assert_eq!(Plan::new(&job).unwrap().remaining(), 2);
    job.preview = true;
    assert_eq!(Plan::new(&job).unwrap_err().exit_code(), 2);
}

#[test]
fn invalid_jobs_fail_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(Plan::new(&job(folder.path(), "a.exr", &[1, 2])).unwrap_err().exit_code(), 2);
    let mut too_large = job(folder.path(), "a.exr", &[1]);
    // Checkpoints hold whole frames, so that bands of rows are ruled out.
    too_large.checkpoint = true;
    too_large.render.resolution = (65536, 65536);
    too_large.render.window = PixelWindow::full(65536, 65536);
    let error = Plan::new(&too_large).unwrap_err();
    assert_eq!(error.exit_code(), 77);
    // 2³² pixels of 32 bytes against 2³⁰ bytes.
    assert!(error.to_string().contains("137.5 GB, more than the limit of 1.1 GB"), "{error}");
    assert!(error.to_string().contains("without `checkpoint` it is rendered in bands of rows"), "{error}");
    // Amounts below a gigabyte are printed in megabytes.
    too_large.render.resolution = (1000, 1000);
    too_large.render.window = PixelWindow::full(1000, 1000);
    too_large.max_memory_bytes = 20_000_000;
    let error = Plan::new(&too_large).unwrap_err();
    assert!(error.to_string().contains(" MB, more than the limit of 20.0 MB"), "{error}");
    std::fs::write(folder.path().join("file"), "").unwrap();
    assert_eq!(render(&job(folder.path(), "file/a.exr", &[1])).unwrap_err().exit_code(), 73);
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn estimates_count_the_scene_and_the_looks_of_an_automatic_camera() {
    let folder = tempfile::tempdir().unwrap();
    let with = |memory: SceneMemory| {
        let scene = Scene { path: PathBuf::from("empty.gltf"), memory, ..Scene::default() };
        let mut job = sequence_job(scene, SelectedCamera::Auto, (40, 30), &folder.path().join("a.exr"));
        job.max_memory_bytes = 1 << 30;
        job
    };
    let fits = |memory| Plan::new(&with(memory)).is_ok();
    let gigabyte = 1 << 30;
    assert!(fits(SceneMemory { kept_bytes: gigabyte / 2, import_bytes: gigabyte / 2 }));
    // Neither the import nor what it leaves may exceed the limit.
    assert!(!fits(SceneMemory { kept_bytes: 0, import_bytes: gigabyte }));
    assert!(!fits(SceneMemory { kept_bytes: gigabyte, import_bytes: 0 }));

    let job = with(SceneMemory { kept_bytes: gigabyte, import_bytes: 0 });
    let error = check_framing_memory(&job.scene, &job.selection, 0, gigabyte).unwrap_err();
    assert_eq!(error.exit_code(), 77);
    assert!(error.to_string().contains("choose a camera"), "{error}");
    let named = Selection { camera: SelectedCamera::Node(NodeIndex(0)), ..job.selection.clone() };
    assert!(check_framing_memory(&job.scene, &named, 0, gigabyte).is_ok());
}

#[test]
fn a_failed_frame_stops_the_run_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.##.exr", &[1, 2, 3]);
    let run_with_an_obstacle = |job: &SequenceJob| {
        let plan = Plan::new(job).unwrap();
        // A folder with the name of frame 2, created during the run, makes its rename fail.
        std::fs::create_dir_all(job.output.path(2).join("x")).unwrap();
        run(job, &plan, &CancelFlag::new(), &|_| ())
    };
    let summary = run_with_an_obstacle(&job);
    assert_eq!((summary.written.len(), summary.failed.len()), (1, 1));
    std::fs::remove_dir_all(job.output.path(2)).unwrap();
    job.keep_going = true;
    let summary = run_with_an_obstacle(&job);
    assert_eq!((summary.written.len(), summary.kept.len(), summary.failed.len()), (1, 1, 1));
    assert_eq!(names(folder.path()), ["a.01.exr", "a.02.exr", "a.03.exr"]);
    assert_eq!(summary.outcome().unwrap_err().exit_code(), 74);
}

#[test]
fn the_loop_is_one_frame_ahead_of_the_disk_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "a.##.exr", &[0, 1, 2, 3, 4, 5, 6, 7]);
    let too_early = Mutex::new(Vec::new());
    let summary = run(&job, &Plan::new(&job).unwrap(), &CancelFlag::new(), &|event| {
        if let SequenceEvent::FrameProgress(planned, _) = event
            && planned.frame >= 2
            && !job.output.path(planned.frame - 2).is_file()
        {
            too_early.lock().unwrap().push(planned.frame);
        }
    });
    assert_eq!(too_early.into_inner().unwrap(), [0_i64; 0]);
    assert_eq!(names(folder.path()).len(), 8);
    // The periods of the frames sum to at most the time of the run.
    let periods: f64 = summary.written.iter().map(|report| report.seconds.period).sum();
    assert!(periods > 0.0 && periods <= summary.seconds);
    assert!(summary.written.iter().all(|report| report.seconds.period <= report.seconds.total));
}

#[test]
fn frames_end_in_order_whether_written_kept_or_failed() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.##.exr", &[1]);
    render(&job).unwrap();
    job.frames = vec![4, 1, 2, 3, 5];
    job.keep_going = true;
    let plan = Plan::new(&job).unwrap();
    std::fs::create_dir_all(job.output.path(2).join("x")).unwrap();
    for threads in [1, 2, 4] {
        for frame in [4, 5] {
            let _ = std::fs::remove_file(job.output.path(frame));
        }
        let ends = Mutex::new(Vec::new());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let summary = pool.install(|| {
            run(&job, &plan, &CancelFlag::new(), &|event| {
                let end = match event {
                    SequenceEvent::FrameStarted(frame) if frame.frame == 3 => panic!("a bug in frame three"),
                    SequenceEvent::FrameWritten(report) => (report.frame, "written"),
                    SequenceEvent::FrameKept(frame) => (frame.frame, "kept"),
                    SequenceEvent::FrameFailed(frame, _) => (frame.frame, "failed"),
                    _ => return,
                };
                ends.lock().unwrap().push(end);
            })
        });
        let expected = [(4, "written"), (1, "kept"), (2, "failed"), (3, "failed"), (5, "written")];
        assert_eq!(ends.into_inner().unwrap(), expected, "{threads} threads");
        assert_eq!(summary.failed.iter().map(|failed| failed.frame).collect::<Vec<_>>(), [2, 3]);
    }
}

#[test]
fn a_frame_that_cannot_be_written_stops_the_one_after_it() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "a.##.exr", &[1, 2, 3, 4, 5, 6]);
    let plan = Plan::new(&job).unwrap();
    std::fs::create_dir_all(job.output.path(1).join("x")).unwrap();
    let cancel = CancelFlag::new();
    let summary = run(&job, &plan, &cancel, &|event| {
        // The panic of the next frame is not the reported failure.
        if let SequenceEvent::FrameStarted(frame) = event {
            assert!(frame.frame != 2, "a bug in frame two");
        }
    });
    assert_eq!(summary.failed.iter().map(|failed| failed.frame).collect::<Vec<_>>(), [1]);
    assert!(!summary.is_interrupted && !cancel.is_raised());
    assert_eq!(names(folder.path()), ["a.01.exr"]);
    assert_eq!(summary.outcome().unwrap_err().exit_code(), 74);
}

#[test]
fn cancellation_keeps_finished_frames() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "a.##.exr", &[1, 2, 3]);
    let plan = Plan::new(&job).unwrap();
    let cancel = CancelFlag::new();
    let summary = run(&job, &plan, &cancel, &|event| {
        if let SequenceEvent::FrameWritten(_) = event {
            cancel.raise();
        }
    });
    assert!(summary.is_interrupted);
    assert_eq!(names(folder.path()), ["a.01.exr"]);
    assert_eq!(summary.outcome().unwrap_err().exit_code(), 75);
}

#[test]
fn a_panic_fails_its_frame_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.##.exr", &[1, 2, 3]);
    job.keep_going = true;
    let plan = Plan::new(&job).unwrap();
    let messages = Mutex::new(Vec::new());
    let summary = run(&job, &plan, &CancelFlag::new(), &|event| match event {
        SequenceEvent::FrameStarted(frame) if frame.frame == 2 => panic!("a bug in frame two"),
        SequenceEvent::FrameFailed(_, error) => messages.lock().unwrap().push(error.to_string()),
        _ => {}
    });
    assert_eq!(names(folder.path()), ["a.01.exr", "a.03.exr"]);
    assert!(messages.lock().unwrap()[0].contains("a bug in frame two"));
    assert_eq!(summary.outcome().unwrap_err().exit_code(), 70);
}

#[test]
fn the_render_hash_changes_with_the_image_and_with_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let base = || job(folder.path(), "a.####.exr", &[1]);
    let expected = render_hash(&base(), 1);
    let with = |change: &dyn Fn(&mut SequenceJob)| {
        let mut job = base();
        change(&mut job);
        render_hash(&job, 1)
    };
    let same: [&dyn Fn(&mut SequenceJob); 7] = [
        &|job| job.write_behind = false,
        &|job| job.build.builder = BuilderKind::BruteForce,
        &|job| job.build.split = Split::Off,
        &|job| job.frames = vec![1, 2, 3],
        &|job| job.render.window.x1 = 7,
        &|job| job.output = OutputPattern::parse("b.exr".as_ref()).unwrap(),
        &|job| job.exposure = Exposure::Ev(3.0),
    ];
    for change in same {
        assert_eq!(with(change), expected);
    }
    let lens = |aperture, focus| Some(Lens { aperture, focus });
    let other: [&dyn Fn(&mut SequenceJob); 21] = [
        &|job| Arc::make_mut(&mut job.scene).content_hash[31] = 1,
        &|job| job.selection.roots.push(rayframe::scene::NodeIndex(0)),
        &|job| job.selection.camera = SelectedCamera::Node(rayframe::scene::NodeIndex(0)),
        &|job| job.environment = Environment::Constant(Vec3::splat(0.25)),
        &|job| job.render.resolution.0 += 1,
        &|job| job.render.samples += 1,
        &|job| job.render.max_depth += 1,
        &|job| job.render.glass_shadows = GlassShadows::Opaque,
        &|job| job.render.light_scale = 2.0,
        &|job| job.render.show_background = false,
        &|job| job.rate = FrameRate::parse("25").unwrap(),
        &|job| job.shutter = Shutter { open: 0.5, time_samples: 2 },
        &|job| job.shutter = Shutter { open: 0.5, time_samples: 3 },
        &|job| job.render.filter = PixelFilter::Mitchell,
        &|job| job.render.adaptive = Some(Adaptive { max_samples: 16, threshold: 0.1 }),
        &|job| {
            job.render.adaptive = Some(Adaptive { max_samples: 16, threshold: 0.1 });
            job.exposure = Exposure::Ev(3.0);
        },
        &|job| job.render.light_size.radius = 0.1,
        &|job| job.render.light_size.sun_angle_radians = 0.1,
        &|job| job.render.lens = lens(Aperture::Radius(2.0), Focus::Center),
        &|job| job.render.lens = lens(Aperture::FNumber(2.0), Focus::Center),
        &|job| job.render.lens = lens(Aperture::Radius(2.0), Focus::Metres(1.0)),
    ];
    let mut seen = std::collections::BTreeSet::from([expected.clone(), render_hash(&base(), 2)]);
    for change in other {
        assert!(seen.insert(with(change)), "two jobs with different images have one hash");
    }
    assert_eq!(seen.len(), 23);
}
