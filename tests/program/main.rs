//! Tests of the program: its output files, messages and exit codes, one subject a module.
//!
//! A test that needs a privilege, a program or a processor feature that is missing prints a line `skipped: TEST: why`.

mod aovs;
mod asset_cache;
mod bad_input;
mod bands;
mod camera_paths;
mod check;
mod cli;
mod denoise;
mod determinism;
mod diff;
mod encoders;
mod environments;
mod farm;
mod films;
mod killed;
mod many;
mod merge;
mod own_outputs;
mod passes;
mod plates;
mod presentation;
mod progress;
mod reference_pages;
mod refusals;
mod run_conditions;
mod scenes;
mod shared_output;
mod shell;
mod shots;
mod stale_temporaries;
mod suite;
mod watch;
mod weaker_settings;

use std::path::Path;
use std::process::{Command, Output};

/// Sorted names of the files in a folder; empty if it does not exist.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(crate) fn rayframe(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe")).args(arguments).output().unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn both<'a>(first: &[&'a str], second: &[&'a str]) -> Vec<&'a str> {
    [first, second].concat()
}

/// Reports on the standard error stream, past the capture of the test harness, that the running test cannot test anything here.
pub(crate) fn skipped(why: &str) {
    use std::io::Write as _;
    let thread = std::thread::current();
    let _ = writeln!(std::io::stderr(), "skipped: {}: {why}", thread.name().unwrap_or("test"));
}
