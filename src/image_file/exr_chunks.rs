//! Check of the chunks of an OpenEXR file against its length, before a decoder allocates what their headers state.
//!
//! Source: *OpenEXR File Layout* (Academy Software Foundation): the headers are followed by a table of 64-bit offsets for each part,
//! and by the chunks. A chunk states its length; a part with chunks beyond the end of the file is damaged.

use std::io::{Read, Seek, SeekFrom};

use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::exr_error::exr_error_text;
use super::isolated::isolated;

/// Message for tables or chunks beyond the end.
const DAMAGED: &str = "it is truncated or damaged";

/// Reads the headers at the beginning of `reader`, and checks that the tables of offsets and all chunks are within it: those that
/// the tables name, and those that follow one another behind the tables. Decoders find chunks in either way.
pub(super) fn check_chunks(reader: &mut (impl Read + Seek)) -> Result<(), String> {
    let length = reader.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
    reader.rewind().map_err(|error| error.to_string())?;
    let headers =
        || MetaData::read_from_buffered(&mut *reader, false).map_err(|error| exr_error_text(&error));
    let headers = isolated(headers)?;
    let has_parts = headers.requirements.is_multilayer();
    let flat: Vec<Chunks> = headers.headers.iter().map(|header| Chunks::new(header, has_parts)).collect();

    // The tables.
    let tables = reader.stream_position().map_err(|error| error.to_string())?;
    let count: u64 = flat.iter().fold(0, |sum, chunks| sum.saturating_add(chunks.count));
    let first_chunk =
        count.checked_mul(8).and_then(|bytes| bytes.checked_add(tables)).filter(|end| *end <= length);
    let first_chunk = first_chunk.ok_or(DAMAGED)?;
    let mut file = Chunked { reader, length };
    let mut entry = tables;
    for chunks in &flat {
        for _ in 0..chunks.count {
            let start = u64::from_le_bytes(file.read_at(entry)?);
            file.end_of_chunk(start, chunks)?;
            entry += 8;
        }
    }

    // The chunks in the order of the file. Any part may come next.
    let mut start = first_chunk;
    for _ in 0..count {
        let part = if has_parts { u32::from_le_bytes(file.read_at(start)?) as usize } else { 0 };
        start = file.end_of_chunk(start, flat.get(part).ok_or(DAMAGED)?)?;
    }
    Ok(())
}

/// The chunks of one part.
struct Chunks {
    count: u64,
    /// Bytes before the length.
    before_length: u64,
    /// Chunks of deep data have two lengths, and one of the decompressed data.
    is_deep: bool,
}

impl Chunks {
    fn new(header: &Header, has_parts: bool) -> Self {
        // The number of the part, then the first row or the place of the tile.
        let coordinates = if matches!(header.blocks, BlockDescription::Tiles(_)) { 16 } else { 4 };
        let before_length = coordinates + if has_parts { 4 } else { 0 };
        Self { count: header.chunk_count as u64, before_length, is_deep: header.deep }
    }
}

/// A file and its length in bytes.
struct Chunked<'a, R> {
    reader: &'a mut R,
    length: u64,
}

impl<R: Read + Seek> Chunked<'_, R> {
    fn read_at<const N: usize>(&mut self, position: u64) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        let read =
            self.reader.seek(SeekFrom::Start(position)).and_then(|_| self.reader.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|_| DAMAGED.to_owned())
    }

    /// Position behind the chunk that begins at `start`.
    fn end_of_chunk(&mut self, start: u64, chunks: &Chunks) -> Result<u64, String> {
        let length_at = start.checked_add(chunks.before_length).ok_or(DAMAGED)?;
        let bytes = if chunks.is_deep {
            let [table, data] = [length_at, length_at.saturating_add(8)].map(|at| self.read_at(at));
            u64::from_le_bytes(table?)
                .checked_add(u64::from_le_bytes(data?))
                .and_then(|bytes| bytes.checked_add(24))
        } else {
            u64::try_from(i32::from_le_bytes(self.read_at(length_at)?)).ok().map(|bytes| bytes + 4)
        };
        let end = bytes.and_then(|bytes| length_at.checked_add(bytes)).filter(|end| *end <= self.length);
        end.ok_or_else(|| DAMAGED.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use super::*;
    use crate::error::Error;
    use crate::image::{ColorEncoding, Image};
    use crate::image_file::{ExrCompression, FrameAttributes, decode_exr, encode_exr, inspect_exr};

    fn file() -> Vec<u8> {
        let image = Image::from_rgba((40, 40), ColorEncoding::Linear, &vec![[0.5; 4]; 1600]);
        encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap()
    }

    /// Position of the first row's offset, which is the first chunk's position less those of three offsets.
    fn table(file: &[u8]) -> usize {
        (0..file.len() - 24).find(|&at| file[at..at + 8] == (at as u64 + 24).to_le_bytes()).unwrap_or(0)
    }

    fn assert_refused(file: &[u8]) {
        assert_eq!(check_chunks(&mut Cursor::new(file)), Err(DAMAGED.to_owned()));
        let decoded = decode_exr(Path::new("a.exr"), file, u64::MAX);
        assert!(matches!(decoded, Err(Error::Invalid { .. })));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, file).unwrap();
        assert!(inspect_exr(&path).is_err());
    }

    #[test]
    fn whole_files_pass() {
        assert_eq!(check_chunks(&mut Cursor::new(file())), Ok(()));
    }

    #[test]
    fn chunks_beyond_the_end_are_refused() {
        let mut file = file();
        let first_chunk = table(&file) + 24;
        file[first_chunk + 4..first_chunk + 8].copy_from_slice(&i32::MAX.to_le_bytes());
        assert_refused(&file);
    }

    #[test]
    fn windows_that_need_more_chunks_than_the_file_has_are_refused() {
        let mut file = file();
        for name in [&b"dataWindow\0"[..], b"displayWindow\0"] {
            let at = file.windows(name.len()).position(|window| window == name).unwrap();
            // Behind the name are the type and the length, then four coordinates.
            let last_row = at + name.len() + 6 + 4 + 12;
            file[last_row..last_row + 4].copy_from_slice(&9_999_999_i32.to_le_bytes());
        }
        assert_refused(&file);
    }
}
