//! Rendering of one planned sequence: its frames with progress output, and the files beside them.

use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use crate::progress::{Manifest, ReportedSequence, Reporter, RunKind, Verbosity, option_names, pretty_json};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Result, Warning};
use rayframe::image_file::write_atomically;
use rayframe::output::SOFTWARE;
use rayframe::scene::AssetCacheUse;
use rayframe::sequence::{
    self, FailedFrame, FrameReport, Plan, RunLock, SequenceEvent, SequenceJob, Summary,
};
use rayframe::settings::{ProgressStyle, SettingValues};
use rayframe::shot::{RenderJob, SequenceNames};

use crate::cli::outcome::Outcome;
use crate::cli::presenter::Presenter;

/// Sidecar files, with the settings that name them.
pub(in crate::cli) fn other_files(job: &RenderJob) -> Vec<(&Path, &'static str)> {
    let outline = &job.outline;
    let reports = [(&outline.stats, "stats"), (&outline.manifest, "manifest")];
    let reports = reports.into_iter().filter_map(|(path, option)| Some((path.as_deref()?, option)));
    let common_sheet =
        outline.contact_sheet.as_deref().filter(|_| job.sequence.sequence_outputs.is_on_common_sheet);
    let common_sheet = common_sheet.map(|path| (path, "contact_sheet"));
    job.sequence.sequence_outputs.files().chain(common_sheet).chain(reports).collect()
}

/// Checks that the files beside the frames replace nothing but such files.
///
/// # Errors
/// Those of [`sequence::check_other_files`].
pub(in crate::cli) fn check_others<'a>(
    others: impl IntoIterator<Item = (&'a Path, &'static str)>,
    args: &SettingValues,
) -> Result<()> {
    sequence::check_other_files(others, args.overwrite)
}

/// Checks that all files can be written, removes temporary files of killed runs, and excludes runs that would write the same frames
/// while the result is held.
pub(in crate::cli) fn prepare(
    job: &SequenceJob,
    plan: &Plan,
    others: &[(&Path, &'static str)],
    cancel: &CancelFlag,
) -> Result<Option<RunLock>> {
    plan.prepare()?;
    sequence::prepare_other_files(others)?;
    RunLock::acquire(job, plan, cancel)
}

/// Renders the frames with progress output, and writes manifest, statistics, movie and contact sheet. One failure does not
/// prevent the rest. `warnings`, which people have read already, follow the start for programs.
pub(in crate::cli) fn perform(
    (job, plan): (&RenderJob, &Plan),
    args: &SettingValues,
    run: RunKind,
    warnings: &[Warning],
    cancel: &CancelFlag,
) -> Outcome {
    let RenderJob { sequence, outline, .. } = job;
    let verbosity =
        Verbosity { is_quiet: args.quiet, is_verbose: args.verbose, names_failures: sequence.keep_going };
    let reported = ReportedSequence {
        output: sequence.output.shown(),
        scene: sequence.scene.path.clone(),
        names: outline.names.clone(),
        run,
    };
    let reporter = Reporter::new(args.progress, verbosity, &reported);
    let is_json = args.progress == ProgressStyle::Json;
    let presenter = Presenter::new(sequence, plan, args.quiet);
    let manifest = outline.manifest.as_deref().map(|path| Manifest::new(path, job, plan));
    // A frame may fail without an event, as where no thread starts.
    let are_failures_told = AtomicBool::new(false);
    let summary = sequence::run(sequence, plan, cancel, &|event| {
        if matches!(event, SequenceEvent::FrameFailed(..)) {
            are_failures_told.fetch_or(verbosity.names_failures, Ordering::Relaxed);
        }
        if let Some(manifest) = &manifest {
            manifest.tell(event);
        }
        // The summary is the last JSON line, after what concerns the movie.
        if !(is_json && matches!(event, SequenceEvent::Finished(_))) {
            reporter.print(event);
        }
        if matches!(event, SequenceEvent::Started { .. }) {
            for warning in warnings {
                reporter.repeat(warning);
            }
        }
        presenter.watch(event, &reporter);
    });
    let statistics = outline.stats.as_deref().map(|path| write_statistics(path, job, &summary));
    let presented = presenter.present(&summary, &reporter, cancel);
    if is_json {
        reporter.print(SequenceEvent::Finished(&summary));
    }
    // Last, as it lists what is presented.
    let manifest = manifest.map(|manifest| manifest.write(presented.as_deref().unwrap_or_default()));
    let sidecar_errors =
        [manifest, statistics, Some(presented.map(|_| ()))].into_iter().flatten().filter_map(Result::err);
    Outcome {
        sidecar_errors: sidecar_errors.collect(),
        are_failures_told: are_failures_told.into_inner(),
        summary,
    }
}

/// The file of `--stats`.
#[derive(Serialize)]
struct Statistics<'a> {
    schema: u32,
    software: &'static str,
    scene: Cow<'a, str>,
    #[serde(flatten)]
    names: &'a SequenceNames,
    resolution: [u32; 2],
    samples: u32,
    threads: usize,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    asset_cache: Option<AssetCacheUse>,
    interrupted: bool,
    frames: &'a [FrameReport],
    kept: &'a [i64],
    failed: Vec<FailedEntry>,
}

#[derive(Serialize)]
struct FailedEntry {
    frame: i64,
    code: u8,
    message: String,
}

fn write_statistics(path: &Path, job: &RenderJob, summary: &Summary) -> Result<()> {
    let failed = summary.failed.iter().map(|FailedFrame { frame, error }| FailedEntry {
        frame: *frame,
        code: error.exit_code(),
        message: option_names(&error.to_string()),
    });
    let (width, height) = job.sequence.render.resolution;
    let statistics = Statistics {
        schema: 2,
        software: SOFTWARE,
        scene: job.sequence.scene.path.to_string_lossy(),
        names: &job.outline.names,
        resolution: [width, height],
        samples: job.sequence.render.samples,
        threads: rayon::current_num_threads(),
        seconds: summary.seconds,
        asset_cache: job.sequence.scene.asset_cache,
        interrupted: summary.is_interrupted,
        frames: &summary.written,
        kept: &summary.kept,
        failed: failed.collect(),
    };
    write_atomically(path, &pretty_json(&statistics)?)
}
