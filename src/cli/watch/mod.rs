//! `rayframe watch`: one frame, rendered again whenever something that it was made from changes.
//!
//! A change ends the picture under way and begins a new one, first coarse, then whole. What is wrong with a file is said in
//! one line, and the next change is waited for: files are often broken while they are being saved.

mod coarse;
mod files;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use rayon::ThreadPoolBuilder;

use crate::progress::{print_error, print_note};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Result, Warning};
use rayframe::image_file::{inspect_exr, inspect_png, write_atomically};
use rayframe::sequence::{ExistingFiles, OutputFormat, OutputPattern, Plan, SequenceJob};

use super::render::{other_files, perform, prepare, refuse_collisions};
use super::render_options::{RenderOptions, message};
use super::understood::understood;
use super::{Ending, ending, settle_warnings, signals};
use rayframe::error::{Origin, SettingError};
use rayframe::gltf::ImageLoading;
use rayframe::sequence::FrameSpec;
use rayframe::settings::{ProgressStyle, SettingValues};
use rayframe::shot::{RenderJob, ShotSettings, resolve};

use files::WatchedFiles;

/// How often a signal is looked for.
const TICK: Duration = Duration::from_millis(25);

/// The exit code of errors about what a file holds.
const WRONG_FILE: u8 = 65;

/// What lives from picture to picture.
struct Watch<'a> {
    options: &'a RenderOptions,
    /// Raised by signals.
    stop: CancelFlag,
    files: WatchedFiles,
    /// The last picture under the output's name that was not coarse.
    whole: Option<Vec<u8>>,
    /// What was understood last, and the warnings about it.
    told: (String, Vec<Warning>),
}

/// Renders what is asked for until a signal comes.
pub(super) fn run(options: &RenderOptions) -> Ending {
    watch(options).unwrap_or_else(|error| ending(Err(error)))
}

fn watch(options: &RenderOptions) -> Result<Ending> {
    let internal = |message: String| Error::Internal { message };
    // What is wrong with the settings is said with the first picture.
    let threads = options.settings().ok().and_then(|shot| shot.values.threads);
    let pool = ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build();
    let pool = pool.map_err(|error| internal(format!("the threads cannot be started: {error}")))?;
    let stop = CancelFlag::new();
    let caught =
        signals::watch(&stop).map_err(|error| internal(format!("signals cannot be watched: {error}")))?;
    let mut watch =
        Watch { options, stop, files: WatchedFiles::default(), whole: None, told: Default::default() };
    let mut is_first = true;
    loop {
        watch.files.look();
        match pool.install(|| watch.picture()) {
            Ok(()) | Err(Error::Interrupted(_)) => {}
            // Only what is wrong in a file will be mended by saving it.
            Err(error) if is_first && error.exit_code() != WRONG_FILE => return Err(error),
            Err(error) => {
                watch.files.add(path_of(&error));
                print_error(&message(&error));
            }
        }
        is_first = false;
        if !watch.files.wait_for_change(&watch.stop) {
            break;
        }
    }
    Ok(caught.number().map_or(Ending::Code(75), Ending::Signal))
}

impl Watch<'_> {
    /// Reads everything and makes the picture.
    fn picture(&mut self) -> Result<()> {
        self.files.add(self.options.shot_file());
        if self.options.is_dry_run() {
            return Err(Error::usage("--dry-run: nothing is watched; write rayframe render --dry-run"));
        }
        let mut shot = self.options.settings()?;
        self.files.add([shot.scene.clone()]);
        settle_for_one(&mut shot);
        self.picture_of(&shot).map_err(|error| shot.settings.locate(error))
    }

    fn picture_of(&mut self, shot: &ShotSettings) -> Result<()> {
        let args = &shot.values;
        let RenderJob { sequence: mut job, choices, warnings, environment, mut inputs } =
            resolve(shot, ImageLoading::Texels)?;
        inputs.extend(shot.shot_file.clone());
        self.files.replace(inputs.iter().cloned());
        refuse_many(&job)?;
        job.existing = ExistingFiles::Overwrite;
        job.sequence_outputs.check()?;
        let plan = Plan::new(&job)?;
        let others = other_files(&job, args);
        refuse_collisions(&plan, &others, &inputs)?;
        if !args.overwrite {
            protect_foreign(&job, &plan)?;
        }
        let told = (understood(&job, &environment), [choices.as_slice(), &warnings].concat());
        if told != self.told || job.strict {
            settle_warnings(&job.scene.path, &choices, false)?;
            settle_warnings(&job.scene.path, &warnings, job.strict)?;
            if !args.quiet {
                print_note(&told.0);
            }
            self.told = told;
        }
        prepare(&plan, &others)?;
        self.keep_whole(&job, &plan);
        let drawn = self.draw(&job, &plan, args);
        if self.stop.is_raised() {
            self.put_back_whole(&job, &plan)?;
        }
        drawn
    }

    /// Remembers the picture that is there, unless it is a coarse one.
    fn keep_whole(&mut self, job: &SequenceJob, plan: &Plan) {
        for planned in &plan.frames {
            if !coarse::is_coarse(job, &planned.path) {
                self.whole = std::fs::read(&planned.path).ok();
            }
        }
    }

    /// Leaves no coarse picture behind: the last whole one takes its place, or nothing.
    fn put_back_whole(&self, job: &SequenceJob, plan: &Plan) -> Result<()> {
        for planned in &plan.frames {
            if coarse::is_coarse(job, &planned.path) {
                match &self.whole {
                    Some(whole) => write_atomically(&planned.path, whole)?,
                    // One that cannot be removed says itself what it is.
                    None => drop(std::fs::remove_file(&planned.path)),
                }
            }
        }
        Ok(())
    }

    /// Makes the coarse picture and then the whole one, unless something changes before.
    fn draw(&self, job: &SequenceJob, plan: &Plan, args: &SettingValues) -> Result<()> {
        let cancel = CancelFlag::new();
        let (running, over) = channel::<()>();
        thread::scope(|threads| {
            // Dropped at the end, even by a panic.
            let _running = running;
            let flag = cancel.clone();
            threads.spawn(move || {
                while over.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    if self.stop.is_raised() || self.files.has_changed_by_now() {
                        flag.raise();
                        return;
                    }
                }
            });
            for planned in &plan.frames {
                coarse::write(job, planned, &cancel)?;
            }
            perform(job, plan, args, &cancel)?.result()
        })
    }
}

/// Asks for the first frame unless another is asked for, and for lines, which unlike bars stay when the next picture begins.
fn settle_for_one(shot: &mut ShotSettings) {
    let values = &shot.values;
    let asks_for_frames = values.all
        || values.frames.is_some()
        || (values.start, values.end, values.step) != (None, None, None);
    let is_typed =
        shot.settings.origin_of("output").is_some_and(|origin| !matches!(origin, Origin::File { .. }));
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

/// `robot.watch.png` in the current folder: what a shot file calls its frames stays theirs. EXR where settings ask for what PNG
/// files do not hold.
fn own_name(shot: &ShotSettings) -> OsString {
    let args = &shot.values;
    let is_exr =
        args.aovs.is_some() || args.exr.is_some() || args.split_aovs || args.stamp || args.preview.is_some();
    let named = shot.shot_file.as_ref().unwrap_or(&shot.scene);
    let mut name = OutputPattern::escaped(Path::new(named.file_stem().unwrap_or_default()));
    name.push(if is_exr { ".watch.exr" } else { ".watch.png" });
    name
}

/// Pictures of Rayframe are replaced, those of others are not, and neither are other frames of a sequence.
fn protect_foreign(job: &SequenceJob, plan: &Plan) -> Result<()> {
    for planned in &plan.frames {
        for path in planned.paths().filter(|path| path.exists()) {
            let is_preview = planned.preview_path.as_deref() == Some(path);
            let stored = match job.output.format() {
                OutputFormat::Exr if !is_preview => inspect_exr(path),
                _ => inspect_png(path),
            };
            let why = match stored.ok().and_then(|stored| stored.render_hash) {
                None => "was made by another program",
                Some(hash) if job.output.is_numbered() && !coarse::is_of(&hash, &planned.render_hash) => {
                    "is a frame of a sequence"
                }
                Some(_) => continue,
            };
            return Err(Error::CannotCreate {
                path: path.to_owned(),
                message: format!(
                    "the file is there and {why}; name the picture with -o, or --overwrite replaces it"
                ),
            });
        }
    }
    Ok(())
}

/// The file that an error is about, whose change may mend it.
fn path_of(error: &Error) -> Option<PathBuf> {
    match error {
        Error::Invalid { path, .. }
        | Error::Unsupported { path, .. }
        | Error::Missing { path, .. }
        | Error::Refused { path, .. }
        | Error::Setting(SettingError { origin: Origin::File { path, .. }, .. }) => Some(path.clone()),
        _ => None,
    }
}
