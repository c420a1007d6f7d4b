//! All shots of a suite, several at once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::super::ImageBudget;
use super::filter::Filter;
use super::names::{ReferenceFile, reference_files};
use super::{
    ShotReader, ShotResult, Suite, SuiteResult, SuiteShot, TestContext, discover, finish, test_shot,
};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// How a suite is run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Which shots: the one of this name, or the one of the picture of this name, or all whose names contain it. Empty for all.
    pub filter: String,
    /// Whether pictures without reference, and those that differ, are kept beside the references for [`super::accept`].
    pub keeps_pending: bool,
    /// Threads in all; 0 for as many as there are cores.
    pub threads: usize,
}

/// Tells how far a run is: the shots that there are, and one that is finished. Comes from any thread.
pub type OnShot<'a> = dyn Fn(usize, &ShotResult) + Sync + 'a;

/// The shots that `word` means.
///
/// # Errors
/// Those of reading the suite, and [`Error::Usage`] when there is no such shot.
pub fn chosen_shots(suite: &Suite, shots: &[SuiteShot], word: &str) -> Result<Vec<SuiteShot>> {
    let files = reference_files(&suite.references)?;
    let filter = Filter::new(word, shots, files.iter().map(ReferenceFile::name));
    let chosen: Vec<_> = shots.iter().filter(|shot| filter.matches_shot(&shot.name)).cloned().collect();
    let is_reference = |file: &ReferenceFile| {
        matches!(file, ReferenceFile::Reference(_)) && filter.matches_image(file.name())
    };
    if chosen.is_empty() && !files.iter().any(is_reference) {
        return Err(if word.is_empty() {
            let folder = suite.file.parent().filter(|folder| !folder.as_os_str().is_empty());
            let message = "there is neither a shot file (.toml) nor a scene (.glb, .gltf) in the suite; docs/suites.md tells how to begin";
            Error::invalid(folder.unwrap_or(".".as_ref()), "", message)
        } else {
            nothing_called(word)
        });
    }
    Ok(chosen)
}

fn nothing_called(word: &str) -> Error {
    let word = word.escape_debug();
    Error::usage(format!("no shot's name contains \"{word}\"; rayframe test --list names all of them"))
}

/// Renders and compares the shots of a suite, several at once. Each is told when it is finished.
///
/// # Errors
/// When the suite itself cannot be read, when the filter fits nothing, and on cancellation; what goes wrong with one shot is one
/// of the failures.
pub fn run(
    suite: &Suite,
    reader: &dyn ShotReader,
    options: &RunOptions,
    cancel: &CancelFlag,
    on_shot: &OnShot<'_>,
) -> Result<SuiteResult> {
    let start = Instant::now();
    let shots = discover(suite, reader)?;
    let chosen = chosen_shots(suite, &shots, &options.filter)?;
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let workers = threads.min(chosen.len()).max(1);
    let room = ImageBudget::new();
    let context = TestContext {
        suite,
        reader,
        keeps_pending: options.keeps_pending,
        room: &room,
        shots_at_once: workers,
        cancel,
    };
    let results = test_shots(&context, &chosen, threads / workers, on_shot)?;
    let (orphaned, not_kept) = finish(suite, &shots, &results, &options.filter, options.keeps_pending)?;
    if results.is_empty() && orphaned.is_empty() {
        return Err(nothing_called(&options.filter));
    }
    Ok(SuiteResult { shots: results, orphaned, not_kept, seconds: start.elapsed().as_secs_f64() })
}

/// As many shots at once as the context says, each with so many threads.
fn test_shots(
    context: &TestContext<'_>,
    shots: &[SuiteShot],
    threads: usize,
    on_shot: &OnShot<'_>,
) -> Result<Vec<ShotResult>> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    let work = || -> Result<()> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| Error::Internal {
            message: format!("the threads cannot be started: {error}"),
        })?;
        while let Some(shot) = shots.get(next.fetch_add(1, Ordering::Relaxed)) {
            let result = pool.install(|| test_shot(context, shot))?;
            on_shot(shots.len(), &result);
            results.lock().unwrap_or_else(PoisonError::into_inner).push(result);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..context.shots_at_once).map(|_| scope.spawn(work)).collect();
        let ended = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|payload| std::panic::resume_unwind(payload)));
        // All are waited for before the first failure counts.
        ended.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(results)
}
