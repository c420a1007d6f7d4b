//! All shots of a suite, several at once.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::{ShotReader, ShotResult, Suite, SuiteResult, SuiteShot, discover, finish, test_shot};
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
        let ended = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|payload| std::panic::resume_unwind(payload)));
        // All are waited for before the first failure counts.
        ended.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    Ok(results.into_inner().unwrap_or_default().into_values().collect())
}
