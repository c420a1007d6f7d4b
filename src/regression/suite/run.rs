//! Tests all shots of a suite, several at a time.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::changed_files::changed_shots;
use super::discover::discover_files;
use super::filter::Filter;
use super::large_scenes::is_large_file;
use super::names::{ReferenceFile, reference_files};
use super::rendered_images::{remove_rendered, write_list};
use super::retimed::explain_unpaired;
use super::test_shot::{TestContext, test_shot};
use super::verdict_cache::VerdictCache;
use super::{RunOptions, Suite, SuiteShot, finish};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::regression::report_page::ImageBudget;
use crate::regression::result::{ShotResult, SuiteResult};
use crate::regression::verdict::Verdict;

/// Progress callback: the number of selected shots, and the result of a finished one. Called from any thread.
pub type OnShot<'a> = dyn Fn(usize, &ShotResult) + Sync + 'a;

/// The shots that `options` select.
///
/// # Errors
/// Errors of reading the suite and of git, and [`Error::Usage`] when the filter selects no shot.
pub fn chosen_shots(suite: &Suite, shots: &[SuiteShot], options: &RunOptions) -> Result<Vec<SuiteShot>> {
    changed(suite, of_shard(suite, shots, options)?, options)
}

/// Of these shots those that changed since the revision, where one is named.
fn changed(suite: &Suite, shots: Vec<SuiteShot>, options: &RunOptions) -> Result<Vec<SuiteShot>> {
    match &options.changed_since {
        Some(revision) => changed_shots(suite, shots, revision),
        None => Ok(shots),
    }
}

/// The shots that filter and shard select.
fn of_shard(suite: &Suite, shots: &[SuiteShot], options: &RunOptions) -> Result<Vec<SuiteShot>> {
    let mut chosen = filtered(suite, shots, &options.filter)?;
    if let Some(shard) = options.shard {
        chosen.retain(|shot| shard.includes(&shot.name));
    }
    Ok(chosen)
}

fn filtered(suite: &Suite, shots: &[SuiteShot], filter: &str) -> Result<Vec<SuiteShot>> {
    let files = reference_files(suite)?;
    let selection = Filter::new(suite, filter, shots, files.iter().map(ReferenceFile::name));
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
    let (shots, stray) = discover_files(suite)?;
    let selected = of_shard(suite, &shots, options)?;
    let selected_names = names_of(&selected);
    let chosen = changed(suite, selected, options)?;
    let not_tested = &selected_names - &names_of(&chosen);
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    // Files that scenes name are counted as they are tested: of shots with a known verdict nothing is read.
    let (alone, together): (Vec<_>, Vec<_>) = chosen.into_iter().partition(|shot| is_large_file(&shot.scene));
    let workers = threads.min(together.len()).max(1);
    let opened = options.uses_cache.then(|| VerdictCache::open(suite, &suite.cache, &shots)).transpose();
    let (cache, not_opened) = match opened {
        Ok(cache) => (cache.flatten(), None),
        Err(error) => (None, Some(error)),
    };
    if let Some(folder) = &options.images {
        remove_rendered(folder);
    }
    let image_budget = ImageBudget::new();
    let overrides: Vec<String> =
        options.max_memory_bytes.iter().map(|bytes| format!("max_memory={bytes}")).collect();
    let context = TestContext {
        suite,
        overrides: &overrides,
        keeps_pending: options.keeps_pending,
        images: options.images.as_deref(),
        image_budget: &image_budget,
        reports_passing: options.reports_passing,
        cache: cache.as_ref(),
        shots_at_once: workers,
        cancel,
    };
    let count = together.len() + alone.len();
    let on_shot = |result: &ShotResult| on_shot(count, result);
    let Tested { mut results, refused } = test_shots(&context, &together, threads / workers, &on_shot)?;
    let context = TestContext { shots_at_once: 1, ..context };
    for shots in [refused, alone] {
        results.extend(test_shots(&context, &shots, threads, &on_shot)?.results);
    }
    results.sort_by(|a, b| a.name.cmp(&b.name));
    let (mut orphaned, not_kept) = finish(suite, &shots, &results, options)?;
    explain_unpaired(suite, &mut results, &mut orphaned);
    if results.is_empty() && orphaned.is_empty() && options.shard.is_none() && options.changed_since.is_none()
    {
        return Err(nothing_called(&options.filter));
    }
    let mut result = SuiteResult {
        shots: results,
        orphaned,
        not_kept,
        not_tested: not_tested.into_iter().collect(),
        stray,
        not_cached: not_opened.or_else(|| cache.and_then(VerdictCache::into_error)),
        seconds: start.elapsed().as_secs_f64(),
    };
    if let Some(folder) = options.images.as_ref().filter(|_| result.counts().worst() != Verdict::Identical) {
        let written = write_list(&result, folder);
        result.not_kept.extend(written.err());
    }
    Ok(result)
}

fn names_of(shots: &[SuiteShot]) -> BTreeSet<String> {
    shots.iter().map(|shot| shot.name.clone()).collect()
}

struct Tested {
    results: Vec<ShotResult>,
    /// Shots whose share of the memory is too small, and those of large scenes.
    refused: Vec<SuiteShot>,
}

/// Tests `context.shots_at_once` shots at a time, each with `threads` threads.
fn test_shots(
    context: &TestContext<'_>,
    shots: &[SuiteShot],
    threads: usize,
    on_shot: &(dyn Fn(&ShotResult) + Sync),
) -> Result<Tested> {
    let next = AtomicUsize::new(0);
    let (results, refused) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let work = || -> Result<()> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(Error::no_threads)?;
        while let Some(shot) = shots.get(next.fetch_add(1, Ordering::Relaxed)) {
            let Some(result) = pool.install(|| test_shot(context, shot))? else {
                refused.lock().unwrap_or_else(PoisonError::into_inner).push(shot.clone());
                continue;
            };
            on_shot(&result);
            results.lock().unwrap_or_else(PoisonError::into_inner).push(result);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let start = || std::thread::Builder::new().spawn_scoped(scope, work);
        let workers: Vec<_> = (0..context.shots_at_once).map(|_| start()).collect();
        if workers.iter().any(std::result::Result::is_err) {
            // The others end after their first shot.
            next.store(shots.len(), Ordering::Relaxed);
        }
        let joined = workers.into_iter().map(|worker| match worker {
            Ok(worker) => worker.join().unwrap_or_else(|payload| std::panic::resume_unwind(payload)),
            Err(error) => Err(Error::no_threads(error)),
        });
        // Wait for all workers before returning the first error.
        joined.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(Tested { results, refused: refused.into_inner().unwrap_or_else(PoisonError::into_inner) })
}
