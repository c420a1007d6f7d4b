//! Claims: the right of one of several runs to render a frame, and a last look at the files that are there.

use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::image_file::hidden_prefix;
use crate::lock_file::{Attempt, LockFile};

use super::plan::{existing_files, replacement_refused};
use super::{ExistingFiles, PlannedFrame, SequenceJob};

/// A frame that this run may render, until the claim is dropped.
#[derive(Debug)]
pub(super) struct FrameClaim {
    _lock: Option<LockFile>,
}

/// Result of an attempt to claim a frame.
#[derive(Debug)]
pub(super) enum Claimed {
    /// It is for this run to render.
    Here(FrameClaim),
    /// Another run renders it.
    Elsewhere,
    /// Its files are there.
    Done,
}

impl FrameClaim {
    /// Claims a frame of `job`. Only runs that resume share frames, and need a lock. Where it cannot be had, two runs may render the
    /// same frame; its files are whole nevertheless.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] for a file of something else that was made since the plan and may not be replaced.
    pub(super) fn of(job: &SequenceJob, planned: &PlannedFrame) -> Result<Claimed> {
        if planned.is_done || job.existing != ExistingFiles::Resume {
            remove_abandoned(&claim_path(planned));
        }
        if planned.is_done {
            return Ok(Claimed::Done);
        }
        if job.output.is_movie() || job.existing == ExistingFiles::Overwrite {
            return Ok(Claimed::Here(Self { _lock: None }));
        }
        let lock = match job.existing {
            ExistingFiles::Resume => match LockFile::try_hold(&claim_path(planned)) {
                Attempt::Held(lock) => Some(lock),
                Attempt::Busy => return Ok(Claimed::Elsewhere),
                Attempt::Unavailable => None,
            },
            _ => None,
        };
        // Another run may have written the frame since the plan.
        let (is_done, in_the_way) = existing_files(job, planned);
        match in_the_way {
            _ if is_done => Ok(Claimed::Done),
            Some(file) if job.existing == ExistingFiles::Protect => Err(replacement_refused(&file, 0)),
            _ => Ok(Claimed::Here(Self { _lock: lock })),
        }
    }
}

/// Removes a claim that a killed run left. One that is held stays.
fn remove_abandoned(claim: &Path) {
    if claim.exists() {
        drop(LockFile::try_hold(claim));
    }
}

fn claim_path(planned: &PlannedFrame) -> PathBuf {
    let mut name = hidden_prefix(&planned.path);
    name.push("claim");
    planned.path.with_file_name(name)
}
