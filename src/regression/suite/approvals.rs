//! Approvals files, which the report page exports: the changes that a person approved.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::names::reference_path;
use super::stored_reference::is_there;
use super::{Pending, PendingKind, Suite};
use crate::error::{Error, Result, json_error_text};
use crate::image_file::read_regular_file;
use crate::regression::{Image, pixel_hash};

/// The supported version of the file format.
const SCHEMA: u32 = 1;
/// Largest accepted file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The approval of one change.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Approval {
    /// The name of the image.
    pub name: String,
    /// The hash of the approved pixels ([`pixel_hash`]). `None` approves the removal of the reference.
    // The field may be null, but not be absent.
    #[serde(deserialize_with = "Option::deserialize")]
    pub hash: Option<String>,
}

#[derive(Debug, Deserialize)]
struct ApprovalsText {
    schema: u32,
    approved: Vec<Approval>,
}

impl Approval {
    /// Whether the reference already is as approved.
    pub fn is_applied(&self, suite: &Suite) -> bool {
        let reference = reference_path(&suite.references, &self.name);
        match &self.hash {
            Some(hash) => Image::read(&reference).is_ok_and(|image| pixel_hash(&image) == *hash),
            None => !is_there(&reference),
        }
    }

    /// Why the approval does not fit a pending change; `None` when it does.
    ///
    /// # Errors
    /// Errors of reading the pending image.
    pub fn contradiction(&self, pending: &Pending) -> Result<Option<String>> {
        let why = match (&self.hash, pending.kind) {
            (None, PendingKind::Remove | PendingKind::Keep) => return Ok(None),
            (None, _) => "its removal was approved, but an image is pending",
            (Some(_), PendingKind::Remove | PendingKind::Keep) => {
                "an image was approved, but its removal is pending"
            }
            (Some(hash), _) if pixel_hash(&Image::read(&pending.file)?) == *hash => {
                return Ok(None);
            }
            (Some(_), _) => "the pending image is not the one that was approved",
        };
        Ok(Some(format!("{}: {why}; run rayframe test and look again", self.name)))
    }
}

/// Reads an approvals file. Of several approvals of one image, the last counts.
///
/// # Errors
/// [`Error::Missing`] when the file cannot be read, [`Error::Invalid`] when it is not an approvals file.
pub fn read_approvals(path: &Path) -> Result<Vec<Approval>> {
    let length = std::fs::metadata(path).map_err(Error::missing(path))?.len();
    if length > MAX_BYTES {
        return Err(Error::refused(
            path,
            "",
            "is too large for an approvals file; name the file that the report exported",
        ));
    }
    let bytes = read_regular_file(path, MAX_BYTES)?;
    let text: ApprovalsText = serde_json::from_slice(&bytes).map_err(|error| {
        Error::invalid(path, "", format!("is not an approvals file: {}", json_error_text(&error)))
    })?;
    if text.schema != SCHEMA {
        let message = format!("has schema {}; this version supports {SCHEMA}", text.schema);
        return Err(Error::invalid(path, "/schema", message));
    }
    let approvals = text.approved.into_iter().map(|approval| (approval.name.clone(), approval));
    Ok(approvals.collect::<BTreeMap<_, _>>().into_values().collect())
}
