//! Lock files: a file that one process at a time holds by a lock of the system, which ends with the process.
//!
//! A held file is removed when it is let go, still under its lock. What a killed process leaves is an unlocked file, which the next
//! process takes over. Locks of other machines count where the network file system has them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Most files that are found to be removed after they were opened.
const MOST_ATTEMPTS: usize = 1000;

/// A file that this process holds. Dropping it removes the file.
#[derive(Debug)]
pub(crate) struct LockFile {
    path: PathBuf,
    file: File,
}

/// Result of an attempt to hold a file.
#[derive(Debug)]
pub(crate) enum Attempt {
    /// This process holds the file.
    Held(LockFile),
    /// Another process holds it.
    Busy,
    /// The file cannot be made, or its file system has no locks.
    Unavailable,
}

impl LockFile {
    /// Tries to hold the file at `path`, which is created where it is missing. Does not wait.
    pub(crate) fn try_hold(path: &Path) -> Attempt {
        for _ in 0..MOST_ATTEMPTS {
            let Ok((file, is_new)) = open(path) else { return Attempt::Unavailable };
            match file.try_lock() {
                // The holder before may have removed the file between opening and locking.
                Ok(()) if !is_at(path, &file) => {}
                Ok(()) => return Attempt::Held(Self { path: path.to_owned(), file }),
                Err(TryLockError::WouldBlock) => return Attempt::Busy,
                Err(TryLockError::Error(_)) => {
                    // One that was there may be held all the same.
                    if is_new {
                        let _ = fs::remove_file(path);
                    }
                    return Attempt::Unavailable;
                }
            }
        }
        Attempt::Unavailable
    }

    /// The file.
    pub(crate) fn file(&self) -> &File {
        &self.file
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Opens a lock file, and tells whether it was missing. One of another user may be readable only, which suffices for a lock but on network
/// file systems.
fn open(path: &Path) -> io::Result<(File, bool)> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        Err(error) => return Err(error),
        Ok(file) => {
            permit_all(&file);
            return Ok((file, true));
        }
    }
    // The holder may remove it meanwhile.
    let opened = match options.create(true).truncate(false).open(path) {
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => File::open(path),
        opened => opened,
    };
    opened.map(|file| (file, false))
}

/// Lets every user of the folder try the lock, which needs the right to write on network file systems.
fn permit_all(file: &File) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let _ = file.set_permissions(fs::Permissions::from_mode(0o666));
    }
    #[cfg(not(unix))]
    let _ = file;
}

/// Whether `file` is still the one at `path`.
fn is_at(path: &Path, file: &File) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let id = |metadata: &fs::Metadata| (metadata.dev(), metadata.ino());
        // A network file system may find a removed file for a while, whose last link is gone.
        matches!((fs::metadata(path), file.metadata()), (Ok(a), Ok(b)) if id(&a) == id(&b) && b.nlink() > 0)
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_holder_at_a_time_and_no_file_after_the_last() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lock");
        // Left by a killed process.
        fs::write(&path, "").unwrap();
        let Attempt::Held(held) = LockFile::try_hold(&path) else { panic!("not held") };
        assert!(matches!(LockFile::try_hold(&path), Attempt::Busy));
        drop(held);
        assert!(!path.exists());
        assert!(matches!(LockFile::try_hold(&folder.path().join("missing/a.lock")), Attempt::Unavailable));
    }

    #[test]
    fn a_missing_file_is_made_and_one_that_is_there_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lock");
        let opened = || open(&path).unwrap().1;
        assert_eq!([opened(), opened()], [true, false]);
        assert!(open(&folder.path().join("missing/a.lock")).is_err());
    }

    #[test]
    fn threads_that_race_for_a_file_exclude_each_other() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lock");
        let (inside, rounds) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|threads| {
            for _ in 0..8 {
                threads.spawn(|| {
                    while rounds.load(Ordering::Relaxed) < 2000 {
                        if let Attempt::Held(held) = LockFile::try_hold(&path) {
                            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                            rounds.fetch_add(1, Ordering::Relaxed);
                            assert_eq!(inside.fetch_sub(1, Ordering::SeqCst), 1);
                            drop(held);
                        }
                    }
                });
            }
        });
        assert!(!path.exists());
    }
}
