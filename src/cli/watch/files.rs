//! Detection of changed files by polling.
//!
//! Times, sizes and inode numbers are polled four times a second. Notifications of the system would come sooner, but not for
//! network file systems, container mounts and editors that replace the file. Polling a few dozen files takes less
//! than a millisecond.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use rayframe::cancel::CancelFlag;

/// Interval between checks for a signal.
pub(super) const TICK: Duration = Duration::from_millis(25);
/// Polling interval. A changed file is read after it has been unchanged for one interval.
const INTERVAL: Duration = Duration::from_millis(250);

/// State of a file: size, time, identity; `None` for a missing file.
type Stamp = Option<(u64, Option<SystemTime>, u64)>;

/// Watched files and their states before they were read.
#[derive(Debug, Default)]
pub(super) struct WatchedFiles {
    stamps: BTreeMap<PathBuf, Stamp>,
    /// Time of the last poll before reading began.
    looked: Option<SystemTime>,
    last_look: Mutex<Option<Instant>>,
    /// Whether a change was noticed since.
    was_noticed: AtomicBool,
}

impl WatchedFiles {
    /// Records the present states, before the files are read.
    pub(super) fn look(&mut self) {
        self.looked = Some(SystemTime::now());
        *self.was_noticed.get_mut() = false;
        self.stamps = self.now();
    }

    /// Adds files.
    pub(super) fn add(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        for path in paths {
            let looked = self.looked;
            self.stamps.entry(path).or_insert_with_key(|path| {
                // A file that changed since reading began may have been read before or after the change.
                stamp(path).filter(|(_, modified, _)| looked.is_none() || *modified <= looked)
            });
        }
    }

    /// Replaces the watched files.
    pub(super) fn replace(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        let mut earlier = std::mem::take(&mut self.stamps);
        for path in paths {
            match earlier.remove_entry(&path) {
                Some((path, stamp)) => {
                    self.stamps.insert(path, stamp);
                }
                None => self.add([path]),
            }
        }
    }

    /// Whether a file has changed. Polls at most once per interval.
    pub(super) fn has_changed_by_now(&self) -> bool {
        let Ok(mut last) = self.last_look.lock() else { return false };
        if last.is_some_and(|last| last.elapsed() < INTERVAL) {
            return false;
        }
        *last = Some(Instant::now());
        let has_changed = self.now() != self.stamps;
        if has_changed {
            self.was_noticed.store(true, Ordering::Relaxed);
        }
        has_changed
    }

    /// Returns once a file has changed and is unchanged for one interval; `false` once `stop` is raised. After a change that was noticed
    /// the files may be again what they were: one was gone for a moment.
    pub(super) fn wait_for_change(&self, stop: &CancelFlag) -> bool {
        let was_noticed = self.was_noticed.load(Ordering::Relaxed);
        let mut earlier = None;
        loop {
            let now = self.now();
            if (was_noticed || now != self.stamps) && earlier.as_ref() == Some(&now) {
                return !stop.is_raised();
            }
            earlier = Some(now);
            let start = Instant::now();
            while start.elapsed() < INTERVAL {
                if stop.is_raised() {
                    return false;
                }
                std::thread::sleep(TICK);
            }
        }
    }

    fn now(&self) -> BTreeMap<PathBuf, Stamp> {
        self.stamps.keys().map(|path| (path.clone(), stamp(path))).collect()
    }
}

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok(), identity(&metadata)))
}

/// Inode number: differs for another file of the same name.
#[cfg(unix)]
fn identity(metadata: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

#[cfg(not(unix))]
fn identity(_: &Metadata) -> u64 {
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_change_appear_or_go_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "1").unwrap();
        let old = SystemTime::now() - Duration::from_secs(60);
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(old).unwrap();
        let missing = folder.path().join("b");
        let mut files = WatchedFiles::default();
        files.look();
        files.add([path.clone(), missing.clone()]);
        assert_eq!(files.now(), files.stamps);

        std::fs::write(&path, "22").unwrap();
        assert_ne!(files.now(), files.stamps);
        files.look();
        assert_eq!(files.now(), files.stamps);
        std::fs::write(&missing, "").unwrap();
        assert_ne!(files.now(), files.stamps);
        files.look();
        std::fs::remove_file(&path).unwrap();
        assert_ne!(files.now(), files.stamps);
        // Files that are no longer watched are ignored.
        files.replace([missing]);
        assert_eq!(files.now(), files.stamps);
    }

    #[test]
    fn files_that_are_again_what_they_were_end_a_wait_after_a_change() {
        let folder = tempfile::tempdir().unwrap();
        let (path, away) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&path, "1").unwrap();
        let mut files = WatchedFiles::default();
        files.add([path.clone()]);
        files.look();
        std::fs::rename(&path, &away).unwrap();
        assert!(files.has_changed_by_now());
        std::fs::rename(&away, &path).unwrap();
        assert_eq!(files.now(), files.stamps);
        let stop = CancelFlag::new();
        assert!(files.wait_for_change(&stop));
        stop.raise();
        assert!(!files.wait_for_change(&stop));
    }

    #[test]
    fn a_file_that_changes_while_it_is_first_read_counts_as_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut files = WatchedFiles::default();
        files.look();
        std::fs::write(&path, "1").unwrap();
        let later = SystemTime::now() + Duration::from_secs(60);
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(later).unwrap();
        files.add([path]);
        assert_ne!(files.now(), files.stamps);
    }
}
