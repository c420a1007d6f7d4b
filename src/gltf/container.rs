//! Scene file container: reads the file safely and splits a GLB into its JSON and binary chunks.

use std::fs::File;
use std::ops::Range;
use std::path::Path;

use super::context::Context;
use crate::error::{Error, Result, over_limit, readable_bytes};
use crate::image_file::check_fetched;
use crate::parallel_read;

const GLB_MAGIC: &[u8; 4] = b"glTF";
const GLB_HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BIN: u32 = u32::from_le_bytes(*b"BIN\0");
const BYTE_ORDER_MARK: &[u8] = &[0xef, 0xbb, 0xbf];

/// Largest supported scene file. Lengths inside a GLB are 32-bit.
const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// Scene file in memory, with the byte ranges of its chunks.
#[derive(Debug)]
pub(super) struct SceneFile {
    /// The whole file.
    pub(super) bytes: Vec<u8>,
    json: Range<usize>,
    bin: Option<Range<usize>>,
}

impl SceneFile {
    /// The JSON text.
    pub(super) fn json(&self) -> &[u8] {
        self.bytes.get(self.json.clone()).unwrap_or_default()
    }

    /// The binary chunk of a GLB.
    pub(super) fn bin(&self) -> Option<&[u8]> {
        self.bytes.get(self.bin.clone()?)
    }
}

/// Reads and splits the scene file of this import.
pub(super) fn read(context: &mut Context) -> Result<SceneFile> {
    let length = std::fs::metadata(context.path).map_or(0, |metadata| metadata.len());
    if length > MAX_FILE_BYTES {
        let [length, most] = [length, MAX_FILE_BYTES].map(|bytes| readable_bytes(bytes.into()));
        let message = format!(
            "the file has {length}, and a scene file has at most {most}, as a GLB states its length in 32 bits; move its data to \
             .bin files beside a .gltf file"
        );
        return Err(context.invalid("", message));
    }
    let bytes = read_regular(context, context.path, "", context.limit_bytes().min(MAX_FILE_BYTES))?;
    split(context, bytes)
}

/// Reads a regular file of at most `limit_bytes`. Pipes, devices and other special files are refused before they are
/// opened, because opening one could block.
pub(super) fn read_regular(
    context: &mut Context,
    path: &Path,
    pointer: &str,
    limit_bytes: u64,
) -> Result<Vec<u8>> {
    let missing = |source| Error::Missing { path: path.to_owned(), pointer: pointer.to_owned(), source };
    let not_regular = || Error::invalid(path, pointer, "is not a regular file; name a file");
    let metadata = std::fs::metadata(path).map_err(missing)?;
    if metadata.is_dir() {
        let scenes = path.join("*.glb");
        let example =
            if pointer.is_empty() { format!(", such as {}", scenes.display()) } else { String::new() };
        return Err(Error::invalid(path, pointer, format!("is a folder; name a file{example}")));
    }
    if !metadata.is_file() {
        return Err(not_regular());
    }
    let file = File::open(path).map_err(missing)?;
    let metadata = file.metadata().map_err(missing)?;
    if !metadata.is_file() {
        return Err(not_regular());
    }
    if metadata.len() > limit_bytes {
        let message = format!("the file has {}", over_limit(metadata.len().into(), limit_bytes.into()));
        return Err(Error::over_memory(path, pointer, message, None));
    }
    let mut bytes = context.allocate(metadata.len(), pointer)?;
    parallel_read::read(&file, metadata.len() as usize, &mut bytes).map_err(missing)?;
    check_fetched(path, pointer, &bytes)?;
    Ok(bytes)
}

/// Locates the JSON and the binary chunk of a scene file.
pub(super) fn split(context: &mut Context, bytes: Vec<u8>) -> Result<SceneFile> {
    if bytes.is_empty() {
        return Err(context.invalid("", "is empty"));
    }
    if bytes.starts_with(GLB_MAGIC) {
        return split_glb(context, bytes);
    }
    let start = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    Ok(SceneFile { json: start..bytes.len(), bin: None, bytes })
}

fn split_glb(context: &mut Context, bytes: Vec<u8>) -> Result<SceneFile> {
    let length = check_glb_header(context, &bytes)?;
    let glb = bytes.get(..length).unwrap_or_default();
    let mut json = None;
    let mut bin = None;
    let mut position = GLB_HEADER_BYTES;
    let mut follows_json = false;
    while position < glb.len() {
        let (kind, content) = chunk_at(context, glb, position)?;
        position = content.end;
        if kind == CHUNK_BIN && !follows_json {
            context
                .warn("", "the BIN chunk of the GLB is not its second chunk; other programs may ignore it");
        }
        follows_json = kind == CHUNK_JSON;
        let slot = match kind {
            CHUNK_JSON => &mut json,
            CHUNK_BIN => &mut bin,
            _ if json.is_some() => continue,
            _ => return Err(context.invalid("", "the first chunk of the GLB is not JSON")),
        };
        if slot.replace(content).is_some() {
            return Err(context.invalid("", "the GLB has two chunks of the same kind"));
        }
    }
    let Some(json) = json else {
        return Err(context.invalid("", "the GLB has no JSON chunk"));
    };
    if bin.as_ref().is_some_and(|bin| bin.start < json.start) {
        return Err(context.invalid("", "the first chunk of the GLB is not JSON"));
    }
    let json = json_text(&bytes, json);
    Ok(SceneFile { bytes, json, bin })
}

/// Range of the JSON text without a byte order mark and without the trailing zeros that some exporters write.
fn json_text(bytes: &[u8], chunk: Range<usize>) -> Range<usize> {
    let Range { mut start, mut end } = chunk;
    if bytes.get(start..end).is_some_and(|text| text.starts_with(BYTE_ORDER_MARK)) {
        start = start.saturating_add(BYTE_ORDER_MARK.len());
    }
    while end > start && bytes.get(end.saturating_sub(1)) == Some(&0) {
        end = end.saturating_sub(1);
    }
    start..end
}

/// Returns the length that the GLB header states. Bytes after it do not belong to the GLB.
fn check_glb_header(context: &mut Context, bytes: &[u8]) -> Result<usize> {
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(context.invalid("", "the GLB ends inside its header; the file is truncated"));
    };
    if version != 2 {
        return Err(context.unsupported(
            "",
            format!("is a GLB of version {version}; only version 2 is supported; export the file again"),
        ));
    }
    let length = length as usize;
    if length < bytes.len() {
        context.warn("", "the file has bytes after the end of the GLB; they are ignored");
    }
    if length > bytes.len() {
        return Err(context.invalid(
            "",
            format!(
                "the GLB header states {length} bytes, the file has {}; it is truncated or damaged",
                bytes.len()
            ),
        ));
    }
    Ok(length)
}

fn chunk_at(context: &Context, bytes: &[u8], position: usize) -> Result<(u32, Range<usize>)> {
    let truncated = || {
        context.invalid(
            "",
            format!(
                "the GLB chunk at byte {position} extends past the end; the file is truncated or damaged"
            ),
        )
    };
    let length = u32_at(bytes, position).ok_or_else(truncated)? as usize;
    let kind = u32_at(bytes, position.saturating_add(4)).ok_or_else(truncated)?;
    let start = position.saturating_add(CHUNK_HEADER_BYTES);
    let end = start.saturating_add(length);
    if end > bytes.len() {
        return Err(truncated());
    }
    Ok((kind, start..end))
}

fn u32_at(bytes: &[u8], position: usize) -> Option<u32> {
    let field = bytes.get(position..position.checked_add(4)?)?;
    Some(u32::from_le_bytes(field.try_into().ok()?))
}
