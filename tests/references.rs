//! The suite of `scenes/`: every shot looks as its references, one test each, and every reference has a shot.
//!
//! It is what `rayframe test --suite scenes` does. `cargo test --test references light/` tests a part. A picture that differs waits
//! beside its reference; look at `target/regression/index.html`, then `cargo run --release -- accept --suite scenes`, and commit
//! the reference together with what changed it. Where `CI` is set nothing is kept.

use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use libtest_mimic::{Arguments, Failed, Trial};
use rayframe::cancel::CancelFlag;
use rayframe::cli::ShotFiles;
use rayframe::error::Result;
use rayframe::regression::suite::{
    RunOptions, ShotResult, Suite, SuiteResult, SuiteShot, discover, finish, is_ci, report_page, test_shot,
};
use rayframe::regression::write_report;

#[expect(clippy::print_stderr, reason = "a test says what is wrong")]
fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    match tested(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn tested(arguments: &Arguments) -> Result<ExitCode> {
    let suite = Arc::new(Suite::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"))?);
    let shots = discover(&suite, &ShotFiles)?;
    let results = Arc::new(Mutex::new(Vec::new()));
    let trials = shots.iter().map(|shot| trial(&suite, shot, &results)).collect();
    let start = Instant::now();
    let conclusion = libtest_mimic::run(arguments, trials);
    let shots_of_results =
        std::mem::take(&mut *results.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    if arguments.list || shots_of_results.is_empty() {
        return Ok(conclusion.exit_code());
    }
    let is_whole = shots_of_results.len() == shots.len();
    let seconds = start.elapsed().as_secs_f64();
    let dangling = report(&suite, &shots, shots_of_results, seconds)?;
    // References without a shot are told where all shots are known.
    Ok(if dangling > 0 && is_whole { ExitCode::from(101) } else { conclusion.exit_code() })
}

fn trial(suite: &Arc<Suite>, shot: &SuiteShot, results: &Arc<Mutex<Vec<ShotResult>>>) -> Trial {
    let (suite, shot, results) = (Arc::clone(suite), shot.clone(), Arc::clone(results));
    Trial::test(shot.name.clone(), move || {
        let result = test_shot(&suite, &ShotFiles, &shot, !is_ci(), &CancelFlag::new())?;
        let messages = result.failures();
        let passes = result.passes();
        if let Ok(mut results) = results.lock() {
            results.push(result);
        }
        if passes { Ok(()) } else { Err(Failed::from(messages.join("\n"))) }
    })
}

/// Writes the page; gives the number of references that no shot asks for.
#[expect(clippy::print_stderr, reason = "a test says what is wrong")]
fn report(suite: &Suite, shots: &[SuiteShot], mut results: Vec<ShotResult>, seconds: f64) -> Result<usize> {
    results.sort_by(|a, b| a.name.cmp(&b.name));
    let options = RunOptions { keeps_pending: !is_ci(), ..RunOptions::default() };
    let dangling = finish(suite, shots, &results, &options)?;
    let result = SuiteResult { shots: results, dangling, seconds };
    let page = suite.report.join("index.html");
    write_report(&report_page(suite, &result, "cargo test --release --test references"), &page)?;
    for picture in &result.dangling {
        eprintln!("{}: {}", picture.name, picture.messages.join("; "));
    }
    if !result.passes() {
        eprintln!(
            "report: {}\naccept what is right: cargo run --release -- accept --suite scenes",
            page.display()
        );
    }
    Ok(result.dangling.len())
}
