//! Reading of files by all threads.

use std::fs::File;
use std::io::{self, Read as _};

use rayon::prelude::*;

use crate::parallel_resize::resize_with;

/// Bytes of one parallel task.
const BLOCK: usize = 1 << 20;

/// Reads a file to its end into `bytes`, which is empty, but at most `limit` bytes. The first write to a page of fresh memory costs more than
/// the copy, so that all threads share large files.
pub(crate) fn read(file: &File, limit: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    if limit <= BLOCK || cfg!(not(any(unix, windows))) {
        read_by_one_thread(file, limit, bytes)
    } else {
        read_by_all_threads(file, limit, bytes)
    }
}

fn read_by_one_thread(file: &File, limit: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    file.take(limit as u64).read_to_end(bytes).map(drop)
}

fn read_by_all_threads(file: &File, limit: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    resize_with(bytes, limit, || 0);
    let blocks = bytes.par_chunks_mut(BLOCK).enumerate();
    let counts: io::Result<Vec<usize>> =
        blocks.map(|(block, bytes)| read_block(file, bytes, (block * BLOCK) as u64)).collect();
    // The file may have become shorter.
    let mut length = 0;
    for count in counts? {
        length += count;
        if count < BLOCK {
            break;
        }
    }
    bytes.truncate(length);
    Ok(())
}

/// Reads bytes from `offset`. Returns their number, which is that of `bytes` unless the file ends.
fn read_block(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<usize> {
    let mut count = 0;
    while count < bytes.len() {
        match read_at(file, &mut bytes[count..], offset + count as u64) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(count)
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, bytes, offset)
}

#[cfg(windows)]
fn read_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, bytes, offset)
}

/// Nothing reads by all threads there.
#[cfg(not(any(unix, windows)))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> io::Result<usize> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_read_what_one_reads() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        for length in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK, 3 * BLOCK + 777] {
            let content: Vec<u8> = (0..length).map(|index| (index / 3 % 251) as u8).collect();
            std::fs::write(&path, &content).unwrap();
            // At a limit below the length, at it, and where the file became shorter after its length was asked for
            for limit in [length / 2, length, length + 2 * BLOCK + 5] {
                let file = File::open(&path).unwrap();
                let mut bytes = Vec::new();
                read_by_all_threads(&file, limit, &mut bytes).unwrap();
                assert!(bytes == content[..limit.min(length)], "{length} bytes, limit {limit}");
                let mut expected = Vec::new();
                read_by_one_thread(&file, limit, &mut expected).unwrap();
                assert!(bytes == expected, "{length} bytes, limit {limit}");
            }
        }
    }

    #[test]
    fn folders_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        // Windows opens no folder.
        if let Ok(file) = File::open(folder.path()) {
            assert!(read_by_all_threads(&file, 2 * BLOCK, &mut Vec::new()).is_err());
        }
    }
}
