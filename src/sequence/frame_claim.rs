//! Claims: the right of one of several runs to render a frame, and a last look at the files that are there.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::error::{Result, Warning};
use crate::image_file::hidden_prefix;
use crate::lock_file::{Attempt, LockFile};

use super::plan::{existing_files, refuse_to_replace};
use super::{ExistingFiles, PlannedFrame, SequenceJob, frames_text};

/// Time without a finished frame after which a wait is told.
const LONG: Duration = Duration::from_secs(30);

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
        let files = existing_files(job, planned);
        if files.is_done {
            return Ok(Claimed::Done);
        }
        refuse_to_replace(files.in_the_way.as_slice(), job.existing)?;
        Ok(Claimed::Here(Self { _lock: lock }))
    }
}

/// A wait for frames that other runs have claimed.
#[derive(Debug, Default)]
pub(super) struct LongWait {
    /// Number of frames, and since when it has not changed.
    since: Option<(usize, Instant)>,
    is_told: bool,
}

impl LongWait {
    /// A warning, once, where none of the frames was finished for long: their run may hang, or a network file system may keep the locks of
    /// a machine that is gone.
    pub(super) fn warning(&mut self, frames: &[&PlannedFrame]) -> Option<Warning> {
        self.warning_at(frames, Instant::now())
    }

    fn warning_at(&mut self, frames: &[&PlannedFrame], now: Instant) -> Option<Warning> {
        let first = frames.first()?;
        let since = match self.since {
            Some((count, since)) if count == frames.len() => since,
            _ => now,
        };
        self.since = Some((frames.len(), since));
        if self.is_told || now.duration_since(since) < LONG {
            return None;
        }
        self.is_told = true;
        let numbers: Vec<_> = frames.iter().map(|planned| planned.frame).collect();
        let message = format!(
            "another run has claimed {} and finishes none; where it does not live any more, remove \"{}\"",
            frames_text(&numbers),
            claim_path(first).display()
        );
        Some(Warning::of_file(message))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_wait_is_told_once_and_begins_anew_with_every_frame() {
        let planned = |frame: i64| PlannedFrame {
            frame,
            time_seconds: 0.0,
            path: format!("out/a.{frame:04}.exr").into(),
            aov_paths: Vec::new(),
            preview_path: None,
            render_hash: String::new(),
            is_done: false,
        };
        let frames = [planned(3), planned(4)];
        let both: Vec<_> = frames.iter().collect();
        let (mut wait, start) = (LongWait::default(), Instant::now());
        assert!(wait.warning_at(&both, start).is_none());
        assert!(wait.warning_at(&both, start + LONG / 2).is_none());
        // One was finished.
        assert!(wait.warning_at(&both[..1], start + LONG).is_none());
        let told = wait.warning_at(&both[..1], start + LONG * 2).unwrap().message;
        assert!(told.contains("frame 3") && told.contains(".a.0003.exr.claim"), "{told}");
        assert!(wait.warning_at(&both[..1], start + LONG * 4).is_none());
    }
}
