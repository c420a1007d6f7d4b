//! The report of a build server: a folder, or a zip archive of one.

use std::path::{Path, PathBuf};

use super::rendered_images::{LIST, RenderedImage, image_name_in_report, parse_list};
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
    /// [`Error::Missing`] for an archive without a report, [`Error::Invalid`] for a damaged one, and [`Error::Refused`] for one with links or
    /// with names that lead out of it.
    pub fn open(path: &Path) -> Result<Self> {
        let source = if path.is_file() {
            Source::Archive(ReportArchive::open(path, LIST)?)
        } else {
            Source::Folder(path.to_owned())
        };
        Ok(Self { source })
    }

    /// The images that the report lists.
    ///
    /// # Errors
    /// [`Error::Missing`] where there is no list, [`Error::Invalid`] for a malformed one.
    pub fn images(&self) -> Result<Vec<RenderedImage>> {
        let bytes = self.read(LIST, MAX_LIST_BYTES)?;
        parse_list(&self.path_of(LIST), &bytes)
    }

    /// The path and the bytes of the file of an image.
    ///
    /// # Errors
    /// [`Error::Missing`] where there is none; for archives those of damaged files, and [`Error::Refused`] for a file of more than
    /// `max_bytes` bytes.
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

    fn read(&self, file: &str, max_bytes: u64) -> Result<Vec<u8>> {
        match &self.source {
            Source::Folder(folder) => {
                let path = folder.join(file);
                std::fs::read(&path).map_err(Error::missing(&path))
            }
            Source::Archive(archive) => archive.read(file, max_bytes),
        }
    }
}
