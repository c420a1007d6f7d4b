//! Files of one run of a target, in a temporary folder of the thread.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::verdict::must;

thread_local! {
    static FOLDER: TempDir = must(tempfile::tempdir());
}

/// Path of the file `name` in the folder.
pub(crate) fn path(name: &str) -> PathBuf {
    FOLDER.with(|folder| folder.path().join(name))
}

/// Writes the file `name` and returns its path.
pub(crate) fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = path(name);
    must(std::fs::write(&path, bytes));
    path
}
