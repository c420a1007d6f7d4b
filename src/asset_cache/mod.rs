//! Cache of decoded assets in a folder: texels and mip levels of images, found by the SHA-256 of what they were decoded from.
//!
//! Any number of processes share a folder. An entry is a file that is written under a temporary name, synced and renamed, and its key
//! covers the encoded bytes, the version of the program, the layout of entries, and what was computed of the bytes. A reader
//! accepts an entry only if its header, its length and the checksum of every block match; everything else is a miss, whose entry is
//! written anew. So the cache never changes an image, and needs no lock.
//!
//! The folder is bounded: before an entry is written that would not fit, those that were used longest ago are removed. Processes that write
//! at the same time may exceed the bound a little. Failures end the use of the cache
//! for writing and never the import; [`AssetCache::write_error`] tells the first.

mod entry;
mod eviction;
#[cfg(test)]
mod tests;
mod texels;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result};
use crate::image_file::begin_replacing;
use crate::scene::AssetCacheUse;
use crate::sha256::hex;

use entry::{EntryReader, EntryWriter};
use eviction::{ENDING, Occupancy};
pub(crate) use texels::ImageShape;

/// Raised when texels or mip levels of equal files change within a version of the program.
const DECODING: u32 = 1;

/// A folder of decoded assets.
#[derive(Debug)]
pub(crate) struct AssetCache {
    folder: PathBuf,
    max_bytes: u64,
    hits: AtomicU32,
    misses: AtomicU32,
    /// What the folder holds. Locked while space is made for an entry.
    occupancy: Mutex<Occupancy>,
    /// Why the first entry that could not be written was not.
    write_error: Mutex<Option<String>>,
}

/// SHA-256 of the encoded bytes of an asset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SourceKey([u8; 32]);

impl SourceKey {
    /// The key of `bytes`.
    pub(crate) fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// The key of `what` was computed of the bytes.
    fn entry(self, what: &str) -> [u8; 32] {
        let text = format!("rayframe {} {DECODING} {what} ", env!("CARGO_PKG_VERSION"));
        Sha256::new().chain_update(text).chain_update(self.0).finalize().into()
    }
}

impl AssetCache {
    /// The cache in `folder`, whose entries take `max_bytes` at most: those beyond are removed. The folder is created when the first entry is
    /// written.
    pub(crate) fn open(folder: &Path, max_bytes: u64) -> Self {
        Self {
            folder: folder.to_owned(),
            max_bytes,
            hits: AtomicU32::new(0),
            misses: AtomicU32::new(0),
            occupancy: Mutex::new(Occupancy::read(folder, max_bytes)),
            write_error: Mutex::default(),
        }
    }

    /// How often entries were found so far.
    pub(crate) fn usage(&self) -> AssetCacheUse {
        let [hits, misses] = [&self.hits, &self.misses].map(|count| count.load(Ordering::Relaxed));
        AssetCacheUse { hits, misses }
    }

    /// Counts whether an entry was found.
    fn counted<T>(&self, found: Option<T>) -> Option<T> {
        let count = if found.is_some() { &self.hits } else { &self.misses };
        count.fetch_add(1, Ordering::Relaxed);
        found
    }

    /// Why entries could not be written, where that has happened.
    pub(crate) fn write_error(&self) -> Option<String> {
        let why = self.first_error().clone()?;
        Some(format!("the asset cache {} is not used for writing: {why}", self.folder.display()))
    }

    fn path(&self, key: &[u8; 32]) -> PathBuf {
        self.folder.join(format!("{}{ENDING}", hex(key)))
    }

    fn first_error(&self) -> MutexGuard<'_, Option<String>> {
        self.write_error.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The entry of a key, where there is one of `file_bytes`. It counts as used now.
    fn entry(&self, key: &[u8; 32], file_bytes: u64) -> Option<EntryReader> {
        let path = self.path(key);
        // Pipes and links are no entries.
        let metadata = fs::symlink_metadata(&path).ok()?;
        if !metadata.is_file() || metadata.len() != file_bytes {
            return None;
        }
        EntryReader::open(&path, *key)
    }

    /// Writes an entry of `file_bytes`.
    fn store(
        &self,
        key: &[u8; 32],
        file_bytes: u64,
        write: impl FnOnce(&mut EntryWriter<'_>) -> io::Result<()>,
    ) {
        if file_bytes > self.max_bytes || self.first_error().is_some() {
            return;
        }
        let has_space = {
            let mut occupancy = self.occupancy.lock().unwrap_or_else(PoisonError::into_inner);
            occupancy.make_space(&self.folder, file_bytes, self.max_bytes)
        };
        let stored = match has_space {
            Ok(true) => self.write(key, write).map_err(|error| error.to_string()),
            Ok(false) => return,
            Err(error) => Err(error.to_string()),
        };
        if let Err(why) = stored {
            self.first_error().get_or_insert(why);
        }
    }

    fn write(
        &self,
        key: &[u8; 32],
        write: impl FnOnce(&mut EntryWriter<'_>) -> io::Result<()>,
    ) -> Result<()> {
        let path = self.path(key);
        let mut replacement = begin_replacing(&path)?;
        let written = EntryWriter::new(replacement.file(), *key).and_then(|mut entry| write(&mut entry));
        written.map_err(|source| Error::WriteFailed { path: path.clone(), source })?;
        replacement.commit(&path)
    }
}
