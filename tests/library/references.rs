//! The suite of `scenes/` against its references: what `rayframe test --suite scenes --allow-dir .` does, as a test.
//!
//! `cargo run --release -- test --suite scenes --allow-dir . light/` tests the shots whose names contain `light/`. An image that differs is stored beside its
//! reference as a pending image. Look at `target/regression/index.html`, run `cargo run --release -- accept --suite scenes --allow-dir .`, and
//! commit the reference together with the change that caused it. Where `CI` is set, nothing is stored.

use std::path::{Path, PathBuf};

use rayframe::cancel::CancelFlag;
use rayframe::error::Result;
use rayframe::regression::suite::{PageCommands, RunOptions, Suite, is_ci, report_page, run};
use rayframe::regression::write_report;

#[test]
fn all_shots_match_their_references() {
    let failures = failures().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Runs the suite, writes its report, and returns one line for each failure and one for the report.
fn failures() -> Result<Vec<String>> {
    let suite = Suite::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"))?;
    let options = RunOptions { keeps_pending: !is_ci(), ..RunOptions::default() };
    let result = run(&suite, &options, &CancelFlag::new(), &|_, _| {})?;
    let mut failures = result.failures();
    failures.extend(result.not_kept().map(ToString::to_string));
    let page: PathBuf = suite.report.join("index.html");
    let commands = PageCommands {
        test: "cargo test --test library references",
        allowed: &[".".into()],
        keeps_pending: !is_ci(),
    };
    write_report(&report_page(&suite, result, &commands), &page)?;
    if !failures.is_empty() {
        failures.push(format!("report: {}", page.display()));
        failures.push(
            "accept intended changes: cargo run --release -- accept --suite scenes --allow-dir .".to_owned(),
        );
    }
    Ok(failures)
}
