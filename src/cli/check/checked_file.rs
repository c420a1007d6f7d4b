//! What a check tells of one file.

use std::path::Path;

use serde::Serialize;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FileStatus {
    /// It holds what was written.
    Whole,
    /// It does not.
    Damaged,
    /// It is whole, and not the file of the manifest.
    Different,
    /// It is not there, or the frame was not rendered.
    Missing,
    /// It is there, and the manifest does not list it.
    Unlisted,
    /// It cannot be read.
    Unreadable,
    /// It has no checksum and there is no manifest, or another program has saved it since.
    Unknown,
}

/// A file, or a frame without a file, and what it is.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CheckedFile {
    pub(super) path: Option<String>,
    pub(super) frame: Option<i64>,
    pub(super) status: FileStatus,
    pub(super) message: String,
}

impl CheckedFile {
    /// A file without a frame number.
    pub(super) fn new(path: Option<&Path>, status: FileStatus, message: String) -> Self {
        let path = path.map(|path| path.to_string_lossy().into_owned());
        Self { path, frame: None, status, message }
    }
}
