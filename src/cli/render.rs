//! `rayframe render`.

use std::path::Path;

use rayon::ThreadPoolBuilder;
use serde_json::json;

use crate::progress::{Manifest, Reporter, Verbosity, print_note, print_output, print_warning};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Result};
use rayframe::image_file::{probe_folder, remove_stale_temporaries, write_atomically};
use rayframe::output::SOFTWARE;
use rayframe::sequence::{self, Plan, ReplacedFile, SequenceJob, Summary, triangle_count};

use super::exit_status::{ExitStatus, exit_status};
use super::outcome::{Outcome, finish, tell_failure};
use super::plan::{plan_json, plan_text};
use super::presenter::Presenter;
use super::render_options::RenderOptions;
use super::signals;
use super::summary::{after_the_end, frames_beside_the_movie, summary};
use super::warnings::report_warnings;
use rayframe::gltf::ImageLoading;
use rayframe::settings::{ProgressStyle, SettingValues};
use rayframe::shot::{RenderJob, ShotSettings, resolve, resolved_settings};

/// Renders a sequence.
pub(super) fn run(options: &RenderOptions) -> ExitStatus {
    let shot = match options.settings() {
        Ok(shot) => shot,
        Err(error) => {
            tell_failure(&error, options.typed_progress());
            return ExitStatus::Code(error.exit_code());
        }
    };
    let pool = ThreadPoolBuilder::new().num_threads(shot.values.threads.map_or(0, usize::from)).build();
    match pool {
        Ok(pool) => pool.install(|| render(&shot, options.is_dry_run())).unwrap_or_else(|error| {
            let error = shot.settings.locate(error);
            tell_failure(&error, shot.values.progress);
            ExitStatus::Code(error.exit_code())
        }),
        Err(error) => {
            exit_status(Err(Error::Internal { message: format!("the threads cannot be started: {error}") }))
        }
    }
}

fn render(shot: &ShotSettings, is_dry_run: bool) -> Result<ExitStatus> {
    let args = &shot.values;
    // Check everything before the first frame.
    let images = if is_dry_run { ImageLoading::Budget } else { ImageLoading::Texels };
    let RenderJob { sequence: job, choices, warnings, camera, environment, mut inputs } =
        resolve(shot, images)?;
    inputs.extend(shot.shot_file.clone());
    report_warnings(&job.scene.path, &choices, false)?;
    report_warnings(&job.scene.path, &warnings, job.strict)?;
    let plan = Plan::new(&job)?;
    let others = other_files(&job, args);
    plan.check_collisions(&others, &inputs)?;
    if triangle_count(&job.scene, &job.selection.roots) == 0 {
        print_warning(&format!(
            "{}: the scene draws no triangles; only the environment is visible",
            job.scene.path.display()
        ));
    }
    if let Some(warning) = replacing_text(&plan.replaced) {
        print_warning(&warning);
    }
    if !args.quiet {
        print_note(&summary(&job, camera, &environment));
        for note in after_the_end(&job).into_iter().chain(frames_beside_the_movie(&job, args)) {
            print_note(&note);
        }
    }
    if is_dry_run {
        let settings = resolved_settings(shot, &job);
        print_output(&match args.progress {
            ProgressStyle::Json => plan_json(&settings, &plan),
            _ => plan_text(&settings, &plan),
        });
        return Ok(ExitStatus::Code(0));
    }
    prepare(&plan, &others)?;

    // Render.
    let cancel = CancelFlag::new();
    let caught = signals::watch(&cancel)
        .map_err(|error| Error::Internal { message: format!("signals cannot be watched: {error}") })?;
    let outcome = perform(&job, &plan, args, &cancel);
    Ok(finish(outcome, caught.number(), args))
}

/// Sidecar files, with the settings that name them.
pub(super) fn other_files<'a>(
    job: &'a SequenceJob,
    args: &'a SettingValues,
) -> Vec<(&'a Path, &'static str)> {
    let reports = [(&args.stats, "stats"), (&args.manifest, "manifest")];
    let reports = reports.into_iter().filter_map(|(path, option)| Some((path.as_deref()?, option)));
    job.sequence_outputs.files().chain(reports).collect()
}

/// Checks that all files can be written, and removes temporary files of killed runs.
pub(super) fn prepare(plan: &Plan, others: &[(&Path, &str)]) -> Result<()> {
    plan.prepare()?;
    for (path, _) in others {
        probe_folder(path)?;
        remove_stale_temporaries(&[path.to_path_buf()]);
    }
    Ok(())
}

/// Renders the frames with progress output, and writes manifest, statistics, movie and contact sheet. One failure does not
/// prevent the rest.
pub(super) fn perform(job: &SequenceJob, plan: &Plan, args: &SettingValues, cancel: &CancelFlag) -> Outcome {
    let verbosity =
        Verbosity { is_quiet: args.quiet, is_verbose: args.verbose, names_failures: job.keep_going };
    let reporter = Reporter::new(args.progress, verbosity, &job.output.shown());
    let presenter = Presenter::new(job, plan);
    let manifest = args.manifest.as_deref().map(|path| Manifest::new(path, job, plan));
    let summary = sequence::run(job, plan, cancel, &|event| {
        if let Some(manifest) = &manifest {
            manifest.tell(event);
        }
        reporter.print(event);
        presenter.watch(event, &reporter);
    });
    let manifest = manifest.map(|manifest| manifest.write());
    let statistics = args.stats.as_deref().map(|path| write_statistics(path, job, &summary));
    let presented = presenter.present(&summary, cancel);
    let sidecar_errors =
        [manifest, statistics, Some(presented)].into_iter().flatten().filter_map(Result::err);
    Outcome { sidecar_errors: sidecar_errors.collect(), summary }
}

/// Warning about files that `--resume` replaces; `None` without any.
fn replacing_text(replaced: &[ReplacedFile]) -> Option<String> {
    let first = replaced.first()?;
    let example = format!("\"{}\" is {}", first.path.display(), first.why);
    Some(match replaced.len() {
        1 => format!("--resume: 1 file made from something else will be replaced: {example}"),
        count => {
            format!("--resume: {count} files made from something else will be replaced; the first, {example}")
        }
    })
}

fn write_statistics(path: &Path, job: &SequenceJob, summary: &Summary) -> Result<()> {
    let failed: Vec<_> = summary
        .failed
        .iter()
        .map(|failed| {
            json!({
                "frame": failed.frame,
                "code": failed.error.exit_code(),
                "message": failed.error.to_string(),
            })
        })
        .collect();
    let (width, height) = job.render.resolution;
    let statistics = json!({
        "schema": 2,
        "software": SOFTWARE,
        "scene": job.scene.path.to_string_lossy(),
        "resolution": [width, height],
        "samples": job.render.samples,
        "threads": rayon::current_num_threads(),
        "seconds": summary.seconds,
        "interrupted": summary.is_interrupted,
        "frames": summary.written,
        "kept": summary.kept,
        "failed": failed,
    });
    write_atomically(path, format!("{statistics:#}\n").as_bytes())
}
