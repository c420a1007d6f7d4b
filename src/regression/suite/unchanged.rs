//! Whether a file is the one that was there when a run began.

use std::path::Path;
use std::time::SystemTime;

/// Whether `path` names the same file with the same content since `start`.
///
/// A file that is moved over another keeps its time of modification, and so does every file of a folder that is replaced; the time of
/// the last change of what was moved itself tells both.
#[cfg(unix)]
pub(super) fn is_unchanged_since(path: &Path, start: SystemTime) -> bool {
    let unchanged = || {
        let metadata = std::fs::metadata(path).ok()?;
        let written = metadata.modified().ok()?.max(last_change(&metadata)?);
        let real = path.canonicalize().ok()?;
        let named = std::path::absolute(path).ok()?;
        let is_kept = |place: &Path| is_kept_since(place, start);
        Some(written < start && named.ancestors().all(is_kept) && real.ancestors().all(is_kept))
    };
    unchanged().unwrap_or(false)
}

#[cfg(not(unix))]
pub(super) fn is_unchanged_since(path: &Path, start: SystemTime) -> bool {
    let written = std::fs::metadata(path).and_then(|metadata| metadata.modified());
    written.is_ok_and(|written| written < start)
}

/// Whether a link was not made, and a folder not moved, since `start`. A new file in a folder changes both of its times, a move only
/// that of its last change.
#[cfg(unix)]
fn is_kept_since(place: &Path, start: SystemTime) -> bool {
    let kept = || {
        let metadata = std::fs::symlink_metadata(place).ok()?;
        let changed = last_change(&metadata)?;
        let is_filled = metadata.is_dir() && changed <= metadata.modified().ok()?;
        Some(changed < start || is_filled)
    };
    kept().unwrap_or(false)
}

/// When the content, the name or the permissions of a file changed last.
#[cfg(unix)]
fn last_change(metadata: &std::fs::Metadata) -> Option<SystemTime> {
    use std::os::unix::fs::MetadataExt as _;
    let seconds = std::time::Duration::from_secs(u64::try_from(metadata.ctime()).ok()?);
    let rest = std::time::Duration::from_nanos(u64::try_from(metadata.ctime_nsec()).ok()?);
    Some(SystemTime::UNIX_EPOCH + seconds + rest)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::fs::{create_dir, rename, write};
    use std::os::unix::fs::symlink;
    use std::time::Duration;

    #[test]
    fn replaced_files_folders_and_links_are_changes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a", "b"] {
            create_dir(at(name)).unwrap();
            write(at(name).join("x.png"), name).unwrap();
        }
        symlink(at("a"), at("link")).unwrap();
        let (file, linked) = (at("a").join("x.png"), at("link").join("x.png"));
        // Times of files may be those of the last tick of the system.
        let wait = || std::thread::sleep(Duration::from_millis(30));
        let later = || {
            wait();
            let time = SystemTime::now();
            wait();
            time
        };
        let start = later();
        write(at("a").join("beside.txt"), "").unwrap();
        assert!(is_unchanged_since(&file, start) && is_unchanged_since(&linked, start));
        // Another link.
        std::fs::remove_file(at("link")).unwrap();
        symlink(at("b"), at("link")).unwrap();
        assert!(!is_unchanged_since(&linked, start) && is_unchanged_since(&file, start));
        // Another folder of that name.
        rename(at("a"), at("old")).unwrap();
        rename(at("b"), at("a")).unwrap();
        assert!(!is_unchanged_since(&file, start));
        let start = later();
        assert!(is_unchanged_since(&file, start) && is_unchanged_since(&at("old").join("x.png"), start));
        // Another file of that name, and none.
        rename(at("old").join("x.png"), &file).unwrap();
        assert!(!is_unchanged_since(&file, start) && !is_unchanged_since(&at("gone"), start));
    }
}
