//! Errors and warnings of the library, with the exit code of each kind.

use std::path::{Path, PathBuf};

use crate::cancel::Cancelled;

pub mod exit_code;
mod remedy;
mod setting;

pub use remedy::LimitRemedy;
pub use setting::{Provenance, SettingError};

/// Error that ends a command. The message is one line. [`Error::exit_code`] distinguishes permanent from retryable errors.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Invalid or conflicting settings. Exit code 2.
    #[error("{message}")]
    Usage {
        /// The problem and its remedy.
        message: String,
    },

    /// A setting is wrong. Exit code 65 where a file sets it, else 2.
    #[error(transparent)]
    Setting(#[from] SettingError),

    /// A file has invalid content. Exit code 65.
    #[error("{}: {}{message}", path.display(), pointer_prefix(pointer))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// JSON pointer (RFC 6901) of the invalid value; empty for the whole file.
        pointer: String,
        /// The problem and the valid values.
        message: String,
    },

    /// A file requires an unsupported feature, or strict mode made a warning an error. Exit code 65.
    #[error("{}: {}{message}", path.display(), pointer_prefix(pointer))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// JSON pointer of the value that requires the feature; empty for the whole file.
        pointer: String,
        /// The feature and the remedy.
        message: String,
    },

    /// A file is missing or unreadable. Exit code 66.
    #[error("{}: {}cannot be read: {source}", path.display(), pointer_prefix(pointer))]
    Missing {
        /// The unreadable file.
        path: PathBuf,
        /// JSON pointer of the reference to the file; empty for a file that a setting names.
        pointer: String,
        /// The system's error.
        source: std::io::Error,
    },

    /// A folder or sequence holds no images. Exit code 66.
    #[error("{}: {message}", path.display())]
    NoImages {
        /// The folder, or the name with a placeholder.
        path: PathBuf,
        /// What it lacks.
        message: &'static str,
    },

    /// A limit was exceeded, or a path leads outside the folder of the scene. Exit code 77.
    #[error("{}: {}{message}{}", path.display(), pointer_prefix(pointer), remedy::suffix(*remedy))]
    Refused {
        /// The file that made the request.
        path: PathBuf,
        /// JSON pointer of the value; empty for the whole file.
        pointer: String,
        /// The refused request, and the limit.
        message: String,
        /// What to do about it, where a limit can be raised.
        remedy: Option<LimitRemedy>,
    },

    /// An output cannot be created. Exit code 73.
    #[error("{}: {message}", path.display())]
    CannotCreate {
        /// The file or folder.
        path: PathBuf,
        /// The reason and the remedy.
        message: String,
    },

    /// Writing an output failed. Nothing under its final name changed. Exit code 74.
    #[error("{}: write failed: {source}", path.display())]
    WriteFailed {
        /// The output file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },

    /// A signal cancelled the work, which may be retried. Exit code 75.
    #[error(transparent)]
    Interrupted(#[from] Cancelled),

    /// The system has too little of something at the moment, such as threads. Exit code 75.
    #[error("{message}")]
    Temporary {
        /// What is short, and the remedy.
        message: String,
    },

    /// Images differ, a reference is missing, or a test failed. Exit code 1.
    #[error("{message}")]
    Different {
        /// The differences.
        message: String,
    },

    /// Bug in Rayframe: a worker panicked or an invariant does not hold. Exit code 70.
    #[error("internal error: {message}")]
    Internal {
        /// The failure.
        message: String,
    },
}

/// The text of an error in JSON with its names in double quotes. Backquotes are left to settings, which the program shows as its options.
pub fn json_error_text(error: &serde_json::Error) -> String {
    error.to_string().replace('`', "\"")
}

/// Result with an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// [`Error::Invalid`] at `pointer` of the file `path`.
    pub fn invalid(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { path: path.to_owned(), pointer: pointer.into(), message: message.into() }
    }

    /// [`Error::Unsupported`] at `pointer` of the file `path`.
    pub fn unsupported(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), pointer: pointer.into(), message: message.into() }
    }

    /// [`Error::Refused`] at `pointer` of the file `path`.
    pub fn refused(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Refused {
            path: path.to_owned(),
            pointer: pointer.into(),
            message: message.into(),
            remedy: None,
        }
    }

    /// [`Error::Refused`] of what needs more memory than `max_memory`. The text tells to raise it, or to do what `instead` says.
    pub fn over_memory(
        path: &Path,
        pointer: impl Into<String>,
        message: impl Into<String>,
        instead: Option<&'static str>,
    ) -> Self {
        let remedy = Some(LimitRemedy { instead, raise: "`max_memory`" });
        Self::Refused { path: path.to_owned(), pointer: pointer.into(), message: message.into(), remedy }
    }

    /// The same error where `raise` sets the limit that was exceeded, if this is a refusal with such a limit.
    #[must_use]
    pub fn with_limit_of(self, raise: &'static str) -> Self {
        match self {
            Self::Refused { path, pointer, message, remedy: Some(remedy) } => {
                Self::Refused { path, pointer, message, remedy: Some(LimitRemedy { raise, ..remedy }) }
            }
            error => error,
        }
    }

    /// [`Error::Usage`] with a message.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage { message: message.into() }
    }

    /// A wrong value of `setting`, wherever it was given.
    pub fn setting(setting: &str, why: impl Into<String>) -> Self {
        Self::Setting(SettingError {
            setting: setting.to_owned(),
            origin: Provenance::Library,
            why: why.into(),
        })
    }

    /// [`Error::Missing`] for a `path` that a setting names, as a function for `map_err`.
    pub fn missing(path: &Path) -> impl Fn(std::io::Error) -> Self + Copy + '_ {
        move |source| Self::Missing { path: path.to_owned(), pointer: String::new(), source }
    }

    /// [`Error::Temporary`] for threads that the system does not start.
    pub fn no_threads(error: impl std::fmt::Display) -> Self {
        let message =
            format!("the threads cannot be started: {error}; set fewer `threads`, or try again later");
        Self::Temporary { message }
    }

    /// The process exit code, after `sysexits.h`: 65 is permanent, 75 is retryable.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Different { .. } => exit_code::DIFFERENT,
            Self::Setting(SettingError { origin: Provenance::File { .. }, .. })
            | Self::Invalid { .. }
            | Self::Unsupported { .. } => exit_code::INVALID,
            Self::Usage { .. } | Self::Setting(_) => exit_code::USAGE,
            Self::Missing { .. } | Self::NoImages { .. } => exit_code::MISSING,
            Self::Internal { .. } => exit_code::INTERNAL,
            Self::CannotCreate { .. } => exit_code::CANNOT_CREATE,
            Self::WriteFailed { .. } => exit_code::WRITE_FAILED,
            Self::Interrupted(_) | Self::Temporary { .. } => exit_code::TEMPORARY,
            Self::Refused { .. } => exit_code::REFUSED,
        }
    }
}

/// Feature of the input that is not honoured. Strict mode makes it an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Warning {
    /// JSON pointer (RFC 6901) of the value that is not honoured; empty for the whole file.
    pub pointer: String,
    /// The feature and the behaviour instead.
    pub message: String,
}

impl Warning {
    /// Warning that concerns the whole file.
    pub fn of_file(message: impl Into<String>) -> Self {
        Self { pointer: String::new(), message: message.into() }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}{}", pointer_prefix(&self.pointer), self.message)
    }
}

/// Formats a number of bytes with a decimal unit, for messages.
pub(crate) fn readable_bytes(bytes: u128) -> String {
    bytes_with_decimals(bytes, 1)
}

/// Formats `1.8 GB, more than the limit of 1.0 GB`, with enough decimals to distinguish the two numbers.
pub(crate) fn over_limit(needed: u128, limit: u128) -> String {
    let both = |decimals| [needed, limit].map(|bytes| bytes_with_decimals(bytes, decimals));
    let differing = [1, 3, 5, 7, 9].into_iter().map(both).find(|[needed, limit]| needed != limit);
    let [needed, limit] = differing.unwrap_or_else(|| [needed, limit].map(whole_bytes));
    format!("{needed}, more than the limit of {limit}")
}

fn bytes_with_decimals(bytes: u128, decimals: usize) -> String {
    const UNITS: [(&str, f64); 4] = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let value = bytes as f64;
    UNITS
        .iter()
        .find(|(_, size)| value >= *size)
        .map_or_else(|| whole_bytes(bytes), |(unit, size)| format!("{:.decimals$} {unit}", value / size))
}

fn whole_bytes(bytes: u128) -> String {
    if bytes == 1 { "1 byte".to_owned() } else { format!("{bytes} bytes") }
}

fn pointer_prefix(pointer: &str) -> String {
    if pointer.is_empty() { String::new() } else { format!("{pointer}: ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_and_its_limit_are_never_printed_alike() {
        assert_eq!(over_limit(1_840_000_000, 1_000_000_000), "1.8 GB, more than the limit of 1.0 GB");
        assert_eq!(over_limit(1_004_000_000, 1_000_000_000), "1.004 GB, more than the limit of 1.000 GB");
        assert_eq!(
            over_limit(1_000_000_001, 1_000_000_000),
            "1.000000001 GB, more than the limit of 1.000000000 GB"
        );
        assert_eq!(over_limit(700, 600), "700 bytes, more than the limit of 600 bytes");
        assert_eq!(over_limit(2, 1), "2 bytes, more than the limit of 1 byte");
    }
}
