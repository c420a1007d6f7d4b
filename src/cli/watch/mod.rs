//! `rayframe watch`: renders one frame again after every change of its inputs.
//!
//! A change cancels the current image and starts a new one, first coarse, then full. An error in a file is printed in
//! one line, and the program continues to watch: files are often broken while they are being saved.

mod coarse;
mod files;
mod last_image;
mod options;

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;

use rayon::ThreadPoolBuilder;

use crate::progress::{RunKind, print_error, print_note};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Result, Warning, exit_code};
use rayframe::image_file::{inspect_exr, inspect_png, other_image};
use rayframe::sequence::{
    ExistingFiles, OutputFormat, OutputPattern, Plan, SequenceJob, SharedExposure, check_whole_frames,
};

use super::exit_status::{ExitStatus, exit_status};
use super::render::{check_folders, check_others, other_files, perform, prepare};
use super::render_options::{RenderOptions, message};
use super::signals;
use super::summary::summary;
use super::warnings::{report_warnings, unique_warnings};
use rayframe::error::{Provenance, SettingError};
use rayframe::gltf::{ImageLoading, named_files};
use rayframe::sequence::FrameSpec;
use rayframe::settings::{ProgressStyle, SettingValues};
use rayframe::shot::{RenderJob, ShotSettings, resolve};

use files::{TICK, WatchedFiles};
use last_image::LastImage;

pub(super) use options::WatchOptions;

/// State that persists between images.
struct Watch<'a> {
    options: &'a RenderOptions,
    /// Raised by signals.
    stop: CancelFlag,
    files: WatchedFiles,
    last: Option<LastImage>,
    /// Render hashes of the images that this run has begun, which it may replace under any name.
    own: BTreeSet<String>,
    /// The last summary, and its warnings.
    printed: (String, Vec<Warning>),
}

/// Renders after every change until a signal comes.
pub(super) fn run(options: &WatchOptions) -> ExitStatus {
    watch(&options.0).unwrap_or_else(|error| exit_status(Err(error)))
}

fn watch(options: &RenderOptions) -> Result<ExitStatus> {
    let internal = |message: String| Error::Internal { message };
    // Errors in the settings are reported with the first image.
    let threads = options.settings().ok().and_then(|shot| shot.values.threads);
    let pool = ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build();
    let pool = pool.map_err(Error::no_threads)?;
    let stop = CancelFlag::new();
    let caught =
        signals::watch(&stop).map_err(|error| internal(format!("signals cannot be watched: {error}")))?;
    let mut watch = Watch {
        options,
        stop,
        files: WatchedFiles::default(),
        last: None,
        own: BTreeSet::new(),
        printed: Default::default(),
    };
    let mut is_first = true;
    loop {
        watch.files.look();
        match pool.install(|| watch.render()) {
            Ok(()) | Err(Error::Interrupted(_)) => {}
            // Only an error in the content of a file can be repaired by saving it.
            Err(error) if is_first && error.exit_code() != exit_code::INVALID => {
                // The first error is the reason.
                let _ = watch.finish_image();
                return Err(error);
            }
            Err(error) => {
                watch.files.add(path_of(&error));
                print_error(&message(&error));
                // The repair may take long.
                if let Err(error) = watch.last.as_ref().map_or(Ok(()), LastImage::restore) {
                    print_error(&message(&error));
                }
            }
        }
        is_first = false;
        if !watch.files.wait_for_change(&watch.stop) {
            break;
        }
    }
    watch.finish_image()?;
    Ok(caught.number().map_or(ExitStatus::Code(exit_code::TEMPORARY), ExitStatus::Signal))
}

impl Watch<'_> {
    /// Reads all inputs and renders the image.
    fn render(&mut self) -> Result<()> {
        self.files.add(self.options.shot_file());
        if self.options.is_dry_run() {
            return Err(Error::usage("--dry-run: nothing is watched; write rayframe render --dry-run"));
        }
        let mut shot = self.options.settings()?;
        self.files.add([shot.scene.clone()]);
        settle_for_one(&mut shot);
        let rendered = self.render_shot(&shot);
        if rendered.as_ref().is_err_and(|error| error.exit_code() == exit_code::INVALID) {
            // The error names the scene, and what repairs it may be a file that the scene names.
            self.files.add(named_files(&shot.scene));
        }
        rendered.map_err(|error| shot.settings.locate(error))
    }

    fn render_shot(&mut self, shot: &ShotSettings) -> Result<()> {
        let args = &shot.values;
        let mut resolved = resolve(shot, ImageLoading::Texels)?;
        self.files.replace(resolved.inputs.iter().cloned());
        check_folders([&resolved.outline], shot, &self.options.allowed_folders())?;
        refuse_many(&resolved.sequence)?;
        if resolved.sequence.output.is_movie() {
            return Err(Error::setting("output", "one image is watched; end the name with .png or .exr"));
        }
        resolved.sequence.existing = ExistingFiles::Overwrite;
        measure_exposure_once(&mut resolved.sequence);
        let RenderJob { sequence: job, outline, choices, warnings, camera, environment, inputs, .. } =
            &resolved;
        // The coarse image is one at once.
        check_whole_frames(job)?;
        let plan = Plan::new(job)?;
        let others = other_files(&resolved);
        plan.check_collisions(&others, inputs)?;
        check_others(others.iter().copied(), args)?;
        if !args.overwrite {
            protect_foreign(job, &plan, &self.own)?;
        }
        let printed =
            (summary(job, &outline.names, *camera, environment), [choices.as_slice(), warnings].concat());
        if printed != self.printed || job.strict {
            report_warnings(&job.scene.path, choices, false)?;
            report_warnings(&job.scene.path, warnings, job.strict)?;
            if !args.quiet {
                print_note(&printed.0);
            }
            self.printed = printed;
        }
        let _lock = prepare(job, &plan, &others, &self.stop)?;
        LastImage::keep(&mut self.last, job, &plan)?;
        self.own.extend(plan.frames.iter().map(|planned| planned.render_hash.clone()));
        self.render_frames(&resolved, &plan, args)
    }

    fn finish_image(&self) -> Result<()> {
        self.last.as_ref().map_or(Ok(()), LastImage::finish)
    }

    /// Renders the coarse image and then the full one, unless an input changes before.
    fn render_frames(&self, job: &RenderJob, plan: &Plan, args: &SettingValues) -> Result<()> {
        let cancel = CancelFlag::new();
        let (running, over) = channel::<()>();
        thread::scope(|threads| {
            // Dropped at the end, even by a panic.
            let _running = running;
            let flag = cancel.clone();
            let poll = move || {
                while over.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    if self.stop.is_raised() || self.files.has_changed_by_now() {
                        flag.raise();
                        return;
                    }
                }
            };
            thread::Builder::new().spawn_scoped(threads, poll).map_err(Error::no_threads)?;
            for planned in &plan.frames {
                coarse::write(&job.sequence, planned, &cancel)?;
            }
            let warnings = [unique_warnings(&job.choices), unique_warnings(&job.warnings)].concat();
            perform((job, plan), args, RunKind::Watch(self.stop.clone()), &warnings, &cancel).result()
        })
    }
}

/// Selects the first frame by default, a name of its own for the image, and plain progress lines, which stay when the next image begins.
fn settle_for_one(shot: &mut ShotSettings) {
    let values = &shot.values;
    let asks_for_frames = values.all
        || values.frames.is_some()
        || (values.start, values.end, values.step) != (None, None, None);
    let is_typed =
        shot.settings.origin_of("output").is_some_and(|origin| !matches!(origin, Provenance::File { .. }));
    let output = (!is_typed).then(|| OutputPattern::parse(&own_name(shot)).ok()).flatten();
    shot.change(|settings| {
        if !asks_for_frames {
            settings.frames = Some(FrameSpec::Listed(vec![0]).into());
        }
        if let Some(output) = output {
            settings.output = Some(output.into());
        }
        if settings.values().progress == ProgressStyle::Auto {
            settings.progress = Some(ProgressStyle::Plain.into());
        }
    });
}

fn refuse_many(job: &SequenceJob) -> Result<()> {
    match job.frames.len() {
        0 | 1 => Ok(()),
        count => Err(Error::usage(format!("{count} frames are asked for, and one is watched; add -f 12"))),
    }
}

/// Gives the coarse image and the full one the same automatic exposure.
fn measure_exposure_once(job: &mut SequenceJob) {
    let shared = SharedExposure::new(vec![job.selection.clone()], job.render.resolution);
    job.shared_exposure = Some(Arc::new(shared));
}

/// `robot.watch.png` in the current folder: the output of a shot file is kept for its frames. EXR where settings need what PNG
/// files cannot hold.
fn own_name(shot: &ShotSettings) -> OsString {
    let args = &shot.values;
    let is_exr =
        args.aovs.is_some() || args.exr.is_some() || args.split_aovs || args.stamp || args.preview.is_some();
    let named = shot.shot_file.as_ref().unwrap_or(&shot.scene);
    let mut name = OutputPattern::escaped(Path::new(named.file_stem().unwrap_or_default()));
    name.push(if is_exr { ".watch.exr" } else { ".watch.png" });
    name
}

/// Refuses to replace files of other programs or purposes, and other frames of a sequence, but those of the hashes `own`.
fn protect_foreign(job: &SequenceJob, plan: &Plan, own: &BTreeSet<String>) -> Result<()> {
    for planned in &plan.frames {
        for path in planned.paths().filter(|path| path.exists()) {
            let is_preview = planned.preview_path.as_deref() == Some(path);
            let stored = match job.output.format() {
                OutputFormat::Exr if !is_preview => inspect_exr(path),
                _ => inspect_png(path),
            };
            let hash = stored.ok().and_then(|stored| stored.render_hash);
            let why = match (&hash, hash.as_deref().and_then(other_image)) {
                (None, _) => "was made by another program",
                (_, Some(other)) => &format!("is {other}"),
                (Some(hash), None)
                    if job.output.is_numbered()
                        && !own.contains(hash)
                        && !coarse::is_of(hash, &planned.render_hash) =>
                {
                    "is a frame of a sequence"
                }
                (Some(_), None) => continue,
            };
            return Err(Error::CannotCreate {
                path: path.to_owned(),
                message: format!(
                    "the file is there and {why}; name the image with -o, or --overwrite replaces it"
                ),
            });
        }
    }
    Ok(())
}

/// The file that an error concerns.
fn path_of(error: &Error) -> Option<PathBuf> {
    match error {
        Error::Invalid { path, .. }
        | Error::Unsupported { path, .. }
        | Error::Missing { path, .. }
        | Error::Refused { path, .. }
        | Error::Setting(SettingError { origin: Provenance::File { path, .. }, .. }) => Some(path.clone()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::sequence::exposure_ev;
    use rayframe::settings::Settings;

    #[test]
    fn the_full_image_has_the_exposure_that_was_measured_for_the_coarse_one() {
        let folder = tempfile::tempdir().unwrap();
        let output = OutputPattern::parse(folder.path().join("look.png").as_os_str()).unwrap();
        let mut settings = Settings::default();
        settings.output = Some(output.into());
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
        let shot = ShotSettings::read_with(&scene, settings).unwrap();
        let mut job = resolve(&shot, ImageLoading::Texels).unwrap().sequence;
        measure_exposure_once(&mut job);
        let plan = Plan::new(&job).unwrap();
        // A cancelled measurement fails.
        let raised = CancelFlag::new();
        raised.raise();
        assert!(exposure_ev(&job, &raised).is_err());
        coarse::write(&job, &plan.frames[0], &CancelFlag::new()).unwrap();
        assert!(exposure_ev(&job, &raised).is_ok());
    }
}
