//! The bound of a cache: entries that were used longest ago are removed until a new one fits.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::image_file::remove_stale_temporaries;

use super::entry::has_magic;

/// End of the names of entries, after 64 hexadecimal digits.
pub(super) const ENDING: &str = ".rayasset";
const NAME_LENGTH: usize = 64 + ENDING.len();

/// An entry in the folder.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Found {
    used: SystemTime,
    path: PathBuf,
    bytes: u64,
}

/// Creates the folder and removes entries until a file of `new_bytes` fits into `max_bytes`; false where that cannot be reached. The folder is
/// read each time, since other processes write into it.
///
/// # Errors
/// Those of creating and reading the folder.
pub(super) fn make_space(folder: &Path, new_bytes: u64, max_bytes: u64) -> io::Result<bool> {
    fs::create_dir_all(folder)?;
    let most = max_bytes.saturating_sub(new_bytes);
    Ok(removed_until(entries(folder)?, most) <= most)
}

/// Removes entries from a folder that is larger than `max_bytes`.
pub(super) fn trim(folder: &Path, max_bytes: u64) {
    if let Ok(entries) = entries(folder) {
        removed_until(entries, max_bytes);
    }
}

/// Removes entries until those that remain take `max_bytes` at most. Returns their bytes.
fn removed_until(mut entries: Vec<Found>, max_bytes: u64) -> u64 {
    entries.sort();
    let mut used = entries.iter().map(|entry| entry.bytes).sum::<u64>();
    for Found { path, bytes, .. } in entries {
        if used <= max_bytes {
            break;
        }
        let is_gone = match File::open(&path) {
            // A file of somebody else may have such a name.
            Ok(mut file) => has_magic(&mut file) && fs::remove_file(&path).is_ok(),
            // Another process removed it.
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        };
        if is_gone {
            used -= bytes;
        }
    }
    used
}

/// The entries of the folder. Removes what killed processes left of others.
fn entries(folder: &Path) -> io::Result<Vec<Found>> {
    let (mut found, mut unfinished) = (Vec::new(), Vec::new());
    for file in fs::read_dir(folder)?.flatten() {
        let name = file.file_name();
        if let Some(entry) = unfinished_entry(&name) {
            unfinished.push(folder.join(entry));
        }
        // Links are not followed.
        let Ok(metadata) = file.metadata() else { continue };
        if is_entry_name(&name) && metadata.is_file() {
            let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            found.push(Found { used, path: file.path(), bytes: metadata.len() });
        }
    }
    remove_stale_temporaries(&unfinished);
    Ok(found)
}

fn is_entry_name(name: &OsStr) -> bool {
    let is_key =
        |key: &str| key.len() == 64 && key.bytes().all(|c| c.is_ascii_digit() || (b'a'..=b'f').contains(&c));
    name.to_str().and_then(|name| name.strip_suffix(ENDING)).is_some_and(is_key)
}

/// The entry that a temporary file is made for: `.NAME.<process>.<random>.tmp`.
fn unfinished_entry(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?.strip_prefix('.')?.strip_suffix(".tmp")?.get(..NAME_LENGTH)?;
    is_entry_name(OsStr::new(name)).then_some(name)
}
