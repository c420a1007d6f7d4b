//! The suite of `scenes/` against its references: what `rayframe test --suite scenes` does, as a test.
//!
//! `cargo test --test references light/` tests the shots whose names contain `light/`. An image that differs is stored beside its
//! reference as a pending image. Look at `target/regression/index.html`, run `cargo run --release -- accept --suite scenes`, and
//! commit the reference together with the change that caused it. Where `CI` is set, nothing is stored.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use rayframe::cancel::CancelFlag;
use rayframe::cli::ShotFiles;
use rayframe::error::Result;
use rayframe::regression::suite::{RunOptions, Suite, is_ci, report_page, run};
use rayframe::regression::write_report;

#[expect(clippy::print_stderr, reason = "a test without a harness reports its failures itself")]
fn main() -> ExitCode {
    // `cargo test` hands on the options of other tests, such as --nocapture; a word without a dash is a filter.
    let filter = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    match failures(filter) {
        Ok(failures) if failures.is_empty() => ExitCode::SUCCESS,
        Ok(failures) => {
            eprintln!("{}", failures.join("\n"));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the suite, writes its report, and returns one line for each failure and one for the report.
fn failures(filter: String) -> Result<Vec<String>> {
    let suite = Suite::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"))?;
    let is_whole = filter.is_empty();
    let options = RunOptions { filter, keeps_pending: !is_ci(), ..RunOptions::default() };
    let result = run(&suite, &ShotFiles, &options, &CancelFlag::new(), &|_, _| {})?;
    let mut failures = result.failures();
    failures.extend(result.not_kept().map(ToString::to_string));
    // A passing part of the suite does not replace the report of the whole.
    if is_whole || !result.passes() {
        let page: PathBuf = suite.report.join("index.html");
        write_report(
            &report_page(&suite, result, "cargo test --release --test references", !is_ci()),
            &page,
        )?;
        if !failures.is_empty() {
            failures.push(format!("report: {}", page.display()));
            failures.push("accept intended changes: cargo run --release -- accept --suite scenes".to_owned());
        }
    }
    Ok(failures)
}
