//! Files of entries: a header, then blocks, each followed by its checksum.
//!
//! ```text
//! 16 bytes  magic          32 bytes  key
//! block 0   CRC-32 of key, 0, block 0
//! block 1   CRC-32 of key, 1, block 1
//! …
//! ```
//!
//! A checksum covers the key and the number of its block, so that blocks of other entries and of other places do not match. The sizes of
//! blocks are not stored: they follow from the asset.

use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::time::SystemTime;

/// First bytes of every entry; the last one counts layouts.
pub(super) const MAGIC: [u8; 16] = *b"rayframe asset\n\x01";
/// Most bytes of a block.
pub(super) const BLOCK_BYTES: usize = 1 << 20;
const HEADER_BYTES: u64 = 48;
const CHECKSUM_BYTES: u64 = 4;

/// Length of the file of an entry with sections of these lengths, each in blocks of its own.
pub(super) fn file_bytes(sections: impl IntoIterator<Item = u64>) -> u64 {
    let bytes = |section: u64| section + section.div_ceil(BLOCK_BYTES as u64) * CHECKSUM_BYTES;
    HEADER_BYTES + sections.into_iter().map(bytes).sum::<u64>()
}

/// Whether an open file begins as entries do.
pub(super) fn has_magic(file: &mut File) -> bool {
    let mut magic = [0; 16];
    file.read_exact(&mut magic).is_ok() && magic == MAGIC
}

fn checksum(key: &[u8; 32], index: u64, block: &[u8]) -> [u8; 4] {
    let mut crc = crc32fast::Hasher::new();
    crc.update(key);
    crc.update(&index.to_le_bytes());
    crc.update(block);
    crc.finalize().to_le_bytes()
}

/// Writes the blocks of an entry.
pub(super) struct EntryWriter<'a> {
    file: &'a mut File,
    key: [u8; 32],
    next: u64,
}

impl<'a> EntryWriter<'a> {
    pub(super) fn new(file: &'a mut File, key: [u8; 32]) -> io::Result<Self> {
        file.write_all(&[&MAGIC[..], &key].concat())?;
        Ok(Self { file, key, next: 0 })
    }

    pub(super) fn block(&mut self, block: &[u8]) -> io::Result<()> {
        self.file.write_all(block)?;
        self.file.write_all(&checksum(&self.key, self.next, block))?;
        self.next += 1;
        Ok(())
    }
}

/// Reads the blocks of an entry.
pub(super) struct EntryReader {
    file: File,
    key: [u8; 32],
    next: u64,
}

impl EntryReader {
    /// Opens a regular file and counts it as used now. `None` where it is no entry of the key.
    pub(super) fn open(path: &Path, key: [u8; 32]) -> Option<Self> {
        let mut file = File::open(path).ok()?;
        let mut stored = [0; 32];
        if !has_magic(&mut file) || file.read_exact(&mut stored).is_err() || stored != key {
            return None;
        }
        // Entries of other users keep their time.
        let _ = file.set_modified(SystemTime::now());
        Some(Self { file, key, next: 0 })
    }

    /// Fills `block` with the next block. `None` where it is damaged.
    pub(super) fn block(&mut self, block: &mut [u8]) -> Option<()> {
        let mut stored = [0; 4];
        self.file.read_exact(block).ok()?;
        self.file.read_exact(&mut stored).ok()?;
        let is_whole = stored == checksum(&self.key, self.next, block);
        self.next += 1;
        is_whole.then_some(())
    }
}
