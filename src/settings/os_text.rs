//! Names of files beside a word of the settings, where the names need not be Unicode.

use std::ffi::{OsStr, OsString};

use super::placeholder::os_string;

/// What stands before the ASCII character at byte `at`, and what stands after it; `None` where the latter is not Unicode.
pub(super) fn around(text: &OsStr, at: usize) -> Option<(OsString, &str)> {
    let (before, rest) = text.as_encoded_bytes().split_at_checked(at)?;
    let after = std::str::from_utf8(rest.get(1..)?).ok()?;
    Some((os_string(before.to_vec()).ok()?, after))
}

/// The text after `prefix`; `None` where it begins otherwise.
pub(super) fn without_prefix(text: &OsStr, prefix: &str) -> Option<OsString> {
    let rest = text.as_encoded_bytes().strip_prefix(prefix.as_bytes())?;
    os_string(rest.to_vec()).ok()
}
