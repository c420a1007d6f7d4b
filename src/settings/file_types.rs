//! The types of settings that name files.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::camera_path_source::CameraPathSource;
use super::environment_source::{BackgroundSource, EnvironmentSource};
use super::home_folder::check_expanded;
use super::output_pattern::OutputPattern;
use super::placeholder::{check_placeholders, escaped_folder};
use super::plate_pattern;
use super::setting_type::{SettingType, ValueForm};

/// A path of at least one character.
fn path(text: &OsStr) -> Result<PathBuf, String> {
    if text.is_empty() {
        return Err("is empty; write a path".to_owned());
    }
    check_expanded(Path::new(text))?;
    Ok(PathBuf::from(text))
}

/// File.
#[derive(Debug)]
pub struct FilePath;

impl SettingType for FilePath {
    type Value = PathBuf;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<PathBuf, String> {
        path(text)
    }

    fn write(value: &PathBuf) -> Vec<OsString> {
        vec![value.clone().into_os_string()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        joined(folder, text)
    }
}

/// Folders that add up.
#[derive(Debug)]
pub struct Folders;

impl SettingType for Folders {
    type Value = Vec<PathBuf>;
    const FORM: ValueForm = ValueForm { is_repeated: true, ..ValueForm::TEXT };

    fn parse(text: &OsStr) -> Result<Vec<PathBuf>, String> {
        Ok(vec![path(text)?])
    }

    fn write(value: &Vec<PathBuf>) -> Vec<OsString> {
        value.iter().map(OsString::from).collect()
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        joined(folder, text)
    }

    fn add(earlier: &mut Vec<PathBuf>, later: Vec<PathBuf>) {
        earlier.extend(later);
    }
}

/// File with placeholders for the names of the scene, the shot file, the clip and the camera.
#[derive(Debug)]
pub struct NamedFile;

impl SettingType for NamedFile {
    type Value = PathBuf;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<PathBuf, String> {
        check_placeholders(Path::new(text))?;
        path(text)
    }

    fn write(value: &PathBuf) -> Vec<OsString> {
        vec![value.clone().into_os_string()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        if Path::new(&text).is_absolute() { text } else { joined(&escaped_folder(folder), text) }
    }
}

/// Output name with a place for the frame number.
#[derive(Debug)]
pub struct Pattern;

impl SettingType for Pattern {
    type Value = OutputPattern;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<OutputPattern, String> {
        OutputPattern::parse(text)
    }

    fn write(value: &OutputPattern) -> Vec<OsString> {
        vec![value.to_text()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        if Path::new(&text).is_absolute() {
            return text;
        }
        joined(Path::new(&OutputPattern::escaped(folder)), text)
    }
}

/// Environment.
#[derive(Debug)]
pub struct EnvironmentType;

impl SettingType for EnvironmentType {
    type Value = EnvironmentSource;
    const FORM: ValueForm = ValueForm::TEXT.or_list(",");

    fn parse(text: &OsStr) -> Result<EnvironmentSource, String> {
        check_expanded(Path::new(text))?;
        EnvironmentSource::parse(text)
    }

    fn write(value: &EnvironmentSource) -> Vec<OsString> {
        vec![value.to_text()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        rebased_source(text, folder)
    }
}

/// Background.
#[derive(Debug)]
pub struct BackgroundType;

impl SettingType for BackgroundType {
    type Value = BackgroundSource;
    const FORM: ValueForm = ValueForm::TEXT.or_list(",");

    fn parse(text: &OsStr) -> Result<BackgroundSource, String> {
        check_expanded(Path::new(text))?;
        BackgroundSource::parse(text)
    }

    fn write(value: &BackgroundSource) -> Vec<OsString> {
        vec![value.to_text()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        plate_pattern::rebased(&text, folder).unwrap_or_else(|| rebased_source(text, folder))
    }
}

/// Camera path.
#[derive(Debug)]
pub struct CameraPathType;

impl SettingType for CameraPathType {
    type Value = CameraPathSource;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<CameraPathSource, String> {
        check_expanded(Path::new(text))?;
        CameraPathSource::parse(text)
    }

    fn write(value: &CameraPathSource) -> Vec<OsString> {
        vec![value.to_text()]
    }

    fn rebase(text: OsString, folder: &Path) -> OsString {
        joined(folder, text)
    }
}

/// The path below `folder`, unless parsing refuses it.
fn joined(folder: &Path, text: OsString) -> OsString {
    let is_refused = text.is_empty() || Path::new(&text).starts_with("~");
    if is_refused { text } else { folder.join(text).into_os_string() }
}

fn rebased_source(text: OsString, folder: &Path) -> OsString {
    let is_file = match BackgroundSource::parse(&text) {
        // A name without a known ending may still be that of a file, and so may one with a place for the frame.
        Ok(BackgroundSource::Plate(_)) | Err(_) => folder.join(&text).is_file(),
        Ok(source) => matches!(source, BackgroundSource::Environment(EnvironmentSource::File(..))),
    };
    if is_file { joined(folder, text) } else { text }
}
