//! The program from outside: what it writes, what it says, and how it ends, one subject a module.

mod cli;
mod determinism;
mod diff;
mod killed;
mod layers;
mod merge;
mod presentation;
mod progress;
mod refusals;
mod shots;
mod watch;

use std::path::Path;

/// The files in a folder, sorted; none where there is no folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
