//! The files that a manifest lists, and where they are now: a delivery may have been moved.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;
use serde::Deserialize;

use rayframe::error::{Error, Result};

use super::checked_file::{CheckedFile, FileStatus};

/// Largest manifest, bytes: a million frames.
const MOST_BYTES: u64 = 1 << 30;

/// A manifest as it is read.
#[derive(Debug, Deserialize)]
struct ManifestFile {
    schema: u32,
    frames: Vec<ManifestFrame>,
}

#[derive(Debug, Deserialize)]
struct ManifestFrame {
    frame: i64,
    status: String,
    files: Vec<ManifestEntry>,
}

#[derive(Debug, Deserialize)]
struct ManifestEntry {
    path: String,
    path_percent: Option<String>,
    sha256: Option<String>,
}

/// A file of a manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ListedFile {
    /// Path at the time of the run.
    pub(super) path: PathBuf,
    pub(super) frame: i64,
    /// Lower-case digits. `None` where the run could not read it.
    pub(super) sha256: Option<String>,
}

/// The files of a manifest, and frames that have none.
#[derive(Debug)]
pub(super) struct Listed {
    folder: PathBuf,
    files: Vec<ListedFile>,
    not_rendered: Vec<CheckedFile>,
}

/// Files of a manifest with their places, `None` for those that are missing.
#[derive(Debug)]
pub(super) struct Matched<'a> {
    pub(super) files: Vec<(ListedFile, Option<PathBuf>)>,
    pub(super) not_rendered: Vec<CheckedFile>,
    /// Files that are there and not listed.
    pub(super) unlisted: Vec<&'a Path>,
}

impl Listed {
    /// Reads a manifest.
    ///
    /// # Errors
    /// [`Error::Missing`], and [`Error::Invalid`] for what is no manifest.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(Error::missing(path))?;
        if !metadata.is_file() || metadata.len() > MOST_BYTES {
            return Err(Error::invalid(path, "", "is not a manifest"));
        }
        let bytes = std::fs::read(path).map_err(Error::missing(path))?;
        let manifest: ManifestFile = serde_json::from_slice(&bytes)
            .map_err(|error| Error::invalid(path, "", format!("is not a manifest: {error}")))?;
        if manifest.schema != 1 {
            let message = format!("is a manifest of version {}, and only 1 is known", manifest.schema);
            return Err(Error::invalid(path, "/schema", message));
        }
        let (mut files, mut not_rendered) = (Vec::new(), Vec::new());
        for frame in manifest.frames {
            if frame.files.is_empty() {
                let message = format!("has no files: {}", frame.status.replace('_', " "));
                let missing = CheckedFile::new(None, FileStatus::Missing, message);
                not_rendered.push(CheckedFile { frame: Some(frame.frame), ..missing });
            }
            files.extend(frame.files.into_iter().map(|entry| ListedFile {
                path: entry.file(),
                frame: frame.frame,
                sha256: entry.sha256.map(|digits| digits.to_ascii_lowercase()),
            }));
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, files, not_rendered })
    }

    /// Finds the listed files among the `given`, or, without that, where the run wrote them, or beside the manifest.
    pub(super) fn matched(self, given: Option<&[PathBuf]>) -> Matched<'_> {
        let Self { folder, files, not_rendered } = self;
        let Some(given) = given else {
            let place = |file: ListedFile| {
                let found = found(&file.path, &folder);
                (file, found)
            };
            return Matched {
                files: files.into_iter().map(place).collect(),
                not_rendered,
                unlisted: Vec::new(),
            };
        };
        let mut by_name = BTreeMap::<OsString, Vec<&Path>>::new();
        for path in given {
            by_name.entry(path.file_name().unwrap_or_default().to_owned()).or_default().push(path);
        }
        let place = |file: ListedFile| {
            let candidates = by_name.entry(file.path.file_name().unwrap_or_default().to_owned()).or_default();
            let closest = (0..candidates.len()).max_by_key(|&at| shared_end(candidates[at], &file.path));
            let found = closest.map(|at| candidates.remove(at).to_owned());
            (file, found)
        };
        let files = files.into_iter().map(place).collect();
        Matched { files, not_rendered, unlisted: by_name.into_values().flatten().collect() }
    }
}

impl ManifestEntry {
    #[cfg(unix)]
    fn file(&self) -> PathBuf {
        use std::os::unix::ffi::OsStringExt as _;
        match &self.path_percent {
            Some(encoded) => OsString::from_vec(percent_decode_str(encoded).collect()).into(),
            None => PathBuf::from(&self.path),
        }
    }

    #[cfg(not(unix))]
    fn file(&self) -> PathBuf {
        let decoded = |encoded: &str| percent_decode_str(encoded).decode_utf8_lossy().into_owned();
        self.path_percent.as_deref().map_or_else(|| self.path.clone(), decoded).into()
    }
}

/// Number of components that two paths share at their ends.
fn shared_end(a: &Path, b: &Path) -> usize {
    a.components().rev().zip(b.components().rev()).take_while(|(a, b)| a == b).count()
}

/// The file where it was written, or below the folder of the manifest under as many of its folders as are there.
fn found(path: &Path, folder: &Path) -> Option<PathBuf> {
    if path.exists() {
        return Some(path.to_owned());
    }
    let parts: Vec<_> = path.components().collect();
    let ends = (0..parts.len()).map(|start| folder.join(parts[start..].iter().collect::<PathBuf>()));
    ends.filter(|end| end.starts_with(folder)).find(|end| end.is_file())
}
