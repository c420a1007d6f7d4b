//! The report of a build server: a folder, or a zip archive of one.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::names::LIST;
use super::rendered_images::{RenderedImage, image_name_in_report, parse_list};
use super::report_archive::ReportArchive;
use crate::error::{Error, Result};

/// Largest list of images in an archive, bytes.
const MAX_LIST_BYTES: u64 = 64 << 20;

/// The report of a build server with the images that it rendered.
#[derive(Debug)]
pub struct RenderedReport {
    source: Source,
}

#[derive(Debug)]
enum Source {
    Folder(PathBuf),
    Archive(ReportArchive),
}

impl RenderedReport {
    /// Opens the folder of a report, or a zip archive of it.
    ///
    /// # Errors
    /// [`Error::Missing`] for a path where nothing is and for an archive without a report, [`Error::Invalid`] for a damaged one, and [`Error::Refused`] for one with links or
    /// with names that lead out of it.
    pub fn open(path: &Path) -> Result<Self> {
        let source = if path.metadata().map_err(Error::missing(path))?.is_file() {
            Source::Archive(ReportArchive::open(path, LIST)?)
        } else {
            Source::Folder(path.to_owned())
        };
        Ok(Self { source })
    }

    /// The images that the report lists.
    ///
    /// # Errors
    /// [`Error::Missing`] where there is no list, [`Error::Refused`] for one of more than 64 MiB, [`Error::Invalid`] for a malformed one.
    pub fn images(&self) -> Result<Vec<RenderedImage>> {
        let (path, bytes) = (self.path_of(LIST), self.read(LIST, MAX_LIST_BYTES)?);
        if bytes.len() as u64 > MAX_LIST_BYTES {
            let message = format!("has more than {} KiB, the most that it may have", MAX_LIST_BYTES / 1024);
            return Err(Error::refused(&path, "", message));
        }
        parse_list(&path, &bytes)
    }

    /// The path and the bytes of the file of an image, at most one more than `max_bytes`.
    ///
    /// # Errors
    /// [`Error::Missing`] where there is none, and for archives those of damaged files.
    pub(super) fn image(&self, name: &str, max_bytes: u64) -> Result<(PathBuf, Vec<u8>)> {
        let file = image_name_in_report(name);
        Ok((self.path_of(&file), self.read(&file, max_bytes)?))
    }

    fn path_of(&self, file: &str) -> PathBuf {
        match &self.source {
            Source::Folder(folder) => folder.join(file),
            Source::Archive(archive) => archive.path_of(file),
        }
    }

    /// At most one byte more than `max_bytes`.
    fn read(&self, file: &str, max_bytes: u64) -> Result<Vec<u8>> {
        match &self.source {
            Source::Folder(folder) => {
                let path = folder.join(file);
                if !path.metadata().map_err(Error::missing(&path))?.is_file() {
                    return Err(Error::invalid(&path, "", "is not a regular file"));
                }
                let mut bytes = Vec::new();
                let read = File::open(&path)
                    .and_then(|file| file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes));
                read.map(|_| bytes).map_err(Error::missing(&path))
            }
            Source::Archive(archive) => archive.read(file, max_bytes),
        }
    }
}
