//! The `renderHash` of PNG files: a `tEXt` chunk before the end chunk (PNG specification, third edition, 11.3.3.3).

use std::path::Path;

use super::StoredFrame;
use crate::image::PixelWindow;

/// Keyword of the text chunk.
const KEYWORD: &[u8] = b"renderHash\0";
pub(super) const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// A chunk without data: length, type, check sum.
const CHUNK_OVERHEAD: usize = 12;

/// Inserts the hash before the end chunk, the last twelve bytes of every PNG file.
pub(super) fn insert_render_hash(png: &mut Vec<u8>, render_hash: &str) {
    let end_chunk = png.len().saturating_sub(CHUNK_OVERHEAD);
    let mut typed = b"tEXt".to_vec();
    typed.extend_from_slice(KEYWORD);
    typed.extend_from_slice(render_hash.as_bytes());
    let mut chunk = ((typed.len() - 4) as u32).to_be_bytes().to_vec();
    chunk.extend_from_slice(&typed);
    chunk.extend_from_slice(&crc32(&typed).to_be_bytes());
    png.splice(end_chunk..end_chunk, chunk);
}

/// Inspects the PNG file at `path`: all chunks must be there and undamaged.
///
/// # Errors
/// One line that says what is missing or wrong.
pub fn inspect_png(path: &Path) -> Result<StoredFrame, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let mut rest = bytes.strip_prefix(SIGNATURE).ok_or("not a PNG file")?;
    let mut render_hash = None;
    let mut size = (0, 0);
    loop {
        let (typed, after) = next_chunk(rest).ok_or("the file is cut short or damaged")?;
        if typed.starts_with(b"IHDR") && typed.len() >= 12 {
            size = (be_u32(&typed[4..8]), be_u32(&typed[8..12]));
        } else if let Some(value) = typed.strip_prefix(b"tEXt").and_then(|data| data.strip_prefix(KEYWORD)) {
            render_hash = String::from_utf8(value.to_vec()).ok();
        } else if typed == b"IEND" {
            if !after.is_empty() {
                return Err("bytes follow the image".to_owned());
            }
            let data_window = PixelWindow::full(size.0, size.1).into();
            return Ok(StoredFrame { render_hash, sample_range: None, size, data_window });
        }
        rest = after;
    }
}

/// Number of frames of an animated PNG file (PNG specification, third edition, 11.3.6.1), 1 of any other.
pub(super) fn png_frames(bytes: &[u8]) -> u32 {
    let mut rest = bytes.strip_prefix(SIGNATURE).unwrap_or_default();
    // The chunk stands before the pixels.
    while let Some((typed, after)) = next_chunk(rest).filter(|(typed, _)| !typed.starts_with(b"IDAT")) {
        if let Some(frames) = typed.strip_prefix(b"acTL").and_then(|data| data.get(..4)) {
            return be_u32(frames);
        }
        rest = after;
    }
    1
}

/// Big-endian number of four bytes; 0 for any other length.
fn be_u32(bytes: &[u8]) -> u32 {
    bytes.try_into().map_or(0, u32::from_be_bytes)
}

/// Type and data of the first chunk, and the bytes after it; `None` where its check sum is wrong.
fn next_chunk(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = be_u32(bytes.get(..4)?) as usize;
    let typed = bytes.get(4..length.checked_add(8)?)?;
    let sum = bytes.get(length + 8..length + CHUNK_OVERHEAD)?;
    (crc32(typed).to_be_bytes() == *sum).then(|| (typed, &bytes[length + CHUNK_OVERHEAD..]))
}

/// CRC-32 of PNG chunks (annex D), one bit at a time.
fn crc32(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for &byte in bytes {
        sum ^= u32::from(byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { 0xedb8_8320 ^ (sum >> 1) } else { sum >> 1 };
        }
    }
    !sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_sum_of_the_nine_digits() {
        // The check value that every description of CRC-32/ISO-HDLC gives.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn the_hash_is_read_back_and_damaged_files_are_refused() {
        let png = crate::image_file::encode_png((2, 1), &[[255, 0, 0, 255], [0, 0, 0, 0]], "00ff").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, &png).unwrap();
        let stored = inspect_png(&path).unwrap();
        assert_eq!(stored.render_hash.as_deref(), Some("00ff"));
        assert_eq!(stored.size, (2, 1));
        for length in [0, 8, 20, png.len() - 1] {
            std::fs::write(&path, &png[..length]).unwrap();
            assert!(inspect_png(&path).is_err());
        }
        // The `image` crate still reads the file.
        let image = image::load_from_memory(&png).unwrap().to_rgba8();
        assert_eq!(image.as_raw(), &[255, 0, 0, 255, 0, 0, 0, 0]);
    }
}
