//! Hashes in PNG files: `tEXt` chunks before the end chunk (PNG specification, third edition, 11.3.3.3). All files have the `renderHash`,
//! previews also the `previewHash`.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

use super::StoredFrame;
use crate::image::PixelWindow;

/// Keyword of the hash of the render.
const RENDER_HASH: &[u8] = b"renderHash\0";
/// Keyword of the hash of a preview.
const PREVIEW_HASH: &[u8] = b"previewHash\0";
pub(super) const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// A chunk without data: length, type, check sum.
const CHUNK_OVERHEAD: usize = 12;
/// Most bytes that are kept of a chunk. Only texts are longer, which no render hash is.
const KEPT_BYTES: usize = 1 << 16;
/// Most chunks that are looked through for an animation.
const MOST_CHUNKS: usize = 1024;

/// Inserts the hash of the render before the end chunk.
pub(super) fn insert_render_hash(png: &mut Vec<u8>, render_hash: &str) {
    insert_text(png, RENDER_HASH, render_hash);
}

/// Inserts the hash of a preview, [`StoredFrame::preview_hash`], into an encoded PNG file.
pub fn insert_preview_hash(png: &mut Vec<u8>, preview_hash: &str) {
    insert_text(png, PREVIEW_HASH, preview_hash);
}

/// Inserts a text before the end chunk, the last twelve bytes of every PNG file.
fn insert_text(png: &mut Vec<u8>, keyword: &[u8], text: &str) {
    let end_chunk = png.len().saturating_sub(CHUNK_OVERHEAD);
    let mut typed = b"tEXt".to_vec();
    typed.extend_from_slice(keyword);
    typed.extend_from_slice(text.as_bytes());
    let mut chunk = ((typed.len() - 4) as u32).to_be_bytes().to_vec();
    chunk.extend_from_slice(&typed);
    chunk.extend_from_slice(&crc32fast::hash(&typed).to_be_bytes());
    png.splice(end_chunk..end_chunk, chunk);
}

/// Inspects the PNG file at `path`: all chunks must be there and undamaged. Memory does not depend on its size.
///
/// # Errors
/// One line that says what is missing or wrong.
pub fn inspect_png(path: &Path) -> Result<StoredFrame, String> {
    const DAMAGED: &str = "the file is cut short or damaged";
    let text = |error: io::Error| match error.kind() {
        io::ErrorKind::UnexpectedEof => DAMAGED.to_owned(),
        _ => error.to_string(),
    };
    let mut file = BufReader::new(File::open(path).map_err(|error| error.to_string())?);
    if !starts_with_signature(&mut file).map_err(text)? {
        return Err("not a PNG file".to_owned());
    }
    let [mut render_hash, mut preview_hash] = [None, None];
    let mut size = (0, 0);
    loop {
        let Chunk { kind, data, is_whole } = next_chunk(&mut file).map_err(text)?;
        match &kind {
            _ if !is_whole => return Err(DAMAGED.to_owned()),
            b"IHDR" if data.len() >= 8 => size = (be_u32(&data[..4]), be_u32(&data[4..8])),
            b"tEXt" => {
                for (keyword, hash) in [(RENDER_HASH, &mut render_hash), (PREVIEW_HASH, &mut preview_hash)] {
                    if let Some(value) = data.strip_prefix(keyword) {
                        *hash = String::from_utf8(value.to_vec()).ok();
                    }
                }
            }
            b"IEND" if data.is_empty() => break,
            _ => {}
        }
    }
    if !file.fill_buf().map_err(text)?.is_empty() {
        return Err("bytes follow the image".to_owned());
    }
    let data_window = PixelWindow::full(size.0, size.1).into();
    Ok(StoredFrame { render_hash, preview_hash, sample_range: None, size, data_window })
}

/// Number of frames of an animated PNG file (PNG specification, third edition, 11.3.6.1), 1 of any other. Neither pixels nor other long
/// chunks are read.
///
/// # Errors
/// Those of reading.
pub(super) fn png_frames(file: &mut (impl BufRead + Seek)) -> io::Result<u32> {
    if !starts_with_signature(file)? {
        return Ok(1);
    }
    // The chunk stands before the pixels.
    for _ in 0..MOST_CHUNKS {
        let mut head = [0; 8];
        file.read_exact(&mut head)?;
        match &head[4..] {
            b"IDAT" => return Ok(1),
            b"acTL" => {
                let Chunk { data, is_whole, .. } = next_chunk(&mut head.chain(file))?;
                return Ok(if is_whole { data.get(..4).map_or(1, be_u32) } else { 1 });
            }
            _ => file.seek_relative(i64::from(be_u32(&head[..4])) + 4)?,
        }
    }
    Ok(1)
}

fn starts_with_signature(file: &mut impl BufRead) -> io::Result<bool> {
    let mut start = Vec::new();
    file.take(SIGNATURE.len() as u64).read_to_end(&mut start)?;
    Ok(start == SIGNATURE)
}

/// Big-endian number of four bytes; 0 for any other length.
fn be_u32(bytes: &[u8]) -> u32 {
    bytes.try_into().map_or(0, u32::from_be_bytes)
}

/// A chunk of a PNG file.
struct Chunk {
    kind: [u8; 4],
    /// Its first bytes.
    data: Vec<u8>,
    /// Whether its check sum is right.
    is_whole: bool,
}

/// Reads a chunk.
fn next_chunk(file: &mut impl Read) -> io::Result<Chunk> {
    let (mut length, mut kind, mut sum) = ([0; 4], [0; 4], [0; 4]);
    file.read_exact(&mut length)?;
    file.read_exact(&mut kind)?;
    let mut crc = crc32fast::Hasher::new();
    crc.update(&kind);
    let (mut data, mut block) = (Vec::new(), [0; 8192]);
    let mut left = be_u32(&length) as usize;
    while left > 0 {
        let part = &mut block[..left.min(8192)];
        file.read_exact(part)?;
        crc.update(part);
        data.extend_from_slice(&part[..part.len().min(KEPT_BYTES - data.len())]);
        left -= part.len();
    }
    file.read_exact(&mut sum)?;
    Ok(Chunk { kind, data, is_whole: sum == crc.finalize().to_be_bytes() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_read_back_and_damaged_files_are_refused() {
        let png = crate::image_file::encode_png((2, 1), &[[255, 0, 0, 255], [0, 0, 0, 0]], "00ff");
        let mut png = png.unwrap();
        insert_preview_hash(&mut png, "aa");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, &png).unwrap();
        let stored = inspect_png(&path).unwrap();
        assert_eq!(stored.render_hash.as_deref(), Some("00ff"));
        assert_eq!(stored.preview_hash.as_deref(), Some("aa"));
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
