//! Paths in JSON that are not Unicode.

use std::path::Path;

use percent_encoding::{NON_ALPHANUMERIC, percent_encode};
use serde_json::{Value, json};

/// Adds the percent-encoded path as `key` where it is not Unicode.
pub(super) fn add_percent_path(line: &mut Value, key: &str, path: &Path) {
    if path.to_str().is_none() {
        let bytes = path.as_os_str().as_encoded_bytes();
        line[key] = json!(percent_encode(bytes, NON_ALPHANUMERIC).to_string());
    }
}
