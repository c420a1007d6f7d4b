//! Reading of whole files.

use std::io::Read as _;
use std::path::Path;

use crate::error::{Error, Result, over_limit};

/// Beginning of what Git LFS leaves in place of a file that it has not fetched.
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/v1";

/// Beginning of what git-annex leaves in place of an unlocked file that it has not fetched.
const ANNEX_POINTER: &[u8] = b"/annex/objects/";

/// Pointers are smaller: those of Git LFS have less than 1 KiB, and those of git-annex the name of an object.
pub(crate) const MAX_POINTER_BYTES: u64 = 32 << 10;

/// Reads a regular file: devices and pipes may never end.
///
/// # Errors
/// [`Error::Missing`], [`Error::Invalid`] for what is no file, and [`Error::Refused`] for more than `max_bytes`.
pub fn read_regular_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let missing = Error::missing(path);
    let metadata = std::fs::metadata(path).map_err(missing)?;
    if metadata.is_dir() {
        return Err(Error::invalid(path, "", "is a folder; name a file in it"));
    }
    if !metadata.is_file() {
        return Err(Error::invalid(path, "", "is not a regular file"));
    }
    if metadata.len() > max_bytes {
        let size = over_limit(metadata.len().into(), max_bytes.into());
        return Err(Error::over_memory(path, "", format!("the file has {size}"), None));
    }
    let file = std::fs::File::open(path).map_err(missing)?;
    let mut bytes = Vec::new();
    file.take(max_bytes).read_to_end(&mut bytes).map_err(missing)?;
    Ok(bytes)
}

/// Whether `bytes` are not those of a file, but the pointer of Git LFS or git-annex to them.
pub(crate) fn is_pointer(bytes: &[u8]) -> bool {
    pointer_message(bytes).is_some()
}

/// What a pointer is and the command that fetches its file; `None` for other bytes.
fn pointer_message(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(LFS_POINTER) {
        return Some("is a Git LFS pointer, not the file itself; run git lfs pull");
    }
    let message = "is a git-annex pointer, not the file itself; run git annex get";
    bytes.starts_with(ANNEX_POINTER).then_some(message)
}

/// Refuses the pointer of a file that Git LFS or git-annex has not fetched. Every reader of scenes and images calls it, as the error of the format
/// would mislead.
///
/// # Errors
/// [`Error::Invalid`] with the command that fetches the file.
pub(crate) fn check_fetched(path: &Path, pointer: &str, bytes: &[u8]) -> Result<()> {
    match pointer_message(bytes) {
        Some(message) => Err(Error::invalid(path, pointer, message)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{plate_header, read_environment};
    use super::*;
    use crate::image::Image;

    #[test]
    fn images_that_were_not_fetched_are_named() {
        let path = Path::new("sky.exr");
        let lfs = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
        for (bytes, message) in [
            (lfs, "sky.exr: is a Git LFS pointer, not the file itself; run git lfs pull"),
            (
                "/annex/objects/SHA256E-s12345--4d7a.exr\n",
                "sky.exr: is a git-annex pointer, not the file itself; run git annex get",
            ),
        ] {
            let bytes = bytes.as_bytes();
            let errors = [
                Image::decode(path, bytes).map(drop),
                read_environment(path, bytes, 1 << 20).map(drop),
                plate_header(path, bytes, 1 << 20).map(drop),
            ];
            for error in errors.map(Result::unwrap_err) {
                assert_eq!(error.to_string(), message);
            }
        }
    }
}
