//! What tells that a file was made, changed or replaced meanwhile.

use std::path::Path;
use std::time::SystemTime;

/// Length, time of the last change and identity of a file. Two of one path are compared within a run, never between runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FileStamp {
    bytes: u64,
    modified: Option<SystemTime>,
    inode: Option<u64>,
}

impl FileStamp {
    /// That of the file at `path`; `None` without one.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(path).ok()?;
        #[cfg(unix)]
        let inode = Some(std::os::unix::fs::MetadataExt::ino(&metadata));
        #[cfg(not(unix))]
        let inode = None;
        Some(Self { bytes: metadata.len(), modified: metadata.modified().ok(), inode })
    }
}
