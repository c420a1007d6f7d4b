//! Rendering the shots of a suite and comparing them with their references.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::super::{
    EncodedPicture, FrameStatus, Judgement, LayeredPicture, Limits, ReportedFrame, judge, pixel_hash,
};
use super::limits::PresetLimits;
use super::names::{
    ReferenceFile, pending_path, picture_name, reference_files, reference_path, removal_path,
    shots_of_picture,
};
use super::pending::{keep, remove_file};
use super::render::render_shot;
use super::result::is_passed;
use super::{ShotReader, ShotResult, Suite, SuiteResult, SuiteShot, discover};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// How a suite is run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Which shots: the one of this name, or, where none has it, all whose names contain it. Empty for all.
    pub filter: String,
    /// Whether pictures without reference, and those that differ, are kept beside the references for [`super::accept`].
    pub keeps_pending: bool,
    /// Threads in all; 0 for as many as there are cores.
    pub threads: usize,
}

/// Renders and compares the shots of a suite, several at once. Each is told when it is finished, from any thread.
///
/// # Errors
/// When the suite itself cannot be read, when the filter fits nothing, and on cancellation; what goes wrong with one shot is one
/// of the failures.
pub fn run(
    suite: &Suite,
    reader: &dyn ShotReader,
    options: &RunOptions,
    cancel: &CancelFlag,
    on_shot: &(dyn Fn(&ShotResult) + Sync),
) -> Result<SuiteResult> {
    let start = Instant::now();
    let shots = discover(suite, reader)?;
    let names = shots.iter().map(|shot| shot.name.as_str());
    let fits = fitting(&options.filter, names);
    let chosen: Vec<&SuiteShot> = shots.iter().filter(|shot| fits(&shot.name)).collect();
    let results = test_shots(suite, reader, options, &chosen, cancel, on_shot)?;
    let dangling = finish(suite, &shots, &results, options)?;
    if results.is_empty() && dangling.is_empty() {
        return Err(Error::usage(format!(
            "no shot's name contains \"{}\"; rayframe test --list names all of them",
            options.filter.escape_debug()
        )));
    }
    Ok(SuiteResult { shots: results, dangling, seconds: start.elapsed().as_secs_f64() })
}

/// Tells whether a name is meant by `filter`: it is the filter, or contains it where no name of `all` is the filter.
pub(super) fn fitting<'a>(filter: &str, mut all: impl Iterator<Item = &'a str>) -> impl Fn(&str) -> bool {
    let is_name = all.any(|name| name == filter);
    move |name| if is_name { name == filter } else { name.contains(filter) }
}

/// As many shots at once as there are threads; where there are fewer shots, each has several threads.
fn test_shots(
    suite: &Suite,
    reader: &dyn ShotReader,
    options: &RunOptions,
    shots: &[&SuiteShot],
    cancel: &CancelFlag,
    on_shot: &(dyn Fn(&ShotResult) + Sync),
) -> Result<Vec<ShotResult>> {
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let workers = threads.min(shots.len()).max(1);
    let next = AtomicUsize::new(0);
    let results = Mutex::new(BTreeMap::new());
    let work = || -> Result<()> {
        let pool = ThreadPoolBuilder::new().num_threads(threads / workers).build();
        let pool = pool.map_err(|error| Error::Internal {
            message: format!("the threads cannot be started: {error}"),
        })?;
        while let Some(shot) = shots.get(next.fetch_add(1, Ordering::Relaxed)) {
            let result = pool.install(|| test_shot(suite, reader, shot, options.keeps_pending, cancel))?;
            on_shot(&result);
            if let Ok(mut results) = results.lock() {
                results.insert(result.name.clone(), result);
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let ended = workers.into_iter().map(|worker| {
            worker.join().unwrap_or_else(|payload| std::panic::resume_unwind(payload))
        });
        // All are waited for before the first failure counts.
        ended.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    Ok(results.into_inner().unwrap_or_default().into_values().collect())
}

/// Renders and compares one shot.
///
/// # Errors
/// [`Error::Interrupted`] when cancelled, and what writing beside the references meets; all else is in the result.
pub fn test_shot(
    suite: &Suite,
    reader: &dyn ShotReader,
    shot: &SuiteShot,
    keeps_pending: bool,
    cancel: &CancelFlag,
) -> Result<ShotResult> {
    cancel.check()?;
    let start = Instant::now();
    let limits = suite.limits_of(&shot.path);
    let passing = limits.as_ref().map_or(suite.limits, |limits| *limits);
    let pictures = match limits.and_then(|limits| pictures(suite, reader, shot, limits, cancel)) {
        Ok(pictures) => pictures,
        Err(error @ Error::Interrupted(_)) => return Err(error),
        Err(error) => vec![unopened(shot, &error)],
    };
    if keeps_pending {
        for picture in &pictures {
            keep(suite, &picture.reported.name, picture.pending.as_deref())?;
        }
    }
    Ok(ShotResult {
        name: shot.name.clone(),
        path: shot.path.clone(),
        preset: passing.name(),
        limits: passing.limits,
        pictures: pictures.into_iter().map(|picture| picture.reported).collect(),
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// A picture, and the file that may become its reference.
struct TestedPicture {
    reported: ReportedFrame,
    pending: Option<Vec<u8>>,
}

fn unopened(shot: &SuiteShot, error: &Error) -> TestedPicture {
    TestedPicture { reported: broken(shot.name.clone(), None, error.to_string()), pending: None }
}

fn broken(name: String, frame: Option<i64>, message: String) -> ReportedFrame {
    ReportedFrame {
        name,
        frame,
        status: FrameStatus::Broken,
        messages: vec![message],
        judgement: None,
        expected: None,
        actual: None,
        actual_hash: None,
    }
}

fn pictures(
    suite: &Suite,
    reader: &dyn ShotReader,
    shot: &SuiteShot,
    limits: PresetLimits,
    cancel: &CancelFlag,
) -> Result<Vec<TestedPicture>> {
    let (job, warnings) = reader.job(suite, &shot.path)?;
    if let (true, Some(first)) = (job.strict, warnings.first()) {
        let more = match warnings.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        return Err(Error::Different { message: format!("{first}{more}, which strict refuses") });
    }
    let rendered = render_shot(job, cancel)?;
    let count = rendered.frames.len();
    let tested = rendered.frames.iter().map(|(frame, file)| {
        let name = picture_name(&shot.name, *frame, count);
        let number = (count > 1).then_some(*frame);
        match file {
            Ok(file) => compared(suite, &limits.limits, name, number, file),
            Err(error) => {
                Ok(TestedPicture { reported: broken(name, number, error.to_string()), pending: None })
            }
        }
    });
    tested.collect()
}

/// Compares the picture in `file` with the reference of its name.
fn compared(
    suite: &Suite,
    limits: &Limits,
    name: String,
    frame: Option<i64>,
    file: &Path,
) -> Result<TestedPicture> {
    let reference = reference_path(&suite.references, &name);
    let actual = LayeredPicture::read(file)?;
    let bytes = std::fs::read(file).map_err(Error::missing(file))?;
    let mut reported = broken(name, frame, String::new());
    reported.messages.clear();
    if reference.exists() {
        match LayeredPicture::read(&reference) {
            Ok(expected) => settle(&mut reported, &actual, &expected, limits),
            Err(error) => {
                reported.status = FrameStatus::Different;
                reported.messages.push(error.to_string());
            }
        }
    } else {
        reported.status = FrameStatus::Missing;
        reported.messages.push(format!("there is no reference {}", reference.display()));
    }
    let stored = if is_passed(&reported) { size_of(&reference) } else { bytes.len() as u64 };
    if stored > suite.max_reference_bytes {
        reported.status = FrameStatus::Broken;
        reported.messages.push(format!(
            "the file has {} KiB and a reference at most {}; ask for fewer pixels or layers, or raise max_reference_kib",
            stored.div_ceil(1024),
            suite.max_reference_bytes / 1024
        ));
    }
    if !is_passed(&reported) {
        reported.actual = EncodedPicture::new(&actual);
        reported.actual_hash = Some(pixel_hash(&actual));
    }
    let waits = matches!(reported.status, FrameStatus::Missing | FrameStatus::Different);
    Ok(TestedPicture { reported, pending: waits.then_some(bytes) })
}

fn settle(
    reported: &mut ReportedFrame,
    actual: &LayeredPicture,
    expected: &LayeredPicture,
    limits: &Limits,
) {
    let mut judgement: Judgement = judge(actual, expected, limits);
    if judgement.passes() {
        reported.status = FrameStatus::Passed;
        judgement.flip_map = None;
    } else {
        reported.status = FrameStatus::Different;
        reported.messages = judgement.failures();
        reported.expected = EncodedPicture::new(expected);
    }
    reported.judgement = Some(judgement);
}

fn size_of(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |metadata| metadata.len())
}

/// What is left after all shots: gives the references that no shot asks for, and removes what earlier runs left pending.
///
/// `shots` are all of the suite, `results` those that were tested.
///
/// # Errors
/// When the references cannot be read, or what waits beside them cannot be written.
pub fn finish(
    suite: &Suite,
    shots: &[SuiteShot],
    results: &[ShotResult],
    options: &RunOptions,
) -> Result<Vec<ReportedFrame>> {
    let asked: BTreeSet<&str> =
        results.iter().flat_map(|shot| &shot.pictures).map(|picture| picture.name.as_str()).collect();
    // A shot that was not tested, or could not be opened, may ask for any frame.
    let is_known = |shot: &SuiteShot| {
        results.iter().any(|result| result.name == shot.name && !is_unopened(result))
    };
    let unknown: BTreeSet<&str> =
        shots.iter().filter(|shot| !is_known(shot)).map(|shot| shot.name.as_str()).collect();
    let is_settled = |name: &str| !shots_of_picture(name).any(|shot| unknown.contains(shot));
    let fits = fitting(&options.filter, shots.iter().map(|shot| shot.name.as_str()));
    let is_meant = |name: &str| shots_of_picture(name).any(&fits);
    let files = reference_files(&suite.references)?;
    let mut dangling = Vec::new();
    for file in &files {
        match file {
            ReferenceFile::Reference(name) => {
                if !asked.contains(name.as_str()) && is_settled(name) && is_meant(name) {
                    dangling.push(without_shot(suite, name));
                    if options.keeps_pending {
                        keep_removal(suite, name)?;
                    }
                }
            }
            ReferenceFile::Pending(name) => {
                let is_stale = !asked.contains(name.as_str()) && is_settled(name) && is_meant(name);
                if options.keeps_pending && is_stale {
                    remove_file(&pending_path(&suite.references, name))?;
                }
            }
            ReferenceFile::Removal(name) => {
                let is_stale = asked.contains(name.as_str())
                    || !files.contains(&ReferenceFile::Reference(name.clone()));
                if options.keeps_pending && is_stale {
                    remove_file(&removal_path(&suite.references, name))?;
                }
            }
        }
    }
    Ok(dangling)
}

fn is_unopened(result: &ShotResult) -> bool {
    result.pictures.iter().any(|picture| picture.status == FrameStatus::Broken && picture.frame.is_none())
}

fn without_shot(suite: &Suite, name: &str) -> ReportedFrame {
    let mut reported = broken(name.to_owned(), None, "no shot asks for this reference".to_owned());
    reported.status = FrameStatus::Dangling;
    let expected = LayeredPicture::read(&reference_path(&suite.references, name));
    reported.expected = expected.ok().as_ref().and_then(EncodedPicture::new);
    reported
}

fn keep_removal(suite: &Suite, name: &str) -> Result<()> {
    crate::image_file::write_atomically(&removal_path(&suite.references, name), b"")
}
