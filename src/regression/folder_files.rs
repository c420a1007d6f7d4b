//! All files of a folder and of the folders below it. Links are followed, and cycles of them end. Links among folders that links lead to are
//! followed only where nothing else leads, so that packages which link to each other are not read in every order.

use std::collections::BTreeSet;
use std::ffi::OsStr;
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
    let directory = readable(folder);
    let root = directory.canonicalize().map_err(Error::missing(directory))?;
    let mut walk = Walk { root, hidden, ancestors: Vec::new(), read: BTreeSet::new(), files: Vec::new() };
    walk.collect(folder, 0)?;
    walk.files.sort();
    Ok(walk.files)
}

/// The folder as the system takes it.
fn readable(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// A walk through the folders below one.
struct Walk {
    /// The first folder, without links.
    root: PathBuf,
    hidden: Hidden,
    /// The folders above the one being read, without links.
    ancestors: Vec<PathBuf>,
    /// All folders read so far, without links.
    read: BTreeSet<PathBuf>,
    files: Vec<PathBuf>,
}

impl Walk {
    /// Whether a folder without links is read by its own name.
    fn is_named(&self, folder: &Path) -> bool {
        let is_hidden =
            |name: &OsStr| self.hidden == Hidden::Skipped && name.to_string_lossy().starts_with('.');
        folder.strip_prefix(&self.root).is_ok_and(|below| !below.iter().any(is_hidden))
    }

    /// Adds the files below `folder`, to which so many links lead.
    fn collect(&mut self, folder: &Path, links: usize) -> Result<()> {
        let directory = readable(folder);
        let missing = Error::missing(directory);
        let itself = directory.canonicalize().map_err(missing)?;
        let is_known = links > 1 && (self.is_named(&itself) || self.read.contains(&itself));
        // A link to an ancestor, or one of many to the same folder.
        if self.ancestors.contains(&itself) || is_known {
            return Ok(());
        }
        self.read.insert(itself.clone());
        self.ancestors.push(itself);
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(directory).map_err(missing)? {
            let name = entry.map_err(missing)?.file_name();
            if self.hidden == Hidden::Included || !name.to_string_lossy().starts_with('.') {
                paths.push(folder.join(name));
            }
        }
        // The system's order differs from machine to machine.
        paths.sort();
        for path in paths {
            if !path.is_dir() {
                self.files.push(path);
                continue;
            }
            let depth = self.ancestors.len();
            let collected = self.collect(&path, links + usize::from(path.is_symlink()));
            if self.hidden == Hidden::Skipped {
                collected?;
            } else if collected.is_err() {
                self.ancestors.truncate(depth);
                self.files.push(path);
            }
        }
        self.ancestors.pop();
        Ok(())
    }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn packages_that_link_to_each_other_are_read_by_their_names_and_by_one_link() {
        let root = tempfile::tempdir().unwrap();
        let packages: Vec<_> = (0..12).map(|number| root.path().join(format!("p{number}"))).collect();
        for package in &packages {
            std::fs::create_dir_all(package.join("node_modules")).unwrap();
            std::fs::write(package.join("m.glb"), "").unwrap();
            for other in packages.iter().filter(|other| *other != package) {
                symlink(other, package.join("node_modules").join(other.file_name().unwrap())).unwrap();
            }
        }
        let files = files_below(root.path()).unwrap();
        assert_eq!(files.len(), 12 * 12);
        assert!(files.contains(&packages[3].join("m.glb")));
        assert!(files.contains(&packages[3].join("node_modules/p5/m.glb")));
    }

    #[test]
    fn hidden_folders_that_links_lead_to_are_read_once() {
        // As package managers lay them out: each package is in a hidden folder, and links to the others are beside it.
        let root = tempfile::tempdir().unwrap();
        let stored = |name: &str| root.path().join(".store").join(name);
        for name in ["a", "b"] {
            std::fs::create_dir_all(stored(name)).unwrap();
            std::fs::write(stored(name).join("m.glb"), "").unwrap();
        }
        symlink(stored("a"), root.path().join("a")).unwrap();
        symlink(stored("b"), stored("a").join("b")).unwrap();
        let expected = ["a/b/m.glb", "a/m.glb"].map(|name| root.path().join(name));
        assert_eq!(files_below(root.path()).unwrap(), expected);
    }

    #[test]
    fn folders_elsewhere_that_only_links_lead_to_are_read_once() {
        let (root, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let folder = |level: usize| elsewhere.path().join(format!("f{level}"));
        for level in 0..30 {
            std::fs::create_dir(folder(level)).unwrap();
            for link in ["a", "b"] {
                symlink(folder(level + 1), folder(level).join(link)).unwrap();
            }
        }
        std::fs::create_dir(folder(30)).unwrap();
        std::fs::write(folder(30).join("m.glb"), "").unwrap();
        symlink(folder(0), root.path().join("linked")).unwrap();
        let names = [files_below(root.path()).unwrap(), all_files_below(root.path()).unwrap()];
        let expected = root.path().join("linked").join(["a"; 30].join("/")).join("m.glb");
        assert_eq!(names, [[expected.clone()], [expected]].map(Vec::from));
    }
}
