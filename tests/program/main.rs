//! The program from outside: what it writes, what it says, and how it ends, one subject a module.

mod aovs;
mod bad_input;
mod cli;
mod determinism;
mod diff;
mod environments;
mod killed;
mod merge;
mod presentation;
mod progress;
mod refusals;
mod scenes;
mod shots;
mod suite;
mod watch;

use std::path::Path;
use std::process::{Command, Output};

/// The files in a folder, sorted; none where there is no folder.
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
