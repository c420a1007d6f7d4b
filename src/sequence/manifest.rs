//! Reading of manifests (`schema/manifest.schema.json`): the files of each frame with their hashes.

use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;
use serde::Deserialize;

use crate::error::{Error, Result, json_error_text};

/// Largest manifest, bytes: a million frames.
const MOST_BYTES: u64 = 1 << 30;

/// A file of a manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedFile {
    /// Path at the time of the run.
    pub path: PathBuf,
    /// Frame number; `None` for a file of all frames together, such as a movie.
    pub frame: Option<i64>,
    /// SHA-256 in lower-case digits. `None` where the run could not read the file.
    pub sha256: Option<String>,
}

/// What a manifest lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Manifest {
    /// The files of all frames, in order, then those of all frames together.
    pub files: Vec<ListedFile>,
    /// Frames without files, each with its status in words.
    pub not_rendered: Vec<(i64, String)>,
}

#[derive(Debug, Deserialize)]
struct ManifestFile {
    schema: u32,
    frames: Vec<ManifestFrame>,
    #[serde(default)]
    outputs: Vec<ManifestEntry>,
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

impl Manifest {
    /// Reads a manifest.
    ///
    /// # Errors
    /// [`Error::Missing`], and [`Error::Invalid`] for what is no manifest.
    pub fn read(path: &Path) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(Error::missing(path))?;
        let no_manifest = |why: &str| {
            Error::invalid(
                path,
                "",
                format!("is not a manifest{why}; name a file of rayframe render --manifest"),
            )
        };
        if !metadata.is_file() || metadata.len() > MOST_BYTES {
            return Err(no_manifest(""));
        }
        let bytes = std::fs::read(path).map_err(Error::missing(path))?;
        let manifest: ManifestFile = serde_json::from_slice(&bytes)
            .map_err(|error| no_manifest(&format!(" ({})", json_error_text(&error))))?;
        if manifest.schema != 1 {
            let message = format!(
                "is a manifest of version {}, and only 1 is known; check it with the version that wrote it",
                manifest.schema
            );
            return Err(Error::invalid(path, "/schema", message));
        }
        let mut read = Self::default();
        for ManifestFrame { frame, status, files } in manifest.frames {
            if files.is_empty() {
                read.not_rendered.push((frame, status.replace('_', " ")));
            }
            read.files.extend(files.into_iter().map(|entry| entry.listed(Some(frame))));
        }
        read.files.extend(manifest.outputs.into_iter().map(|entry| entry.listed(None)));
        Ok(read)
    }
}

impl ManifestEntry {
    fn listed(self, frame: Option<i64>) -> ListedFile {
        let sha256 = self.sha256.as_ref().map(|digits| digits.to_ascii_lowercase());
        ListedFile { path: self.file(), frame, sha256 }
    }

    #[cfg(unix)]
    fn file(&self) -> PathBuf {
        use std::os::unix::ffi::OsStringExt as _;
        match &self.path_percent {
            Some(encoded) => std::ffi::OsString::from_vec(percent_decode_str(encoded).collect()).into(),
            None => PathBuf::from(&self.path),
        }
    }

    #[cfg(not(unix))]
    fn file(&self) -> PathBuf {
        let decoded = |encoded: &str| percent_decode_str(encoded).decode_utf8_lossy().into_owned();
        self.path_percent.as_deref().map_or_else(|| self.path.clone(), decoded).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_refused_with_what_to_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.json");
        for (text, advice) in [
            ("", "; name a file of rayframe render --manifest"),
            ("[1]", "; name a file of rayframe render --manifest"),
            (r#"{"schema": 2, "frames": []}"#, "version 2, and only 1 is known; check it with the version"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = Manifest::read(&path).unwrap_err();
            assert!(error.exit_code() == 65 && error.to_string().contains(advice), "{text}: {error}");
        }
        let error = Manifest::read(folder.path()).unwrap_err().to_string();
        assert!(error.ends_with("is not a manifest; name a file of rayframe render --manifest"), "{error}");
    }
}
