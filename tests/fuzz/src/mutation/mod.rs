//! Mutations that keep what surrounds the mutated part whole: a JSON document stays one, a container's lengths and a checksum stay
//! right. Without them most inputs end at the first check.

mod binary_scene;
mod json;
mod json_edit;
mod png_chunks;
mod random;
mod words;

use crate::targets::render::OPTION_BYTES;
use crate::targets::scene_files::{SEPARATOR, split};

pub(crate) use binary_scene::joined as joined_scene;
pub use random::Random;
pub(crate) use words::{SETTING_WORDS, WORDS};

/// How the inputs of a target are mutated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mutation {
    /// As bytes.
    Bytes,
    /// As a JSON document.
    Json,
    /// As a glTF document with resources behind it.
    JsonWithResources,
    /// As options before a glTF document.
    OptionsAndJson,
    /// As a binary glTF file.
    BinaryScene,
    /// As the chunks of a PNG file.
    PngChunks,
}

/// Mutates bytes in place, without regard to their meaning.
pub type MutateBytes<'a> = &'a mut dyn FnMut(&mut Vec<u8>);

impl Mutation {
    /// A mutation of `input`. One of eight keeps nothing whole.
    pub fn apply(self, input: &[u8], random: &mut Random, mutate_bytes: MutateBytes<'_>) -> Vec<u8> {
        let mutated = if random.one_of(8) { None } else { self.structured(input, random, mutate_bytes) };
        mutated.unwrap_or_else(|| {
            let mut bytes = input.to_owned();
            mutate_bytes(&mut bytes);
            bytes
        })
    }

    /// `None` where the input is not of this kind.
    fn structured(self, input: &[u8], random: &mut Random, mutate_bytes: MutateBytes<'_>) -> Option<Vec<u8>> {
        match self {
            Self::Bytes => None,
            Self::Json => json::mutated(input, random, mutate_bytes),
            Self::JsonWithResources => {
                let parts = split(input);
                let chosen = if random.one_of(4) { random.below(parts.len()) } else { 0 };
                let mut parts: Vec<Vec<u8>> = parts.into_iter().map(<[u8]>::to_owned).collect();
                let part = parts.get_mut(chosen)?;
                if chosen == 0 {
                    *part = json::mutated(part, random, mutate_bytes)?;
                } else {
                    mutate_bytes(part);
                }
                Some(parts.join(SEPARATOR))
            }
            Self::OptionsAndJson => {
                let (options, document) = input.split_at_checked(OPTION_BYTES)?;
                let mut options = options.to_owned();
                if random.one_of(4) {
                    let bit = random.below(8 * OPTION_BYTES);
                    options[bit / 8] ^= 1 << (bit % 8);
                    return Some([&options, document].concat());
                }
                Some([options, json::mutated(document, random, mutate_bytes)?].concat())
            }
            Self::BinaryScene => binary_scene::mutated(input, random, mutate_bytes),
            Self::PngChunks => png_chunks::mutated(input, random, mutate_bytes),
        }
    }
}
