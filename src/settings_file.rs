//! Files of settings (shots, suites) as texts: reading them, and saying where in them something is wrong.

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

/// The line in which the byte `at` lies, from 1.
pub(crate) fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

/// That the text of `path` is no TOML, or has not the form that is expected, with the line.
pub(crate) fn not_toml(path: &Path, text: &str, error: &toml::de::Error) -> Error {
    let line = error.span().map_or(1, |span| line_of(text, span.start));
    let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
    Error::invalid(path, "", format!("line {line}: {message}"))
}
