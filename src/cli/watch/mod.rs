//! `rayframe watch`: one frame, rendered again whenever something that it was made from changes.
//!
//! A change ends the picture under way and begins a new one, first coarse, then whole. What is wrong with a file is said in
//! one line, and the next change is waited for: files are often broken while they are being saved.

mod coarse;
mod files;

use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use rayon::ThreadPoolBuilder;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{inspect_exr, inspect_png};
use crate::progress::{Reporter, Verbosity, print_error, print_note};
use crate::sequence::{self, ExistingFiles, OutputFormat, Plan, SequenceJob};

use super::render::refuse_collisions;
use super::render_args::{ProgressArg, RenderArgs};
use super::render_job::{RenderJob, render_job};
use super::shot::{GivenOptions, MeantOptions};
use super::understood::understood;
use super::{Ending, ending, settle_warnings, signals};

use files::WatchedFiles;

/// How often a signal is looked for.
const TICK: Duration = Duration::from_millis(25);

/// What lives from picture to picture.
struct Watch<'a> {
    given: &'a GivenOptions,
    /// Raised by signals.
    stop: CancelFlag,
    files: WatchedFiles,
    /// What was understood last.
    told: String,
    /// Whether a picture was begun.
    has_begun: bool,
}

/// Renders what is asked for until a signal comes.
pub(super) fn run(given: &GivenOptions) -> Ending {
    watch(given).unwrap_or_else(|error| ending(Err(error)))
}

fn watch(given: &GivenOptions) -> Result<Ending> {
    let internal = |message: String| Error::Internal { message };
    let threads = given.meant()?.args.threads;
    let pool = ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build();
    let pool = pool.map_err(|error| internal(format!("the threads cannot be started: {error}")))?;
    let stop = CancelFlag::new();
    let caught =
        signals::watch(&stop).map_err(|error| internal(format!("signals cannot be watched: {error}")))?;
    let mut watch =
        Watch { given, stop, files: WatchedFiles::default(), told: String::new(), has_begun: false };
    loop {
        watch.files.look();
        match pool.install(|| watch.picture()) {
            Ok(()) | Err(Error::Interrupted(_)) => {}
            // What was typed will not be mended by saving a file.
            Err(error) if !watch.has_begun && !matches!(error, Error::Invalid { .. }) => return Err(error),
            Err(error) => {
                watch.files.add(path_of(&error));
                print_error(&error.to_string());
            }
        }
        if !watch.files.wait_for_change(&watch.stop) {
            break;
        }
    }
    Ok(caught.number().map_or(Ending::Code(75), Ending::Signal))
}

impl Watch<'_> {
    /// Reads everything and makes the picture.
    fn picture(&mut self) -> Result<()> {
        self.files.add(self.given.shot());
        let mut meant = self.given.meant()?;
        self.files.add([meant.args.scene.clone()]);
        one_frame(&mut meant)?;
        let RenderJob { sequence: mut job, choices, warnings, environment, inputs } =
            render_job(&meant.args).map_err(|error| meant.explained(error))?;
        self.files.replace(inputs.iter().cloned().chain(meant.shot.clone()));
        job.existing = ExistingFiles::Overwrite;
        let plan = Plan::new(&job)?;
        refuse_collisions(&plan, meant.args.stats.as_deref(), &inputs)?;
        if !self.has_begun {
            protect_foreign(&job, &plan, &meant.args)?;
        }
        let told = understood(&job, &environment);
        if told != self.told {
            settle_warnings(&job.scene.path, &choices, false)?;
            settle_warnings(&job.scene.path, &warnings, job.strict)?;
            if !meant.args.quiet {
                print_note(&told);
            }
            self.told = told;
        }
        plan.prepare()?;
        self.has_begun = true;
        self.draw(&job, &plan, &meant.args)
    }

    /// Makes the coarse picture and then the whole one, unless something changes before.
    fn draw(&self, job: &SequenceJob, plan: &Plan, args: &RenderArgs) -> Result<()> {
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
            let verbosity =
                Verbosity { is_quiet: args.quiet, is_verbose: args.verbose, names_failures: false };
            let reporter = Reporter::new(args.progress.into(), verbosity, &job.output.shown());
            let summary = sequence::run(job, plan, &cancel, &|event| reporter.tell(event));
            summary.outcome()
        })
    }
}

/// Makes sure that one frame is asked for; without a word about it that is the first.
fn one_frame(meant: &mut MeantOptions) -> Result<()> {
    let args = &mut meant.args;
    if args.dry_run {
        return Err(Error::usage("--dry-run: nothing is watched; write rayframe render --dry-run"));
    }
    if !args.all && args.frames.is_none() && (args.start, args.end, args.step) == (None, None, None) {
        args.frames = Some("0".to_owned());
    }
    if args.progress == ProgressArg::Auto {
        args.progress = ProgressArg::Plain;
    }
    Ok(())
}

/// Pictures of Rayframe are replaced, those of others are not.
fn protect_foreign(job: &SequenceJob, plan: &Plan, args: &RenderArgs) -> Result<()> {
    if let [_, _, ..] = plan.frames.as_slice() {
        return Err(Error::usage(format!(
            "--frames: {} frames are asked for, and one is watched; write it as -f 12",
            plan.frames.len()
        )));
    }
    for planned in &plan.frames {
        if args.overwrite || !planned.path.exists() {
            continue;
        }
        let stored = match job.output.format() {
            OutputFormat::Exr => inspect_exr(&planned.path),
            OutputFormat::Png => inspect_png(&planned.path),
        };
        if !stored.is_ok_and(|stored| stored.render_hash.is_some()) {
            return Err(Error::CannotCreate {
                path: planned.path.clone(),
                message: "the file is there and was made by another program; --overwrite replaces it"
                    .to_owned(),
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
        | Error::Refused { path, .. } => Some(path.clone()),
        _ => None,
    }
}
