//! The report of a build server as a zip archive, the form in which build servers hand out artefacts.
//!
//! Archives come from other machines: nothing is unpacked to a folder, and sizes that an archive states are trusted nowhere.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::DeflateDecoder;
use rawzip::{
    CompressionMethod, FileReader, MAX_CENTRAL_DIRECTORY_RECORD_SIZE, ZipArchive, ZipArchiveEntryWayfinder,
    ZipFileHeaderRecord,
};

use super::rendered_images::is_below;
use crate::error::{Error, Result};

/// A zip archive with a report at its top, or in one folder of its top.
#[derive(Debug)]
pub(super) struct ReportArchive {
    path: PathBuf,
    archive: ZipArchive<FileReader>,
    entries: BTreeMap<String, Entry>,
    /// The folder of the report, with a slash; empty at the top.
    folder: String,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    data: ZipArchiveEntryWayfinder,
    compression: CompressionMethod,
}

impl ReportArchive {
    /// Opens an archive that has the file `list` at its top, or in one folder of its top.
    ///
    /// # Errors
    /// [`Error::Missing`] without the list, [`Error::Invalid`] for a file that is no whole archive or has two files of one name,
    /// [`Error::Unsupported`] for an encrypted one, and [`Error::Refused`] for links and names that lead out of the archive.
    pub(super) fn open(path: &Path, list: &str) -> Result<Self> {
        let file = File::open(path).map_err(Error::missing(path))?;
        let mut buffer = vec![0; MAX_CENTRAL_DIRECTORY_RECORD_SIZE];
        let archive = ZipArchive::from_file(file, &mut buffer).map_err(|_| {
            let message = format!("is no whole zip archive; name one, or the folder that has {list}");
            Error::invalid(path, "", message)
        })?;
        let entries = entries(path, &archive, &mut buffer)?;
        let folder = report_folder(path, &entries, list)?;
        Ok(Self { path: path.to_owned(), archive, entries, folder })
    }

    /// The path of a file of the report, for messages.
    pub(super) fn path_of(&self, name: &str) -> PathBuf {
        self.path.join(format!("{}{name}", self.folder))
    }

    /// The bytes of a file of the report, at most one more than `max_bytes`.
    ///
    /// # Errors
    /// [`Error::Missing`] where the archive does not have it, [`Error::Invalid`] for a damaged one, and [`Error::Unsupported`] for other
    /// compressions than Deflate.
    pub(super) fn read(&self, name: &str, max_bytes: u64) -> Result<Vec<u8>> {
        let path = self.path_of(name);
        let damaged =
            |why: &dyn std::fmt::Display| Error::invalid(&path, "", format!("the archive is damaged: {why}"));
        let Some(entry) = self.entries.get(&format!("{}{name}", self.folder)) else {
            return Err(Error::missing(&path)(std::io::ErrorKind::NotFound.into()));
        };
        let data = self.archive.get_entry(entry.data).map_err(|error| damaged(&error))?;
        let mut bytes = Vec::new();
        let most = max_bytes.saturating_add(1);
        let read = match entry.compression {
            CompressionMethod::STORE => {
                data.verifying_reader(data.reader()).take(most).read_to_end(&mut bytes)
            }
            CompressionMethod::DEFLATE => {
                let inflated = DeflateDecoder::new(data.reader());
                data.verifying_reader(inflated).take(most).read_to_end(&mut bytes)
            }
            _ => {
                let message =
                    "is compressed by another method than Deflate; unpack the archive and name its folder";
                return Err(Error::unsupported(&path, "", message));
            }
        };
        read.map(|_| bytes).map_err(|error| damaged(&error))
    }
}

/// The files of an archive by name.
fn entries(
    path: &Path,
    archive: &ZipArchive<FileReader>,
    buffer: &mut [u8],
) -> Result<BTreeMap<String, Entry>> {
    let damaged = || Error::invalid(path, "", "the archive is damaged: its table of contents is not whole");
    let mut entries = BTreeMap::new();
    let mut count = 0;
    let mut records = archive.entries(buffer);
    while let Some(record) = records.next_entry().map_err(|_| damaged())? {
        count += 1;
        let name = checked_name(path, &record)?;
        if record.is_dir() {
            continue;
        }
        let entry = Entry { data: record.wayfinder(), compression: record.compression_method() };
        if entries.insert(name.clone(), entry).is_some() {
            let message = format!("the archive has two files of the name \"{}\"", name.escape_debug());
            return Err(Error::invalid(path, "", message));
        }
    }
    if count == archive.entries_hint() { Ok(entries) } else { Err(damaged()) }
}

fn checked_name(path: &Path, record: &ZipFileHeaderRecord<'_>) -> Result<String> {
    let whole = String::from_utf8_lossy(record.file_path().as_bytes());
    let name = whole.strip_prefix("./").unwrap_or(&whole).to_owned();
    let shown = name.escape_debug();
    let is_top = name.is_empty() && record.is_dir();
    if !(is_top || is_below(&name)) || name.contains('\\') {
        return Err(Error::refused(path, "", format!("the name \"{shown}\" leaves the archive")));
    }
    if record.mode().is_symlink() {
        let message = format!("\"{shown}\" is a link; archives of reports have none");
        return Err(Error::refused(path, "", message));
    }
    if record.flags().is_encrypted() {
        let message = format!("\"{shown}\" is encrypted; unpack the archive and name its folder");
        return Err(Error::unsupported(path, "", message));
    }
    Ok(name)
}

/// The folder of the one report in the archive, with a slash; empty at the top.
fn report_folder(path: &Path, entries: &BTreeMap<String, Entry>, list: &str) -> Result<String> {
    if entries.contains_key(list) {
        return Ok(String::new());
    }
    let folder_of_list = |name: &String| {
        let folder = name.strip_suffix(list)?;
        (folder.find('/') == Some(folder.len() - 1)).then(|| folder.to_owned())
    };
    let folders: Vec<String> = entries.keys().filter_map(folder_of_list).collect();
    match folders.as_slice() {
        [folder] => Ok(folder.clone()),
        [] => {
            let why = format!("the archive has no {list} at its top or in a folder of its top");
            Err(Error::missing(path)(std::io::Error::new(std::io::ErrorKind::NotFound, why)))
        }
        [first, second, ..] => {
            let [first, second] =
                [first, second].map(|folder| folder.trim_end_matches('/').escape_debug().to_string());
            let message = format!(
                "the archive has several reports, such as {first} and {second}; unpack it and name one folder"
            );
            Err(Error::invalid(path, "", message))
        }
    }
}
