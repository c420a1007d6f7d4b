//! Names that have no text, which job files cannot hold.

use rayframe::error::Error;

/// Error about a name that job files cannot hold.
pub(super) fn not_unicode(name: &str) -> Error {
    Error::usage(format!(
        "{name}: the name is not Unicode (UTF-8), which job files are written in; rename it"
    ))
}
