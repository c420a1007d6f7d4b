//! Errors of settings, with where the setting was given.

use std::fmt;
use std::path::PathBuf;

/// Where the value of a setting comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Provenance {
    /// An option of the command line.
    CommandLine,
    /// A definition `KEY=VALUE`, with its text.
    Define(String),
    /// A key of a shot file or a suite file.
    File {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
    },
    /// The default of the setting.
    Default,
    /// The program that uses the library.
    #[default]
    Library,
}

/// A setting with a wrong value, or a wrong key of a settings file.
///
/// The message names other settings in backquotes, such as `` `samples` ``.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// Name of the setting; empty where no known setting is concerned.
    pub setting: String,
    /// Where it was given.
    pub origin: Provenance,
    /// What is wrong, and what would be right.
    pub why: String,
}

impl fmt::Display for SettingError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.origin {
            Provenance::File { path, line, column } => {
                write!(formatter, "{}:{line}:{column}: ", path.display())?;
            }
            Provenance::Define(text) => return write!(formatter, "-D {text}: {}", self.why),
            Provenance::CommandLine | Provenance::Default | Provenance::Library => {}
        }
        match self.setting.as_str() {
            "" => write!(formatter, "{}", self.why),
            setting => write!(formatter, "{setting}: {}", self.why),
        }
    }
}

impl std::error::Error for SettingError {}
