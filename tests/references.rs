//! The suite of `scenes/`: every shot looks as its references, one test each, and every reference has a shot.
//!
//! It is what `rayframe test --suite scenes` does. `cargo test --test references light/` tests a part. A picture that differs waits
//! beside its reference; look at `target/regression/index.html`, then `cargo run --release -- accept --suite scenes`, and commit
//! the reference together with what changed it. Where `CI` is set nothing is kept.

use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::Instant;

use libtest_mimic::{Arguments, Failed, Trial};
use rayframe::cancel::CancelFlag;
use rayframe::cli::ShotFiles;
use rayframe::error::Result;
use rayframe::regression::suite::{
    ShotResult, Suite, SuiteResult, SuiteShot, TestContext, discover, finish, is_ci, orphaned_references,
    report_page, test_shot,
};
use rayframe::regression::{ImageBudget, write_report};

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
    let shots = Arc::new(discover(&suite, &ShotFiles)?);
    let results = Arc::new(Mutex::new(Vec::new()));
    let mut trials: Vec<Trial> = shots.iter().map(|shot| trial(&suite, shot, &results)).collect();
    let (of_suite, of_shots) = (Arc::clone(&suite), Arc::clone(&shots));
    trials.push(Trial::test("references_have_shots", move || {
        let orphaned = orphaned_references(&of_suite, &ShotFiles, &of_shots)?;
        if orphaned.is_empty() { Ok(()) } else { Err(Failed::from(orphaned.join("\n"))) }
    }));
    let start = Instant::now();
    let conclusion = libtest_mimic::run(arguments, trials);
    let results = std::mem::take(&mut *results.lock().unwrap_or_else(PoisonError::into_inner));
    // A part of the shots leaves the report of all as it was, unless there is something to be seen.
    if results.len() == shots.len() || results.iter().any(|result| !result.passes()) {
        report(&suite, &shots, results, start.elapsed().as_secs_f64())?;
    }
    Ok(conclusion.exit_code())
}

/// Room for the pictures of failures.
static ROOM: LazyLock<ImageBudget> = LazyLock::new(ImageBudget::new);

fn trial(suite: &Arc<Suite>, shot: &SuiteShot, results: &Arc<Mutex<Vec<ShotResult>>>) -> Trial {
    let (suite, shot, results) = (Arc::clone(suite), shot.clone(), Arc::clone(results));
    Trial::test(shot.name.clone(), move || {
        let cancel = CancelFlag::new();
        let context = TestContext {
            suite: &suite,
            reader: &ShotFiles,
            keeps_pending: !is_ci(),
            room: &ROOM,
            shots_at_once: 1,
            cancel: &cancel,
        };
        let result = test_shot(&context, &shot)?;
        let (passes, failures) = (result.passes(), result.failures());
        results.lock().unwrap_or_else(PoisonError::into_inner).push(result);
        if passes { Ok(()) } else { Err(Failed::from(failures.join("\n"))) }
    })
}

/// Writes the page.
#[expect(clippy::print_stderr, reason = "a test says what is to be done")]
fn report(suite: &Suite, shots: &[SuiteShot], mut results: Vec<ShotResult>, seconds: f64) -> Result<()> {
    results.sort_by(|a, b| a.name.cmp(&b.name));
    let (orphaned, not_kept) = finish(suite, shots, &results, "", !is_ci())?;
    let result = SuiteResult { shots: results, orphaned, not_kept, seconds };
    let passes = result.passes();
    let page = suite.report.join("index.html");
    write_report(&report_page(suite, result, "cargo test --release --test references", !is_ci()), &page)?;
    if !passes {
        eprintln!(
            "report: {}\naccept what is right: cargo run --release -- accept --suite scenes",
            page.display()
        );
    }
    Ok(())
}
