//! Shots whose files changed since a revision of a git repository.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::covered_jobs::{ShotFiles, files_of};
use super::filter::Filter;
use super::names::{ReferenceFile, reference_files, reference_path};
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};

/// The shots of which an input or a reference differs since the working tree and `revision` had a common commit, and those of which an
/// image has no reference, such as scenes whose shot file is gone. Files that git does not track count as changed. A changed
/// suite file selects all shots, and so does each shot that cannot be read.
///
/// # Errors
/// [`Error::Usage`] without git, outside of a repository, and for an unknown revision.
pub(super) fn changed_shots(suite: &Suite, shots: Vec<SuiteShot>, revision: &str) -> Result<Vec<SuiteShot>> {
    let changes = changed_files(&suite.file, revision)?;
    if changes.contains(&suite.file) {
        return Ok(shots);
    }
    let files = reference_files(suite)?;
    let references = files.iter().filter(|file| matches!(file, ReferenceFile::Reference(_)));
    let is_changed = |name: &str| changes.contains(&reference_path(&suite.references, name));
    let (changed, unchanged): (BTreeSet<_>, BTreeSet<_>) =
        references.map(ReferenceFile::name).partition(|name| is_changed(name));
    let filter = Filter::all(&shots);
    // Also those of a shot that does not render them any more.
    let with_changes: BTreeSet<&str> = changed.iter().filter_map(|name| filter.owner(name)).collect();
    let has_changed = |shot: &SuiteShot| {
        with_changes.contains(&*shot.name)
            || changes.contains(&shot.path)
            || files_of(suite, shot).map_or(true, |ShotFiles { images, inputs }| {
                inputs.iter().any(|input| changes.contains(input))
                    || images.iter().any(|image| !unchanged.contains(image.as_str()))
            })
    };
    let selected: Vec<bool> = shots.iter().map(has_changed).collect();
    Ok(shots
        .into_iter()
        .zip(selected)
        .filter_map(|(shot, is_selected)| is_selected.then_some(shot))
        .collect())
}

/// What git says of files.
struct Changes {
    /// Canonical path of the repository.
    root: PathBuf,
    /// Canonical paths of files that differ from the commit, and of those that git does not know.
    changed: BTreeSet<PathBuf>,
    /// Canonical paths of files that git tracks.
    tracked: BTreeSet<PathBuf>,
}

impl Changes {
    /// Whether a file differs, or a link on the way to it. Files that git does not track may differ.
    fn contains(&self, path: &Path) -> bool {
        let named = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let is_changed_link = |link: &Path| {
            let folder = link.parent().and_then(|folder| folder.canonicalize().ok());
            let Some(path) = folder.zip(link.file_name()).map(|(folder, name)| folder.join(name)) else {
                return true;
            };
            self.changed.contains(&path) || path.starts_with(&self.root) && !self.tracked.contains(&path)
        };
        let has_changed_link = || named.ancestors().any(|part| part.is_symlink() && is_changed_link(part));
        path.canonicalize().map_or(true, |path| self.changed.contains(&path) || !self.tracked.contains(&path))
            || has_changed_link()
    }
}

/// The files that differ from the commit, and those that git does not know.
fn changed_files(suite: &Path, revision: &str) -> Result<Changes> {
    let folder = suite.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let top = git(folder, &["rev-parse", "--show-toplevel"])?;
    let top = path_of(top.strip_suffix(b"\n").unwrap_or(&top));
    let commit = format!("{revision}^{{commit}}");
    let commit = text(
        &git(&top, &["rev-parse", "--verify", "--quiet", "--end-of-options", &commit]).map_err(|_| {
            Error::usage(format!(
                "--changed-since: \"{}\" is no commit of the repository; fetch it, or name another",
                revision.escape_debug()
            ))
        })?,
    );
    // Shallow clones may have no common commit.
    let base = git(&top, &["merge-base", &commit, "HEAD"]).map_or(commit, |base| text(&base));
    let differing = git(
        &top,
        &[
            "diff",
            "--name-only",
            "--no-renames",
            "--no-ext-diff",
            "--ignore-submodules=none",
            "-z",
            &base,
            "--",
        ],
    )?;
    let unknown = git(&top, &["ls-files", "--others", "--exclude-standard", "-z"])?;
    let tracked = git(&top, &["ls-files", "-z"])?;
    let root = top.canonicalize().unwrap_or(top);
    let paths = |list: &[u8]| {
        let names = list.split(|byte| *byte == 0).filter(|name| !name.is_empty());
        names.map(|name| root.join(path_of(name))).collect::<BTreeSet<_>>()
    };
    let changed = paths(&differing).into_iter().chain(paths(&unknown)).collect();
    let tracked = paths(&tracked);
    Ok(Changes { root, changed, tracked })
}

/// What git prints.
fn git(folder: &Path, arguments: &[&str]) -> Result<Vec<u8>> {
    let mut command = Command::new("git");
    // Hooks of git set these for their own repository.
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        command.env_remove(name);
    }
    let output = command.arg("-C").arg(folder).args(arguments).output();
    let output = output.map_err(|error| Error::usage(format!("--changed-since needs git: {error}")))?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let message = String::from_utf8_lossy(&output.stderr);
    let message = message.lines().next().unwrap_or("git failed").to_owned();
    Err(Error::usage(format!("--changed-since: {message}")))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_end().to_owned()
}

#[cfg(unix)]
fn path_of(name: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStrExt as _;
    std::ffi::OsStr::from_bytes(name).into()
}

#[cfg(not(unix))]
fn path_of(name: &[u8]) -> PathBuf {
    String::from_utf8_lossy(name).into_owned().into()
}
