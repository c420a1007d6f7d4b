//! Whether one file is whole.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use rayframe::image_file::{
    ExrIntegrity, OutputKind, inspect_exr, inspect_png, is_output, saved_by, verify_exr,
};
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
        let by_itself = ByItself::of(path);
        if matches!(by_itself, ByItself::Unknown) && is_output(path, OutputKind::Manifest) {
            return unknown("is a manifest; --manifest checks the files that it lists".to_owned());
        }
        return by_itself.verdict();
    };
    match sha256_of_file(path) {
        Err(error) => unreadable(&error),
        Ok(actual) if actual == sha256 => (FileStatus::Whole, String::new()),
        Ok(_) => match ByItself::of(path) {
            ByItself::Whole => {
                (FileStatus::Different, "is whole, and not the file that the manifest lists".to_owned())
            }
            ByItself::Foreign { program, .. } => {
                unknown(format!("its bytes do not match the manifest: {program} has saved it since"))
            }
            ByItself::Unknown => (FileStatus::Damaged, "its bytes do not match the manifest".to_owned()),
            other => other.verdict(),
        },
    }
}

/// What a file itself says.
enum ByItself {
    Whole,
    Damaged(String),
    Unreadable(io::Error),
    /// Another program wrote it, or has saved it since it was rendered and copied the checksum.
    Foreign {
        program: String,
        has_checksum: bool,
    },
    /// Nothing.
    Unknown,
}

impl ByItself {
    /// By the checksum of EXR files, and those of the chunks of PNG files.
    fn of(path: &Path) -> Self {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if extension == OsStr::new("png") || extension == OsStr::new("apng") {
            return inspect_png(path).map_or_else(Self::Damaged, |_| Self::Whole);
        }
        if extension != OsStr::new("exr") {
            return Self::Unknown;
        }
        match File::open(path).and_then(|file| verify_exr(&mut BufReader::new(file))) {
            Err(error) => Self::Unreadable(error),
            Ok(ExrIntegrity::Whole) => Self::Whole,
            Ok(ExrIntegrity::Damaged) => match saved_by(path) {
                None => Self::Damaged("its bytes do not match its checksum".to_owned()),
                Some(program) => Self::Foreign { program, has_checksum: true },
            },
            Ok(ExrIntegrity::NoChecksum) => inspect_exr(path).map_or_else(Self::Damaged, |_| {
                let program = saved_by(path).unwrap_or_else(|| "another program".to_owned());
                Self::Foreign { program, has_checksum: false }
            }),
        }
    }

    /// The status without a manifest, and a message.
    fn verdict(self) -> (FileStatus, String) {
        match self {
            Self::Whole => (FileStatus::Whole, String::new()),
            Self::Damaged(why) => (FileStatus::Damaged, format!("is damaged: {why}")),
            Self::Unreadable(error) => unreadable(&error),
            Self::Foreign { program, has_checksum: true } => {
                unknown(format!("its checksum is out of date: {program} has saved it since"))
            }
            Self::Foreign { program, has_checksum: false } => {
                unknown(format!("has no checksum: {program} wrote it"))
            }
            Self::Unknown => {
                unknown("is no EXR or PNG file; only a manifest tells whether it is whole".to_owned())
            }
        }
    }
}

fn unknown(message: String) -> (FileStatus, String) {
    (FileStatus::Unknown, message)
}

fn unreadable(error: &io::Error) -> (FileStatus, String) {
    (FileStatus::Unreadable, format!("cannot be read: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_are_told_from_other_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.json");
        let manifest = r#"{"complete": true, "frames": [], "schema": 1, "software": "rayframe 0.1.0"}"#;
        for (text, words) in
            [(manifest, "--manifest checks the files that it lists"), ("{}", "is no EXR or PNG")]
        {
            std::fs::write(&path, text).unwrap();
            let (status, message) = of_file(&path, None);
            assert!(status == FileStatus::Unknown && message.contains(words), "{message}");
        }
    }
}
