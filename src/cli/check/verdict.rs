//! Whether one file is whole.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use rayframe::image_file::{ExrIntegrity, inspect_exr, inspect_png, saved_by, verify_exr};
use rayframe::sequence::{ListedFile, sha256_of_file};

use super::checked_file::FileStatus;

/// The status of the file at `path`, and a message. `listed` is its entry in the manifest.
pub(super) fn of_file(path: &Path, listed: Option<&ListedFile>) -> (FileStatus, String) {
    match std::fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return (FileStatus::Missing, "is not there".to_owned());
        }
        Err(error) => return unreadable(&error),
        // Devices and pipes may never end.
        Ok(metadata) if !metadata.is_file() => {
            return (FileStatus::Unreadable, "is not a regular file".to_owned());
        }
        Ok(_) => {}
    }
    let Some(sha256) = listed.and_then(|file| file.sha256.as_deref()) else {
        return by_its_checksum(path);
    };
    match sha256_of_file(path) {
        Err(error) => unreadable(&error),
        Ok(actual) if actual == sha256 => (FileStatus::Whole, String::new()),
        Ok(_) => match by_its_checksum(path) {
            (FileStatus::Whole, _) => {
                (FileStatus::Different, "is whole, and not the file that the manifest lists".to_owned())
            }
            (FileStatus::Unknown, _) => {
                (FileStatus::Damaged, "its bytes do not match the manifest".to_owned())
            }
            other => other,
        },
    }
}

/// The status by what the file itself says: the checksum of EXR files, and those of the chunks of PNG files.
fn by_its_checksum(path: &Path) -> (FileStatus, String) {
    let damaged = |why: String| (FileStatus::Damaged, format!("is damaged: {why}"));
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == OsStr::new("png") || extension == OsStr::new("apng") {
        return match inspect_png(path) {
            Ok(_) => (FileStatus::Whole, String::new()),
            Err(why) => damaged(why),
        };
    }
    if extension != OsStr::new("exr") {
        return unknown("is no EXR or PNG file; only a manifest tells whether it is whole");
    }
    match File::open(path).and_then(|file| verify_exr(&mut BufReader::new(file))) {
        Err(error) => unreadable(&error),
        Ok(ExrIntegrity::Whole) => (FileStatus::Whole, String::new()),
        Ok(ExrIntegrity::Damaged) => match saved_by(path) {
            None => damaged("its bytes do not match its checksum".to_owned()),
            Some(program) => unknown(&format!("its checksum is out of date: {program} has saved it since")),
        },
        Ok(ExrIntegrity::NoChecksum) => match inspect_exr(path) {
            Err(why) => damaged(why),
            Ok(_) => unknown("has no checksum: another program wrote it"),
        },
    }
}

fn unknown(message: &str) -> (FileStatus, String) {
    (FileStatus::Unknown, message.to_owned())
}

fn unreadable(error: &io::Error) -> (FileStatus, String) {
    (FileStatus::Unreadable, format!("cannot be read: {error}"))
}
