//! Mutation of a PNG file: of one chunk, with its length and checksum, or of the order of the chunks.

use super::{MutateBytes, Random};

const MAGIC: usize = 8;
/// Length and kind before the content of a chunk, and the checksum behind it.
const HEADER: usize = 8;
const CHECKSUM: usize = 4;

/// The file with a mutated chunk; `None` if it has no chunks.
pub(crate) fn mutated(file: &[u8], random: &mut Random, mutate_bytes: MutateBytes<'_>) -> Option<Vec<u8>> {
    let (magic, rest) = file.split_at_checked(MAGIC)?;
    let mut chunks = chunks(rest);
    let (a, b) = (random.below(chunks.len()), random.below(chunks.len()));
    match random.below(8) {
        _ if chunks.is_empty() => return None,
        0 => chunks.swap(a, b),
        1 => drop(chunks.remove(a)),
        2 => chunks.insert(b, chunks[a].clone()),
        _ => mutate_bytes(&mut chunks[a]),
    }
    let mut mutated = magic.to_owned();
    for chunk in chunks {
        let content = chunk.len().saturating_sub(4);
        mutated.extend((content as u32).to_be_bytes());
        mutated.extend(&chunk);
        mutated.extend(crc32fast::hash(&chunk).to_be_bytes());
    }
    Some(mutated)
}

/// Kind and content of each chunk.
fn chunks(mut rest: &[u8]) -> Vec<Vec<u8>> {
    let mut chunks = Vec::new();
    while let Some(length) = rest.first_chunk() {
        let length = u32::from_be_bytes(*length) as usize;
        let Some((chunk, after)) = rest.split_at_checked(length.saturating_add(HEADER + CHECKSUM)) else {
            break;
        };
        chunks.push(chunk[4..HEADER + length].to_owned());
        rest = after;
    }
    chunks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_stay_right() {
        let png = rayframe::image_file::encode_png((2, 1), &[[1, 2, 3, 4], [5, 6, 7, 8]], "").unwrap();
        for seed in 0..100 {
            let mut flip = |bytes: &mut Vec<u8>| bytes[0] ^= 1;
            let file = mutated(&png, &mut Random::new(seed), &mut flip).unwrap();
            let mut rest = &file[MAGIC..];
            while !rest.is_empty() {
                let length = u32::from_be_bytes(*rest.first_chunk().unwrap()) as usize;
                let checksum = u32::from_be_bytes(*rest[HEADER + length..].first_chunk().unwrap());
                assert_eq!(crc32fast::hash(&rest[4..HEADER + length]), checksum);
                rest = &rest[HEADER + length + CHECKSUM..];
            }
        }
    }
}
