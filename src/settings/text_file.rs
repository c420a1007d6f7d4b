//! Settings files (shots, suites) as texts.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::error::{Error, Result, over_limit};

/// Largest file, bytes; what is larger is something else.
const MAX_BYTES: u64 = 1 << 20;

/// The text of a file.
///
/// # Errors
/// [`Error::Missing`] when it cannot be read, [`Error::Refused`] when it is too large, [`Error::Invalid`] when it is no text.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    let missing = Error::missing(path);
    if !std::fs::metadata(path).map_err(missing)?.is_file() {
        return Err(Error::invalid(path, "", "is not a regular file; name a file"));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(missing)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(missing)?;
    let length = bytes.len() as u64;
    if length > MAX_BYTES {
        let size = over_limit(length.into(), MAX_BYTES.into());
        return Err(Error::refused(path, "", format!("a file of settings has at least {size}; name a text")));
    }
    String::from_utf8(bytes).map_err(|_| Error::invalid(path, "", "is not a text in UTF-8"))
}

/// Line and column of the byte `at`, both from 1.
pub(crate) fn location(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (1 + before.matches('\n').count(), 1 + before[start..].chars().count())
}
