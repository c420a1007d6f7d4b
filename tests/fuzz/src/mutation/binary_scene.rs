//! Mutation of a binary glTF file: of its document or its binary chunk, with right lengths around them.

use super::json;
use super::{MutateBytes, Random};

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

/// The file with a mutated chunk; `None` if it has no document.
pub(crate) fn mutated(file: &[u8], random: &mut Random, mutate_bytes: MutateBytes<'_>) -> Option<Vec<u8>> {
    let (document, rest) = chunk(file.get(HEADER..)?)?;
    let mut binary = chunk(rest).map(|(binary, _)| binary.to_owned()).unwrap_or_default();
    if random.one_of(4) {
        mutate_bytes(&mut binary);
        return Some(joined(document, &binary));
    }
    Some(joined(&json::mutated(document, random, mutate_bytes)?, &binary))
}

/// The content of the first chunk, and what follows.
fn chunk(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = u32::from_le_bytes(*bytes.first_chunk()?) as usize;
    bytes.get(CHUNK_HEADER..)?.split_at_checked(length)
}

/// A file of both chunks.
pub(crate) fn joined(document: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    for (content, kind, padding) in [(document, JSON, b' '), (binary, BIN, 0)] {
        let length = content.len().next_multiple_of(4);
        body.extend((length as u32).to_le_bytes());
        body.extend(kind.to_le_bytes());
        body.extend(content);
        body.resize(body.len() + length - content.len(), padding);
    }
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(((HEADER + body.len()) as u32).to_le_bytes());
    file.extend(body);
    file
}
