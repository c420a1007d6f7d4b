//! The one error type: what went wrong, where, why, and what to do, each with the exit code a shell sees.

use std::path::{Path, PathBuf};

use crate::cancel::Cancelled;

/// Everything that can end a command. The message is one line; [`Error::exit_code`] tells permanent from retryable.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command line asks for something that makes no sense, or two outputs would share a name. Exit code 2.
    #[error("{message}")]
    Usage {
        /// What is wrong and what to type instead.
        message: String,
    },

    /// A file was opened and its content is wrong. Exit code 65.
    #[error("{}: {}{message}", path.display(), pointer_prefix(pointer))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// JSON pointer (RFC 6901) of the offending value; empty when the whole file is meant.
        pointer: String,
        /// What is wrong, and what would be right.
        message: String,
    },

    /// A file needs a feature that is not supported, or `--strict` turned a warning into an error. Exit code 65.
    #[error("{}: {}{message}", path.display(), pointer_prefix(pointer))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// JSON pointer of the value that asks for the feature; empty when the whole file is meant.
        pointer: String,
        /// The feature by name, and what to do.
        message: String,
    },

    /// The scene or a file it names is missing or unreadable. Exit code 66.
    #[error("{}: {}cannot be read: {source}", path.display(), pointer_prefix(pointer))]
    Missing {
        /// The file that could not be read.
        path: PathBuf,
        /// JSON pointer of the reference to it; empty when it was named on the command line.
        pointer: String,
        /// What the system said.
        source: std::io::Error,
    },

    /// A limit was reached, or a path leads outside the scene's folder. Exit code 77.
    #[error("{}: {}{message}", path.display(), pointer_prefix(pointer))]
    Refused {
        /// The file that asked for it.
        path: PathBuf,
        /// JSON pointer of the value; empty when the whole file is meant.
        pointer: String,
        /// What was refused, the limit, and how to raise it.
        message: String,
    },

    /// The output cannot be created. Exit code 73.
    #[error("{}: {message}", path.display())]
    CannotCreate {
        /// The file or folder.
        path: PathBuf,
        /// Why, and what to do.
        message: String,
    },

    /// Writing an output failed half way; nothing under its final name changed. Exit code 74.
    #[error("{}: write failed: {source}", path.display())]
    WriteFailed {
        /// The file that should have been written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },

    /// A signal stopped the work; trying again is fine. Exit code 75.
    #[error(transparent)]
    Interrupted(#[from] Cancelled),

    /// Images differ, a reference is missing, or a test failed. Exit code 1.
    #[error("{message}")]
    Different {
        /// What differs.
        message: String,
    },

    /// A bug in Rayframe: a worker panicked or an invariant does not hold. Exit code 70.
    #[error("internal error: {message}")]
    Internal {
        /// What happened.
        message: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A wrong value at `pointer` of the file `path`.
    pub fn invalid(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { path: path.to_owned(), pointer: pointer.into(), message: message.into() }
    }

    /// A feature that is not supported, asked for at `pointer` of the file `path`.
    pub fn unsupported(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), pointer: pointer.into(), message: message.into() }
    }

    /// Something refused by a limit or a safety rule, asked for at `pointer` of the file `path`.
    pub fn refused(path: &Path, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Refused { path: path.to_owned(), pointer: pointer.into(), message: message.into() }
    }

    /// A command line that makes no sense.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage { message: message.into() }
    }

    /// That `path`, which was named on the command line, cannot be read: for `map_err`.
    pub fn missing(path: &Path) -> impl Fn(std::io::Error) -> Self + Copy + '_ {
        move |source| Self::Missing { path: path.to_owned(), pointer: String::new(), source }
    }

    /// The process exit code, after `sysexits.h`: 65 is permanent, 75 is worth another try.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Different { .. } => 1,
            Self::Usage { .. } => 2,
            Self::Invalid { .. } | Self::Unsupported { .. } => 65,
            Self::Missing { .. } => 66,
            Self::Internal { .. } => 70,
            Self::CannotCreate { .. } => 73,
            Self::WriteFailed { .. } => 74,
            Self::Interrupted(_) => 75,
            Self::Refused { .. } => 77,
        }
    }
}

/// Something in the input that is not honoured, named once for the user. `--strict` makes it an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Warning {
    /// JSON pointer (RFC 6901) of the value that is not honoured; empty when the whole file is meant.
    pub pointer: String,
    /// What is not honoured and what happens instead.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}{}", pointer_prefix(&self.pointer), self.message)
    }
}

/// `bytes` with a decimal unit, for messages.
pub(crate) fn readable_bytes(bytes: u128) -> String {
    bytes_with_decimals(bytes, 1)
}

/// `1.8 GB, more than the limit of 1.0 GB`, with as many decimals as tell the two apart.
pub(crate) fn over_limit(needed: u128, limit: u128) -> String {
    let both = |decimals| [needed, limit].map(|bytes| bytes_with_decimals(bytes, decimals));
    let differing = [1, 3, 5, 7, 9].into_iter().map(both).find(|[needed, limit]| needed != limit);
    let [needed, limit] = differing.unwrap_or_else(|| [needed, limit].map(|bytes| format!("{bytes} bytes")));
    format!("{needed}, more than the limit of {limit}")
}

fn bytes_with_decimals(bytes: u128, decimals: usize) -> String {
    const UNITS: [(&str, f64); 4] = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let value = bytes as f64;
    UNITS.iter().find(|(_, size)| value >= *size).map_or_else(
        || format!("{bytes} bytes"),
        |(unit, size)| format!("{:.decimals$} {unit}", value / size),
    )
}

fn pointer_prefix(pointer: &str) -> String {
    if pointer.is_empty() { String::new() } else { format!("{pointer}: ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_need_never_reads_like_its_limit() {
        assert_eq!(over_limit(1_840_000_000, 1_000_000_000), "1.8 GB, more than the limit of 1.0 GB");
        assert_eq!(over_limit(1_004_000_000, 1_000_000_000), "1.004 GB, more than the limit of 1.000 GB");
        assert_eq!(
            over_limit(1_000_000_001, 1_000_000_000),
            "1.000000001 GB, more than the limit of 1.000000000 GB"
        );
        assert_eq!(over_limit(700, 600), "700 bytes, more than the limit of 600 bytes");
    }
}
