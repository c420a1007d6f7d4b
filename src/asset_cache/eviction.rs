//! The bound of a cache: entries that were used longest ago are removed until a new one fits.
//!
//! A folder may have very many entries, so that it is not read for each new one: a process counts what it stores, and reads the folder
//! when that may not fit, or when it has stored a share of the bound, since other processes store, too.

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
/// A process reads the folder again once it has stored this share of the bound. Processes that store at once may each exceed the bound by it.
const UNREAD_SHARE: u64 = 20;
/// Where entries are removed, at most this share of the bound is freed beyond what is needed, so that the next ones fit.
const FREED_SHARE: u64 = 10;

/// What a process knows of the folder.
#[derive(Debug)]
pub(super) struct Occupancy {
    /// Bytes of the entries that were there when the folder was read, and of those that were stored since; `None` where it could not
    /// be read.
    bytes: Option<u64>,
    /// Bytes that were stored since.
    unread_bytes: u64,
}

impl Occupancy {
    /// Reads a folder, and removes entries where it is larger than `max_bytes`.
    pub(super) fn read(folder: &Path, max_bytes: u64) -> Self {
        Self { bytes: trimmed(folder, max_bytes, max_bytes).ok(), unread_bytes: 0 }
    }

    /// Creates the folder, makes space for a file of `new_bytes`, and counts it; false where that would exceed `max_bytes`.
    ///
    /// # Errors
    /// Those of creating and reading the folder.
    pub(super) fn make_space(&mut self, folder: &Path, new_bytes: u64, max_bytes: u64) -> io::Result<bool> {
        fs::create_dir_all(folder)?;
        let most = max_bytes.saturating_sub(new_bytes);
        let unread_bytes = self.unread_bytes.saturating_add(new_bytes);
        let is_known = |bytes: &u64| *bytes <= most && unread_bytes <= max_bytes / UNREAD_SHARE;
        let (bytes, unread_bytes) = match self.bytes.filter(is_known) {
            Some(bytes) => (bytes, unread_bytes),
            None => (trimmed(folder, most, max_bytes)?, new_bytes),
        };
        let fits = bytes <= most;
        if fits {
            *self = Self { bytes: Some(bytes + new_bytes), unread_bytes };
        }
        Ok(fits)
    }
}

/// An entry in the folder.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Found {
    used: SystemTime,
    path: PathBuf,
    bytes: u64,
}

/// Bytes of the entries of the folder. Where they are more than `most`, entries are removed until they are not, and so many further ones as
/// a share of `max_bytes` has.
///
/// # Errors
/// Those of reading the folder.
fn trimmed(folder: &Path, most: u64, max_bytes: u64) -> io::Result<u64> {
    let mut entries = entries(folder)?;
    let mut used = entries.iter().map(|entry| entry.bytes).sum::<u64>();
    if used <= most {
        return Ok(used);
    }
    entries.sort();
    let least = most.saturating_sub(max_bytes / FREED_SHARE);
    for Found { path, bytes, .. } in entries {
        if used <= most && used.saturating_sub(bytes) < least {
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
    Ok(used)
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
