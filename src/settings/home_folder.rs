//! Paths of the home folder, which shells expand and this program does not.

use std::path::Path;

/// Refuses a path that starts with `~/`. Shells expand it at the start of a word alone, and nothing does in a shot file.
///
/// # Errors
///
/// The message for users, which says what to write instead.
pub fn check_expanded(path: &Path) -> Result<(), String> {
    match path.strip_prefix("~") {
        Ok(rest) => {
            let rest = rest.display();
            Err(format!(
                "\"~/{rest}\": no shell has expanded ~; write the full path, or ./~/{rest} for a folder of this name"
            ))
        }
        Err(_) => Ok(()),
    }
}
