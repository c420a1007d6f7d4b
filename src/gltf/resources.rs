//! External resources: buffers and image files in the scene's folder or in allowed ones, read and hashed for each object that names them.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread::{self, Scope, ScopedJoinHandle};

use sha2::{Digest, Sha256};

use super::container::read_regular;
use super::context::Context;
use super::document::Document;
use super::meshopt;
use super::uri::{self, Uri, UriError};
use crate::canonical_path::canonical;
use crate::error::{Error, Result, over_limit};

/// Scene files of this many bytes are hashed by a thread of their own, while they are imported.
const LARGE_FILE_BYTES: usize = 1 << 20;

/// Reads resources, and hashes everything that was read in order of the requests.
pub(super) struct Resources<'s> {
    folder: PathBuf,
    /// Canonical names of the folders whose files are read.
    allowed: Vec<PathBuf>,
    hash: Hash<'s>,
    /// Files that were read in addition to the scene file.
    pub(super) files: Vec<PathBuf>,
}

/// Hash of what was read so far.
enum Hash<'s> {
    Started(ScopedJoinHandle<'s, Sha256>),
    Known(Sha256),
}

impl<'s> Resources<'s> {
    /// Starts the hash with the scene file.
    pub(super) fn new<'e>(
        context: &Context,
        scene_bytes: &'e [u8],
        allowed_folders: &[PathBuf],
        threads: &'s Scope<'s, 'e>,
    ) -> Self {
        let parent = context.path.parent().unwrap_or(Path::new(""));
        let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        let hash_scene = move || updated(Sha256::new(), scene_bytes);
        let is_large = scene_bytes.len() >= LARGE_FILE_BYTES;
        let started = is_large.then(|| thread::Builder::new().spawn_scoped(threads, hash_scene));
        let hash = match started {
            Some(Ok(started)) => Hash::Started(started),
            _ => Hash::Known(hash_scene()),
        };
        let folders = allowed_folders.iter().map(PathBuf::as_path).chain([folder]);
        let allowed = folders.filter_map(|folder| folder.canonicalize().ok()).collect();
        Self { folder: folder.to_owned(), allowed, hash, files: Vec::new() }
    }

    /// SHA-256 over the scene file and all files read since, each preceded by its length.
    pub(super) fn finish_hash(self) -> [u8; 32] {
        self.hash.known().finalize().into()
    }

    /// Bytes of the files that were read in addition to the scene file, each counted once.
    pub(super) fn file_bytes(&self) -> u64 {
        let files: BTreeSet<&PathBuf> = self.files.iter().collect();
        let sizes = files.into_iter().filter_map(|file| std::fs::metadata(file).ok());
        sizes.fold(0, |sum, metadata| sum.saturating_add(metadata.len()))
    }

    fn add_to_hash(&mut self, bytes: &[u8]) {
        let hash = std::mem::replace(&mut self.hash, Hash::Known(Sha256::new()));
        self.hash = Hash::Known(updated(hash.known(), bytes));
    }

    /// Loads all buffers. `None` for a buffer without data, which is an error only when it is read.
    pub(super) fn load_buffers<'a>(
        &mut self,
        context: &mut Context,
        document: &Document,
        bin: Option<&'a [u8]>,
    ) -> Result<Vec<Option<Cow<'a, [u8]>>>> {
        let mut buffers = Vec::new();
        for (i, buffer) in document.root.buffers.iter().enumerate() {
            let pointer = format!("/buffers/{i}");
            let content = match (&buffer.uri, bin) {
                _ if meshopt::is_fallback(document, i) => None,
                (Some(uri), _) => Some(Cow::Owned(self.fetch(context, uri, &format!("{pointer}/uri"))?)),
                (None, Some(bin)) if i == 0 => Some(Cow::Borrowed(bin)),
                (None, _) => None,
            };
            if let Some(content) = &content {
                let promised = buffer.byte_length.0;
                if promised > content.len() as u64 {
                    let file = buffer.uri.as_deref().filter(|uri| !uri::is_data(uri));
                    let data =
                        file.map_or_else(|| "its data".to_owned(), |file| format!("the file \"{file}\""));
                    let message = format!(
                        "is {promised} bytes long, but {data} has only {}; it is truncated",
                        content.len()
                    );
                    return Err(context.invalid(format!("{pointer}/byteLength"), message));
                }
            }
            buffers.push(content);
        }
        Ok(buffers)
    }

    /// Returns the bytes that `uri` contains or refers to.
    pub(super) fn fetch(&mut self, context: &mut Context, uri: &str, pointer: &str) -> Result<Vec<u8>> {
        let used_before = context.used_bytes();
        if uri::is_data(uri) {
            context.charge(uri::most_data_bytes(uri), pointer)?;
        }
        match uri::parse(uri) {
            Ok(Uri::Data(bytes)) => {
                context.release_temporaries(used_before, bytes.len() as u64);
                Ok(bytes)
            }
            Ok(Uri::Relative(path)) => {
                let bytes = self.read_allowed(context, &path, pointer)?;
                self.files.push(self.folder.join(&path));
                self.add_to_hash(&bytes);
                Ok(bytes)
            }
            Err(UriError::Invalid(message)) => Err(context.invalid(pointer, message)),
            Err(UriError::Refused(message)) => Err(context.refused(pointer, message)),
        }
    }

    /// Reads the file `relative`. A symbolic link is followed if its target lies in an allowed folder.
    fn read_allowed(&self, context: &mut Context, relative: &Path, pointer: &str) -> Result<Vec<u8>> {
        let path = self.folder.join(relative);
        let missing = |source| Error::Missing {
            path: path.clone(),
            pointer: format!("{}#{pointer}", context.path.display()),
            source,
        };
        let is_allowed = |real: &Path| self.allowed.iter().any(|folder| real.starts_with(folder));
        match path.canonicalize() {
            Ok(real) if is_allowed(&real) => {}
            Ok(real) if is_allowed(&canonical(&path)) => {
                let message = format!("\"{}\" is a link {}", relative.display(), permitted_by(&real));
                return Err(context.refused(pointer, message));
            }
            // Elsewhere nobody learns whether there is such a file.
            Err(error) if is_allowed(&canonical(&path)) => return Err(missing(error)),
            _ => {
                let message = format!("\"{}\" leads {}", relative.display(), permitted_by(&path));
                return Err(context.refused(pointer, message));
            }
        }
        let (limit_bytes, used_bytes) = (context.remaining_bytes(), context.used_bytes());
        read_regular(context, &path, pointer, limit_bytes).map_err(|error| match error {
            Error::Missing { path, source, .. } => {
                Error::Missing { path, pointer: format!("{}#{pointer}", context.path.display()), source }
            }
            Error::Refused { .. } => {
                let length = std::fs::metadata(&path).map_or(0, |metadata| metadata.len());
                let needed = u128::from(used_bytes).saturating_add(length.into());
                let message = format!(
                    "\"{}\" and what is read before it need about {}",
                    relative.display(),
                    over_limit(needed, context.limit_bytes().into())
                );
                context.over_memory(pointer, message, None)
            }
            other => other,
        })
    }
}

/// That `path` is elsewhere, and the option that permits it.
fn permitted_by(path: &Path) -> String {
    let folder = path.parent().unwrap_or(Path::new(".")).display();
    format!(
        "outside the scene's folder; --allow-dir \"{folder}\" permits it, in suites the setting allow_dir"
    )
}

impl Hash<'_> {
    fn known(self) -> Sha256 {
        match self {
            Self::Started(thread) => thread.join().unwrap_or_else(|payload| resume_unwind(payload)),
            Self::Known(hash) => hash,
        }
    }
}

fn updated(hash: Sha256, bytes: &[u8]) -> Sha256 {
    hash.chain_update((bytes.len() as u64).to_le_bytes()).chain_update(bytes)
}
