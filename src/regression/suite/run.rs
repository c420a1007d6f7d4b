//! Tests all shots of a suite, several at a time.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::filter::Filter;
use super::names::{ReferenceFile, reference_files};
use super::rendered_images::{remove_rendered, write_list};
use super::{Suite, SuiteShot, TestContext, discover, finish, test_shot};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::regression::report_page::ImageBudget;
use crate::regression::result::{ShotResult, SuiteResult};
use crate::regression::verdict::Verdict;

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Selects shots: the shot or image of exactly this name, or else all whose names contain it. Empty selects all.
    pub filter: String,
    /// Whether images that differ or have no reference are stored as pending images, for [`super::accept`].
    pub keeps_pending: bool,
    /// Folder of a report in which rendered images are stored, for [`super::RenderedChecks`]. On build servers, which store no pending
    /// images, this keeps them.
    pub images: Option<PathBuf>,
    /// Number of threads; 0 for one a core.
    pub threads: usize,
}

/// Progress callback: the number of selected shots, and the result of a finished one. Called from any thread.
pub type OnShot<'a> = dyn Fn(usize, &ShotResult) + Sync + 'a;

/// The shots that `filter` selects.
///
/// # Errors
/// Errors of reading the suite, and [`Error::Usage`] when no shot is selected.
pub fn chosen_shots(suite: &Suite, shots: &[SuiteShot], filter: &str) -> Result<Vec<SuiteShot>> {
    let files = reference_files(&suite.references)?;
    let selection = Filter::new(filter, shots, files.iter().map(ReferenceFile::name));
    let chosen: Vec<_> = shots.iter().filter(|shot| selection.matches_shot(&shot.name)).cloned().collect();
    let is_reference = |file: &ReferenceFile| {
        matches!(file, ReferenceFile::Reference(_)) && selection.matches_image(file.name())
    };
    if chosen.is_empty() && !files.iter().any(is_reference) {
        return Err(if filter.is_empty() {
            let folder = suite.file.parent().filter(|folder| !folder.as_os_str().is_empty());
            let message = "the suite has neither a shot file (.toml) nor a scene (.glb, .gltf); docs/suites.md explains how to begin";
            Error::invalid(folder.unwrap_or(".".as_ref()), "", message)
        } else {
            nothing_called(filter)
        });
    }
    Ok(chosen)
}

fn nothing_called(word: &str) -> Error {
    let word = word.escape_debug();
    Error::usage(format!("no shot's name contains \"{word}\"; rayframe test --list prints all names"))
}

/// Renders and compares the shots of a suite, several at a time. Calls `on_shot` for each finished shot.
///
/// # Errors
/// When the suite cannot be read, when the filter selects nothing, and on cancellation. An error of one shot becomes a failure of that
/// shot.
pub fn run(
    suite: &Suite,
    options: &RunOptions,
    cancel: &CancelFlag,
    on_shot: &OnShot<'_>,
) -> Result<SuiteResult> {
    let start = Instant::now();
    let shots = discover(suite)?;
    let chosen = chosen_shots(suite, &shots, &options.filter)?;
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let workers = threads.min(chosen.len()).max(1);
    if let Some(folder) = &options.images {
        remove_rendered(folder);
    }
    let image_budget = ImageBudget::new();
    let context = TestContext {
        suite,
        keeps_pending: options.keeps_pending,
        images: options.images.as_deref(),
        image_budget: &image_budget,
        shots_at_once: workers,
        cancel,
    };
    let results = test_shots(&context, &chosen, threads / workers, on_shot)?;
    let (orphaned, not_kept) = finish(suite, &shots, &results, &options.filter, options.keeps_pending)?;
    if results.is_empty() && orphaned.is_empty() {
        return Err(nothing_called(&options.filter));
    }
    let mut result =
        SuiteResult { shots: results, orphaned, not_kept, seconds: start.elapsed().as_secs_f64() };
    if let Some(folder) = options.images.as_ref().filter(|_| result.counts().worst() != Verdict::Identical) {
        let written = write_list(suite, &result, folder);
        result.not_kept.extend(written.err());
    }
    Ok(result)
}

/// Tests `context.shots_at_once` shots at a time, each with `threads` threads.
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
        let joined = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|payload| std::panic::resume_unwind(payload)));
        // Wait for all workers before returning the first error.
        joined.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(results)
}
