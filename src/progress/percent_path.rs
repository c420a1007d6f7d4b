//! Paths in JSON that are not Unicode.

use std::path::Path;

use percent_encoding::{NON_ALPHANUMERIC, percent_encode};
use serde_json::{Value, json};

/// Adds the percent-encoded path as `key` where it is not Unicode.
pub(super) fn add_percent_path(line: &mut Value, key: &str, path: &Path) {
    if let Some(encoded) = percent_path(path) {
        line[key] = json!(encoded);
    }
}

/// The percent-encoded path where it is not Unicode.
pub(super) fn percent_path(path: &Path) -> Option<String> {
    let bytes = path.as_os_str().as_encoded_bytes();
    path.to_str().is_none().then(|| percent_encode(bytes, NON_ALPHANUMERIC).to_string())
}
