//! `rayframe render`: the named scenes and shot files one after another, each with its sequences.
//!
//! A single scene is the run of one. Several are first checked without texels, one at a time, so that most of what can fail does so
//! before the first frame.

mod common_sheets;
mod scene_warnings;
mod sequence;
mod written_files;

use std::cmp::Reverse;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use crate::progress::{Part, RunKind, Total, print_json, print_note, print_output, print_scene_failure};
use rayframe::cancel::CancelFlag;
use rayframe::error::exit_code::permanence;
use rayframe::error::{Error, Provenance, Result, SettingError, Warning};
use rayframe::gltf::ImageLoading;
use rayframe::image_file::check_name;
use rayframe::scene::{AssetCacheUse, CameraRequest, ClipSelection, Scene, VariantRequest};
use rayframe::sequence::Plan;
use rayframe::settings::{ProgressStyle, SettingValues};
use rayframe::shot::{
    LoadedEnvironments, RenderJob, ShotOutline, ShotSettings, check_shot, resolve_each, resolved_settings,
};

use super::exit_status::{ExitStatus, exit_status};
use super::outcome::{finish, tell_failure_text};
use super::plan::{plan_json, plan_text};
use super::render_options::{NamedShot, RenderOptions, message};
use super::signals::{self, CaughtSignal};
use super::summary::{after_the_end, frames_beside_the_movie, rendered_in_bands, summary};
use common_sheets::{CommonSheets, SheetRun};
use scene_warnings::{report_replaced, report_scene};
pub(super) use sequence::{check_others, other_files, perform, prepare};
use written_files::frame_files;
pub(super) use written_files::{WrittenFiles, check_folders};

/// Renders all named scenes and shot files.
pub(super) fn run(options: &RenderOptions) -> ExitStatus {
    let shots = options.shots();
    let first = shots.iter().find_map(|shot| shot.settings.as_ref().ok());
    let threads = first.and_then(|shot| shot.values.threads).map_or(0, usize::from);
    match ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(|| match Session::new(options, &shots) {
            Ok(session) => session.render(&shots),
            Err(error) => exit_status(Err(error)),
        }),
        Err(error) => exit_status(Err(Error::no_threads(error))),
    }
}

/// State of a run.
struct Session {
    is_dry_run: bool,
    /// Whether there are several scenes, or each clip, camera or variant of one.
    is_many: bool,
    /// Progress style of messages that concern no single scene.
    style: ProgressStyle,
    /// Whether other scenes follow one whose settings cannot be read.
    keeps_going_unread: bool,
    /// Folders that the command line permits outputs of shot files in.
    allowed_folders: Vec<PathBuf>,
    cancel: CancelFlag,
    caught: CaughtSignal,
    /// Whether a signal ends the program at once, because no frame is being rendered.
    ends_at_once: Arc<AtomicBool>,
    environments: LoadedEnvironments,
    files: WrittenFiles,
    sheets: CommonSheets,
    total: Total,
    /// Position of the next sequence.
    part: Part,
    /// The most permanent exit code so far.
    code: u8,
}

/// Why a run ends before its last scene.
enum Stop {
    /// A failure without `keep_going`, already told.
    Failed,
    Signal(i32),
}

impl Session {
    fn new(options: &RenderOptions, shots: &[NamedShot]) -> Result<Self> {
        let values = || shots.iter().filter_map(|shot| Some(&shot.settings.as_ref().ok()?.values));
        let (cancel, ends_at_once) = (CancelFlag::new(), Arc::new(AtomicBool::new(true)));
        let caught = signals::watch_unless(&cancel, &ends_at_once)
            .map_err(|error| Error::Internal { message: format!("signals cannot be watched: {error}") })?;
        let is_many = shots.len() > 1 || values().any(asks_for_each);
        Ok(Self {
            is_dry_run: options.is_dry_run(),
            is_many,
            style: values().next().map_or(options.typed_progress(), style_of),
            keeps_going_unread: options.keeps_going(),
            allowed_folders: options.allowed_folders(),
            cancel,
            caught,
            ends_at_once,
            environments: LoadedEnvironments::default(),
            files: WrittenFiles::default(),
            sheets: CommonSheets::new(SheetRun {
                is_many,
                names_scenes: shots.len() > 1,
                is_quiet: values().next().is_some_and(|values| values.quiet),
            }),
            total: Total { scenes: shots.len(), ..Total::default() },
            part: Part::default(),
            code: 0,
        })
    }

    fn render(mut self, shots: &[NamedShot]) -> ExitStatus {
        let start = Instant::now();
        let stopped = self.render_all(shots).err();
        self.total.is_interrupted = matches!(stopped, Some(Stop::Signal(_)));
        if self.is_many && !self.is_dry_run {
            if stopped.is_none() {
                self.ends_at_once.store(false, Ordering::Relaxed);
                if let Err(error) = self.sheets.write() {
                    tell_failure_text(&message(&error), self.style);
                    self.count(error.exit_code());
                }
            } else if self.part.before > 0 {
                self.sheets.tell_missing();
            }
            self.total.seconds = start.elapsed().as_secs_f64();
            // People read the error alone where no frame was rendered.
            if self.part.before > 0 || stopped.is_none() || self.style == ProgressStyle::Json {
                self.total.print(self.style);
            }
        }
        match stopped {
            Some(Stop::Signal(signal)) => ExitStatus::Signal(signal),
            _ => ExitStatus::Code(self.code),
        }
    }

    fn render_all(&mut self, shots: &[NamedShot]) -> std::result::Result<(), Stop> {
        // Check all scenes before the first frame.
        let mut ready = Vec::new();
        for (position, named) in shots.iter().enumerate() {
            self.sheets.begin(position);
            match &named.settings {
                Ok(shot) if shots.len() == 1 => ready.push((position, named, shot)),
                Ok(shot) => match self.check(shot) {
                    Ok(outline) => {
                        self.add_files(named, shot, &outline).or_else(|error| self.stop(named, &error))?;
                        ready.push((position, named, shot));
                    }
                    Err(error) => self.fail(named, &error)?,
                },
                Err(error) => self.fail(named, error)?,
            }
        }
        if let ([(_, named, _), _, ..], false) = (ready.as_slice(), self.is_dry_run) {
            self.files.probe_folders().or_else(|error| self.stop(named, &error))?;
        }

        // Render.
        for (position, named, shot) in ready {
            self.sheets.begin(position);
            match self.render_shot(named, shot).map_err(|error| shot.settings.locate(error)) {
                Ok(None) => {}
                Ok(Some(stop)) => return Err(stop),
                Err(error) => self.fail(named, &error)?,
            }
        }
        Ok(())
    }

    /// Checks a scene without texels.
    fn check(&mut self, shot: &ShotSettings) -> Result<ShotOutline> {
        let outline = check_shot(shot)?;
        check_folders(&outline.sequences, shot, &self.allowed_folders)?;
        for sequence in &outline.sequences {
            self.sheets.check(sequence, &shot.values)?;
            check_others(sequence.sidecar_files(), &shot.values)?;
        }
        // What is there is compared with what would be rendered. Folders and links that lead nowhere are in the way, too.
        let args = &shot.values;
        let files = outline.sequences.iter().flat_map(|sequence| frame_files(sequence, args));
        let mut may_be_in_the_way = args.checkpoint;
        for file in files.filter(|file| file.symlink_metadata().is_ok()) {
            check_name(&file)?;
            may_be_in_the_way = true;
        }
        if !args.overwrite && may_be_in_the_way {
            for job in resolve_each(shot, ImageLoading::Budget, &mut self.environments)? {
                Plan::new(&job.sequence).map_err(|error| shot.settings.locate(error))?;
            }
        }
        Ok(outline)
    }

    /// Adds the files of a checked scene to those of the scenes before it.
    fn add_files(&mut self, named: &NamedShot, shot: &ShotSettings, outline: &ShotOutline) -> Result<()> {
        self.part.total += outline.sequences.iter().map(|sequence| sequence.frames.len()).sum::<usize>();
        let added = self.files.add(&named.path, shot, outline);
        added.map_err(|error| shot.settings.locate(error))
    }

    /// Loads a scene, plans its sequences and renders them, or prints them in a dry run.
    fn render_shot(&mut self, named: &NamedShot, shot: &ShotSettings) -> Result<Option<Stop>> {
        let images = if self.is_dry_run { ImageLoading::Budget } else { ImageLoading::Texels };
        let mut jobs = resolve_each(shot, images, &mut self.environments)?;
        check_folders(jobs.iter().map(|job| &job.outline), shot, &self.allowed_folders)?;
        if self.total.scenes == 1 && self.is_many {
            let sequences = jobs.iter().map(|job| job.outline.clone()).collect();
            let inputs = jobs.first().map(|job| job.inputs.clone()).unwrap_or_default();
            self.add_files(named, shot, &ShotOutline { sequences, choices: Vec::new(), inputs })?;
        }
        let mut warnings = report_scene(&jobs)?;
        if let (true, Some(job)) = (shot.values.verbose, jobs.first()) {
            report_asset_cache(&job.sequence.scene);
        }
        let mut planned = Vec::new();
        for job in &mut jobs {
            if self.is_many {
                self.sheets.take(job, &shot.values)?;
            }
            planned.push(Plan::new(&job.sequence)?);
        }
        let planned: Vec<_> = jobs.iter().zip(&planned).collect();
        for (job, plan) in &planned {
            plan.check_collisions(&other_files(job), &job.inputs)?;
            check_others(other_files(job), &shot.values)?;
            plan.check_new_names()?;
        }
        warnings.extend(report_replaced(&planned));
        if self.is_dry_run {
            print_plan(shot, &jobs, &planned);
            return Ok(None);
        }
        let prepare =
            |(job, plan): &(&RenderJob, &Plan)| prepare(&job.sequence, plan, &other_files(job), &self.cancel);
        let _locks = planned.iter().map(prepare).collect::<Result<Vec<_>>>()?;
        Ok(self.render_sequences(&planned, &shot.values, &warnings).err())
    }

    /// Renders planned sequences of one scene. Its warnings are those of the first.
    fn render_sequences(
        &mut self,
        planned: &[(&RenderJob, &Plan)],
        args: &SettingValues,
        mut warnings: &[Warning],
    ) -> std::result::Result<(), Stop> {
        let mut is_complete = true;
        for (job, plan) in planned {
            print_summary(job, plan, args);
            let run = if self.is_many { RunKind::Part(self.part) } else { RunKind::Alone };
            self.ends_at_once.store(false, Ordering::Relaxed);
            let told = std::mem::take(&mut warnings);
            let outcome = perform((job, plan), args, run, told, &self.cancel);
            self.sheets.add(job, plan, &outcome.summary);
            self.part.before += plan.frames.len();
            let is_cut_short = outcome.summary.written.len() < plan.frames.len();
            if !(job.sequence.output.is_movie() && is_cut_short) {
                self.total.written += outcome.summary.written.len();
            }
            self.total.kept += outcome.summary.kept.len();
            self.total.failed += outcome.summary.failed.len();
            match finish(outcome, self.caught.number(), args) {
                ExitStatus::Signal(signal) => return Err(Stop::Signal(signal)),
                ExitStatus::Code(0) => {}
                ExitStatus::Code(code) => {
                    is_complete = false;
                    self.count(code);
                    if !args.keep_going {
                        return Err(Stop::Failed);
                    }
                }
            }
            self.ends_at_once.store(true, Ordering::Relaxed);
        }
        self.total.complete_scenes += usize::from(is_complete);
        Ok(())
    }

    /// Tells the failure of a whole scene. The run ends unless it keeps going.
    fn fail(&mut self, named: &NamedShot, error: &Error) -> std::result::Result<(), Stop> {
        self.tell(named, error);
        self.sheets.add_failed(named);
        let keeps_going =
            named.settings.as_ref().map_or(self.keeps_going_unread, |shot| shot.values.keep_going);
        if keeps_going && self.total.scenes > 1 { Ok(()) } else { Err(Stop::Failed) }
    }

    /// Tells a failure that ends the run.
    fn stop<T>(&mut self, named: &NamedShot, error: &Error) -> std::result::Result<T, Stop> {
        self.tell(named, error);
        Err(Stop::Failed)
    }

    /// Prints an error about a scene, with the scene where there are several, and counts its exit code.
    fn tell(&mut self, named: &NamedShot, error: &Error) {
        let mut text = message(error);
        let names_no_file = match error {
            Error::Setting(SettingError { origin, .. }) => !matches!(origin, Provenance::File { .. }),
            Error::Usage { .. } | Error::Internal { .. } => true,
            _ => false,
        };
        if self.total.scenes > 1 && names_no_file {
            text = format!("{}: {text}", named.path.display());
        }
        tell_failure_text(&text, self.style);
        let scene = named.settings.as_ref().ok().map(|shot| &shot.scene);
        let path = scene.filter(|_| named.path.as_os_str().is_empty()).unwrap_or(&named.path);
        print_scene_failure(self.style, path, error.exit_code(), &text);
        self.count(error.exit_code());
        self.total.failed_scenes.push((path.clone(), error.exit_code(), text));
    }

    /// Keeps the most permanent exit code, and of equally permanent ones the smallest, whatever their order.
    fn count(&mut self, code: u8) {
        let rank = |code: u8| (permanence(code), Reverse(code));
        if rank(code) > rank(self.code) {
            self.code = code;
        }
    }
}

/// The style of messages about a whole run: none where it is quiet.
fn style_of(values: &SettingValues) -> ProgressStyle {
    match values.progress {
        ProgressStyle::Auto | ProgressStyle::Bar | ProgressStyle::Plain if values.quiet => {
            ProgressStyle::None
        }
        style => style,
    }
}

fn asks_for_each(values: &SettingValues) -> bool {
    values.animation == ClipSelection::Each
        || values.camera == Some(CameraRequest::Each)
        || values.variant == Some(VariantRequest::Each)
}

/// Prints how often the import found what it looked for in the asset cache.
fn report_asset_cache(scene: &Scene) {
    if let Some(AssetCacheUse { hits, misses }) = scene.asset_cache {
        print_note(&format!("asset cache: {hits} hits, {misses} misses"));
    }
}

fn print_plan(shot: &ShotSettings, jobs: &[RenderJob], planned: &[(&RenderJob, &Plan)]) {
    for (job, plan) in planned {
        print_summary(job, plan, &shot.values);
    }
    let settings = resolved_settings(shot, jobs);
    match shot.values.progress {
        ProgressStyle::Json => print_json(&plan_json(&settings, planned)),
        _ => print_output(&plan_text(&settings, planned)),
    }
}

fn print_summary(job: &RenderJob, plan: &Plan, args: &SettingValues) {
    if !args.quiet {
        print_note(&summary(&job.sequence, &job.outline.names, job.camera, &job.environment));
        let notes = [
            after_the_end(&job.sequence),
            frames_beside_the_movie(&job.sequence, args),
            rendered_in_bands(plan),
        ];
        notes.iter().flatten().for_each(|note| print_note(note));
    }
}
