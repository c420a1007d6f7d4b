//! Canonical names of files that need not exist.

use std::path::{Component, Path, PathBuf};

/// Canonical form of the file name `path`. Links are resolved as far as the folder exists.
pub fn canonical(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let mut canonical = PathBuf::new();
    for component in absolute.components() {
        match component {
            Component::ParentDir => {
                canonical.pop();
            }
            _ => canonical.push(component),
        }
        canonical = canonical.canonicalize().unwrap_or(canonical);
    }
    canonical.join(path.file_name().unwrap_or_default())
}
