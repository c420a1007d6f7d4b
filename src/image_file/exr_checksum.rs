//! The checksum of an EXR file: SHA-256 over all of its bytes, stored in a text attribute of its header.
//!
//! The digits of the attribute count as zeros. The checksum covers pixels, attributes and tables, and equal files have equal ones.

use std::io::{self, BufRead, Read as _, Seek, SeekFrom};

use sha2::{Digest as _, Sha256};

use crate::sha256::{hash_rest, hex};

/// Name of the attribute.
pub(super) const CHECKSUM: &str = "checksum";
/// Its value while the file is hashed.
pub(super) const ZEROS: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Magic number and version.
const START_BYTES: u64 = 8;
/// Longest name of an attribute or its type, with the zero byte after it.
const LONGEST_NAME: u64 = 256;

/// Whether an EXR file holds what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExrIntegrity {
    /// It does.
    Whole,
    /// Its bytes do not match its checksum.
    Damaged,
    /// It has no checksum: another program wrote it, or its header is damaged.
    NoChecksum,
}

/// Writes the checksum of an encoded file over the zeros of its attribute. `None` where it has no such attribute.
pub(super) fn seal(bytes: &mut [u8]) -> Option<()> {
    let at = checksum_position(&mut io::Cursor::new(&*bytes)).ok()?? as usize;
    let value = at..at + ZEROS.len();
    bytes[value.clone()].copy_from_slice(ZEROS.as_bytes());
    let digest = hex(&Sha256::digest(&*bytes));
    bytes[value].copy_from_slice(digest.as_bytes());
    Some(())
}

/// Compares a file with its checksum. Memory does not depend on its size.
///
/// # Errors
/// Those of reading.
pub fn verify_exr(file: &mut (impl BufRead + Seek)) -> io::Result<ExrIntegrity> {
    let position = checksum_position(file);
    let Some(at) = position.or_else(|error| end_of_file(error).map(|()| None))? else {
        return Ok(ExrIntegrity::NoChecksum);
    };
    file.rewind()?;
    let mut hash = Sha256::new();
    hash_rest(&mut file.by_ref().take(at), &mut hash)?;
    let mut stored = [0; ZEROS.len()];
    if let Err(error) = file.read_exact(&mut stored) {
        return end_of_file(error).map(|()| ExrIntegrity::Damaged);
    }
    hash.update(ZEROS);
    hash_rest(file, &mut hash)?;
    let is_whole = hex(&hash.finalize()).as_bytes() == stored;
    Ok(if is_whole { ExrIntegrity::Whole } else { ExrIntegrity::Damaged })
}

/// A file that ends too soon is no error of reading.
fn end_of_file(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::UnexpectedEof { Ok(()) } else { Err(error) }
}

/// The position of the checksum's digits. `None` where the header has no such attribute.
pub(super) fn checksum_position(file: &mut (impl BufRead + Seek)) -> io::Result<Option<u64>> {
    file.seek(SeekFrom::Start(START_BYTES))?;
    loop {
        let name = text(file)?;
        if name.is_empty() {
            return Ok(None);
        }
        let kind = text(file)?;
        let mut size = [0; 4];
        file.read_exact(&mut size)?;
        let size = i64::from(u32::from_le_bytes(size));
        if name == CHECKSUM.as_bytes() {
            let is_digits = kind == b"string" && size == ZEROS.len() as i64;
            return if is_digits { file.stream_position().map(Some) } else { Ok(None) };
        }
        file.seek_relative(size)?;
    }
}

/// Bytes up to the next zero, which is read, too.
fn text(file: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    file.by_ref().take(LONGEST_NAME).read_until(0, &mut text)?;
    if text.pop() == Some(0) { Ok(text) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::image::{Channel, ColorEncoding, Image, PixelWindow, RenderedScene, Samples};
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

    fn file() -> Vec<u8> {
        let window = PixelWindow::full(7, 5);
        let channel = |name: &str| Channel { name: name.to_owned(), samples: Samples::Float(vec![0.25; 35]) };
        let image = Image {
            display_window: window,
            data_window: window,
            encoding: ColorEncoding::Linear,
            channels: ["B", "G", "R"].map(channel).into(),
            scene: RenderedScene::default(),
        };
        encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap()
    }

    #[test]
    fn every_changed_bit_is_found() {
        let bytes = file();
        assert_eq!(verify_exr(&mut Cursor::new(&bytes)).unwrap(), ExrIntegrity::Whole);
        assert_eq!(file(), bytes);
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << bit;
                let found = verify_exr(&mut Cursor::new(&changed)).unwrap();
                assert_ne!(found, ExrIntegrity::Whole, "bit {bit} of byte {at}");
            }
        }
    }

    #[test]
    fn shorter_and_longer_files_are_damaged() {
        let bytes = file();
        for length in 0..bytes.len() {
            assert_ne!(
                verify_exr(&mut Cursor::new(&bytes[..length])).unwrap(),
                ExrIntegrity::Whole,
                "{length}"
            );
        }
        let longer = [&bytes[..], b"\0"].concat();
        assert_eq!(verify_exr(&mut Cursor::new(&longer)).unwrap(), ExrIntegrity::Damaged);
    }
}
