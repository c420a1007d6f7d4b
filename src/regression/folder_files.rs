//! All files of a folder and of the folders below it. Links are followed, and cycles of them end.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// All files below `folder`, sorted, except hidden ones and those in hidden folders.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read.
pub(super) fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    sorted_files(folder, Hidden::Skipped)
}

/// All files below `folder`, sorted, hidden ones included. A folder below it that cannot be read is listed itself.
///
/// # Errors
/// [`Error::Missing`] when `folder` cannot be read.
pub fn all_files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    sorted_files(folder, Hidden::Included)
}

/// What becomes of names that start with a dot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hidden {
    Skipped,
    Included,
}

fn sorted_files(folder: &Path, hidden: Hidden) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    collect(folder, hidden, &mut Vec::new(), &mut files)?;
    files.sort();
    Ok(files)
}

/// Adds the files below `folder`. `ancestors` are the folders above it.
fn collect(
    folder: &Path,
    hidden: Hidden,
    ancestors: &mut Vec<PathBuf>,
    files: &mut Vec<PathBuf>,
) -> Result<()> {
    let directory = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let missing = Error::missing(directory);
    let itself = directory.canonicalize().map_err(missing)?;
    // A link to an ancestor.
    if ancestors.contains(&itself) {
        return Ok(());
    }
    ancestors.push(itself);
    for entry in std::fs::read_dir(directory).map_err(missing)? {
        let entry = entry.map_err(missing)?;
        if hidden == Hidden::Skipped && entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let path = folder.join(entry.file_name());
        if path.is_dir() {
            let depth = ancestors.len();
            let collected = collect(&path, hidden, ancestors, files);
            if hidden == Hidden::Skipped {
                collected?;
            } else if collected.is_err() {
                ancestors.truncate(depth);
                files.push(path);
            }
        } else {
            files.push(path);
        }
    }
    ancestors.pop();
    Ok(())
}
