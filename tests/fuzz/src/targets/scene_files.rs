//! Import of scene files: `.glb`, and `.gltf` with resources beside it.

use rayframe::gltf::{ImageLoading, ImportOptions, import};

use crate::scratch;
use crate::verdict::{LIBRARY_LIMIT, accepted};

/// Line between the document and the resources of an input.
pub(crate) const SEPARATOR: &[u8] = b"\n----\n";
/// Names of the resources, in the order of their parts.
pub(crate) const RESOURCES: [&str; 3] = ["a.bin", "b.png", "c.bin"];

/// Options of every import.
pub(crate) const OPTIONS: ImportOptions = ImportOptions {
    max_memory_bytes: LIBRARY_LIMIT,
    images: ImageLoading::Texels,
    allowed_folders: Vec::new(),
};

/// Imports a binary file.
pub(crate) fn glb(input: &[u8]) {
    accepted(import(&scratch::file("scene.glb", input), &OPTIONS));
}

/// Imports a text file. Parts behind separator lines are the resources.
pub(crate) fn gltf(input: &[u8]) {
    let parts = split(input);
    for (name, part) in RESOURCES.iter().zip(parts.iter().skip(1).chain(std::iter::repeat(&&[][..]))) {
        scratch::file(name, part);
    }
    let document = parts.first().copied().unwrap_or_default();
    accepted(import(&scratch::file("scene.gltf", document), &OPTIONS));
}

/// The parts between separator lines.
pub(crate) fn split(input: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = input;
    while let Some(at) = rest.windows(SEPARATOR.len()).position(|window| window == SEPARATOR) {
        parts.push(&rest[..at]);
        rest = &rest[at + SEPARATOR.len()..];
    }
    parts.push(rest);
    parts
}
