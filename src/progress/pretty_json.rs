//! JSON files with lines and indents.

use serde::Serialize;

use rayframe::error::{Error, Result};

/// The text of a JSON file. Values are written one after another, so that long lists need little more memory than their text.
///
/// # Errors
/// [`Error::Internal`] is a bug.
pub(crate) fn pretty_json(value: &impl Serialize) -> Result<Vec<u8>> {
    let mut text =
        serde_json::to_vec_pretty(value).map_err(|error| Error::Internal { message: error.to_string() })?;
    text.push(b'\n');
    Ok(text)
}
