//! Reading of whole files.

use std::io::Read as _;
use std::path::Path;

use crate::error::{Error, Result, over_limit};

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
        return Err(Error::refused(path, "", format!("the file has {size}; raise `max_memory`")));
    }
    let file = std::fs::File::open(path).map_err(missing)?;
    let mut bytes = Vec::new();
    file.take(max_bytes).read_to_end(&mut bytes).map_err(missing)?;
    Ok(bytes)
}
