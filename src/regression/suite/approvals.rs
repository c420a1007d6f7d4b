//! The file that the report's tick boxes export: which changes somebody has looked at and approved.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::super::{Image, pixel_hash};
use super::names::reference_path;
use super::{Pending, PendingKind, Suite};
use crate::error::{Error, Result};

/// The form of the file that is understood.
const SCHEMA: u32 = 1;
/// Largest file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// What was approved about one picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Approval {
    /// The picture.
    pub name: String,
    /// The hash of its pixels ([`pixel_hash`]); `None` approves that its reference is removed.
    // Named so that it may be null, but not be left out.
    #[serde(deserialize_with = "Option::deserialize")]
    pub hash: Option<String>,
}

#[derive(Debug, Deserialize)]
struct ApprovalsText {
    schema: u32,
    approved: Vec<Approval>,
}

impl Approval {
    /// Whether the reference is already as it was approved.
    pub fn is_done(&self, suite: &Suite) -> bool {
        let reference = reference_path(&suite.references, &self.name);
        match &self.hash {
            Some(hash) => Image::read(&reference).is_ok_and(|picture| pixel_hash(&picture) == *hash),
            None => !reference.exists(),
        }
    }

    /// Why this is not what waits; `None` when it is.
    ///
    /// # Errors
    /// Those of reading the picture.
    pub fn contradiction(&self, pending: &Pending) -> Result<Option<String>> {
        let why = match (&self.hash, pending.kind) {
            (None, PendingKind::Remove) => return Ok(None),
            (None, _) => "its removal was approved, but a picture waits",
            (Some(_), PendingKind::Remove) => "a picture was approved, but its removal waits",
            (Some(hash), _) if pixel_hash(&Image::read(&pending.file)?) == *hash => {
                return Ok(None);
            }
            (Some(_), _) => "the picture that waits is another than the one that was approved",
        };
        Ok(Some(format!("{}: {why}; run rayframe test and look again", self.name)))
    }
}

/// Reads an approvals file; of several approvals of one picture the last counts.
///
/// # Errors
/// [`Error::Missing`] when it cannot be read, [`Error::Invalid`] when it is not one.
pub fn read_approvals(path: &Path) -> Result<Vec<Approval>> {
    let missing = Error::missing(path);
    let length = std::fs::metadata(path).map_err(missing)?.len();
    if length > MAX_BYTES {
        return Err(Error::refused(
            path,
            "",
            "is too large for a file of approvals; name what the report exported",
        ));
    }
    let bytes = std::fs::read(path).map_err(missing)?;
    let text: ApprovalsText = serde_json::from_slice(&bytes)
        .map_err(|error| Error::invalid(path, "", format!("is no file of approvals: {error}")))?;
    if text.schema != SCHEMA {
        let message = format!("has schema {}; this version understands {SCHEMA}", text.schema);
        return Err(Error::invalid(path, "/schema", message));
    }
    let approvals = text.approved.into_iter().map(|approval| (approval.name.clone(), approval));
    Ok(approvals.collect::<BTreeMap<_, _>>().into_values().collect())
}
