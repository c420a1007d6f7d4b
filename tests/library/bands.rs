//! Frames in bands of rows: the same bytes as frames that are rendered at once.

use std::path::{Path, PathBuf};

use rayframe::cancel::CancelFlag;
use rayframe::image_file::inspect_exr;
use rayframe::sequence::{Plan, SequenceEvent, SequenceJob, Summary, run};
use rayframe::shot::{ShotRequest, shot_job};

/// A job of one of this repository's shots with other settings, written to `folder/name`.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn job(shot: &str, folder: &Path, name: &str, settings: &[&str]) -> SequenceJob {
    let output = format!("output={}", folder.join(name).display());
    let mut overrides: Vec<_> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    overrides.push(output);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(shot);
    shot_job(&ShotRequest { path: &path, suite: None, overrides: &overrides }).unwrap().sequence
}

/// Renders in bands of `rows`, or at once.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(job: &SequenceJob, rows: Option<u32>) -> Summary {
    let mut plan = Plan::new(job).unwrap();
    plan.band_rows = rows;
    plan.prepare().unwrap();
    let summary = run(job, &plan, &CancelFlag::new(), &|_| ());
    assert!(summary.failed.is_empty() && !summary.is_interrupted, "{:?}", summary.failed);
    summary
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Renders a shot at once and in bands of `rows`, and compares all files byte by byte.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn assert_same_bytes(shot: &str, rows: u32, settings: &[&str]) {
    let [whole, bands] = [None, Some(rows)].map(|rows| {
        let folder = tempfile::tempdir().unwrap();
        let summary = render(&job(shot, folder.path(), "a.####.exr", settings), rows);
        (folder, summary)
    });
    let [names, expected] = [&bands.0, &whole.0].map(|folder| files(folder.path()));
    assert!(!expected.is_empty());
    assert_eq!(names.len(), expected.len(), "{settings:?}");
    for (file, expected) in names.iter().zip(&expected) {
        assert_eq!(file.file_name(), expected.file_name());
        let is_same = std::fs::read(file).unwrap() == std::fs::read(expected).unwrap();
        assert!(is_same, "{} {settings:?}", file.display());
    }
    for (report, expected) in bands.1.written.iter().zip(&whole.1.written) {
        assert_eq!((&report.sha256, report.bytes), (&expected.sha256, expected.bytes));
        let facts = |files: &[rayframe::sequence::AovFileReport]| -> Vec<_> {
            files.iter().map(|file| (file.sha256.clone(), file.bytes)).collect()
        };
        assert_eq!(facts(&report.aov_files), facts(&expected.aov_files));
        assert_eq!(report.rays.camera, expected.rays.camera);
    }
}

#[test]
fn bands_of_whitted_frames_have_the_bytes_of_whole_frames() {
    let shot = "skin/two_bone_strip.toml";
    let size = "resolution=48x100";
    assert_same_bytes(shot, 32, &[size, "frames=3,5"]);
    // Samples of edges, filters, shutters and lenses look beyond a band.
    let sampled = ["samples=2", "max_samples=8", "filter=mitchell", "aovs=all"];
    assert_same_bytes(shot, 64, &[&[size, "frames=5"][..], &sampled].concat());
    let blurred = ["samples=4", "shutter=0.5", "time_samples=2", "aovs=data,crypto", "exr=float,piz"];
    assert_same_bytes(shot, 32, &[&[size, "frames=5"][..], &blurred].concat());
}

#[test]
fn without_write_behind_bands_are_on_the_disk_before_the_next_frame_begins() {
    let folder = tempfile::tempdir().unwrap();
    let mut job =
        job("skin/two_bone_strip.toml", folder.path(), "a.##.exr", &["resolution=16x70", "frames=0-4"]);
    job.write_behind = false;
    let mut plan = Plan::new(&job).unwrap();
    plan.band_rows = Some(32);
    let missing = std::sync::Mutex::new(Vec::new());
    let summary = run(&job, &plan, &CancelFlag::new(), &|event| {
        if let SequenceEvent::FrameStarted(planned) = event
            && (0..planned.frame).any(|frame| !job.output.path(frame).is_file())
        {
            missing.lock().unwrap().push(planned.frame);
        }
    });
    assert_eq!(summary.written.len(), 5);
    assert_eq!(missing.into_inner().unwrap(), [0_i64; 0]);
}

#[test]
fn bands_of_paths_have_the_bytes_of_whole_frames() {
    let shot = "path/box.toml";
    let paths = ["integrator=path", "frames=0", "resolution=24x70"];
    assert_same_bytes(shot, 32, &[&paths[..], &["samples=64", "noise=0.1", "aovs=all"]].concat());
    assert_same_bytes(shot, 32, &[&paths[..], &["samples=4", "sample_range=1-2"]].concat());
}

#[test]
fn split_files_and_crops_have_their_bytes_in_bands() {
    let settings = ["frames=5", "samples=1", "split_aovs=true", "aovs=light,depth,crypto_object"];
    let shot = "skin/two_bone_strip.toml";
    let crop = ["resolution=40x100", "crop=3,5,39,98"];
    assert_same_bytes(shot, 32, &[&settings[..], &crop].concat());
    // Chunks of 256 rows.
    let lossy = ["resolution=12x600", "exr=half,dwab"];
    assert_same_bytes(shot, 256, &[&settings[..], &lossy].concat());
}

#[test]
fn bands_are_planned_where_whole_frames_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let planned = |settings: &[&str]| {
        let settings = [&["frames=0", "resolution=4096x4096"], settings].concat();
        Plan::new(&job("path/box.toml", folder.path(), "a.exr", &settings)).map(|plan| plan.band_rows)
    };
    assert_eq!(planned(&[]).unwrap(), None);
    let rows = planned(&["max_memory=1500M"]).unwrap().unwrap();
    assert!(rows.is_multiple_of(32) && (32..4096).contains(&rows), "{rows}");
    // More values of a pixel leave fewer rows.
    let all = planned(&["max_memory=1500M", "aovs=all"]).unwrap().unwrap();
    assert!(all.is_multiple_of(32) && all < rows, "{all} {rows}");
    assert!(planned(&["max_memory=1500M", "exr=half,dwab"]).unwrap().unwrap().is_multiple_of(256));
    let named = [
        ("preview=png", "`preview`"),
        ("checkpoint=true", "`checkpoint`"),
        ("time_limit=9", "`time_limit`"),
        ("contact_sheet=a.png", "`contact_sheet`"),
    ];
    for (setting, name) in named {
        let error = planned(&["max_memory=1500M", "integrator=path", setting]).unwrap_err();
        let message = format!(
            "more than the limit of 1.5 GB; without {name} it is rendered in bands of rows, which fit; render a \
             smaller image or raise `max_memory`"
        );
        assert!(error.exit_code() == 77 && error.to_string().contains(&message), "{error}");
    }
    let limited = ["frames=0", "resolution=4096x4096", "max_memory=1500M"];
    let error = Plan::new(&job("path/box.toml", folder.path(), "a.png", &limited)).unwrap_err().to_string();
    assert!(error.contains("; with EXR files as `output` it is rendered in bands of rows"), "{error}");
    // The program alone needs more.
    let mut too_little = job("path/box.toml", folder.path(), "a.exr", &["frames=0", "resolution=4096x4096"]);
    too_little.max_memory_bytes = 5_000_000;
    let error = Plan::new(&too_little).unwrap_err();
    assert!(error.exit_code() == 77 && !error.to_string().contains("bands"), "{error}");
}

#[test]
fn a_cancelled_frame_of_bands_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let job = job("path/box.toml", folder.path(), "a.exr", &["frames=0", "resolution=64x256", "samples=4"]);
    let mut plan = Plan::new(&job).unwrap();
    plan.band_rows = Some(32);
    let cancel = CancelFlag::new();
    let shares = std::sync::Mutex::new(Vec::new());
    let summary = run(&job, &plan, &cancel, &|event| {
        if let SequenceEvent::FrameProgress(_, progress) = event {
            shares.lock().unwrap().push(progress.share);
            // In the middle of a later band.
            if progress.share > 0.5 {
                cancel.raise();
            }
        }
    });
    assert!(summary.is_interrupted && summary.written.is_empty());
    assert_eq!(files(folder.path()), [] as [PathBuf; 0]);
    let shares = shares.into_inner().unwrap();
    assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)) && shares.len() > 4);
}

#[test]
fn finished_frames_of_bands_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let settings = ["frames=0", "resolution=64x100", "samples=1"];
    let job = job("path/box.toml", folder.path(), "a.exr", &settings);
    render(&job, Some(32));
    assert_eq!(inspect_exr(&folder.path().join("a.exr")).unwrap().size, (64, 100));
    assert_eq!(Plan::new(&job).unwrap().remaining(), 0);
}
