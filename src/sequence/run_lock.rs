//! Exclusion of runs that would write the same frames.
//!
//! Every run holds a record beside its output while it renders: a hidden file with its process, frames and settings, under a lock
//! that ends with the process. A new run reads the records that are held. Runs of other frames of a sequence, such as the chunks of a
//! farm, and equal runs that resume may go on beside it; any other run of the same frames is refused. Records that nobody holds were
//! left by killed runs and are removed. A second lock makes registrations wait for each other.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{hidden_prefix, process_mark};
use crate::lock_file::{Attempt, LockFile};
use crate::output::{host_name, universal_time_now};

use super::render_hash::run_hash;
use super::{ExistingFiles, FrameSpec, Plan, SequenceJob, frames_text};

/// Longest wait for another registration, which takes milliseconds.
const MOST_WAIT: Duration = Duration::from_secs(30);
/// Pause between two attempts.
const NAP: Duration = Duration::from_millis(5);
/// End of the names of records.
const RECORD_ENDING: &str = ".run";

/// The right of a run to write its frames, until it is dropped or the process ends.
#[derive(Debug)]
pub struct RunLock {
    _record: LockFile,
}

/// What other runs read about a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct RunRecord {
    process: u32,
    host: Option<String>,
    /// Date and time, UTC.
    since: String,
    /// The frames in the form of `frames`; `None` where all are in one file.
    frames: Option<String>,
    /// Whether equal runs may share the frames.
    shares: bool,
    /// Hash of everything that the frames are made from.
    hash: String,
}

impl RunLock {
    /// Registers a run of `plan`, whose folders must exist ([`Plan::prepare`]). `None` where the file system has no locks: there, runs
    /// do not exclude each other, and every file is whole nevertheless.
    ///
    /// # Errors
    /// [`Error::Temporary`] with the run that renders some of these frames, and where one did since the plan; [`Error::Interrupted`].
    pub fn acquire(job: &SequenceJob, plan: &Plan, cancel: &CancelFlag) -> Result<Option<Self>> {
        let path = job.output.common_path();
        let own = RunRecord::new(job, plan);
        let Some(_registration) = wait_for_registration(&path, cancel)? else { return Ok(None) };
        for other in running(&path) {
            let message = match other {
                Other::Running(other) if own.excludes(&other) => own.refusal(&other, &job.output.shown()),
                Other::Running(_) => continue,
                Other::Unknown(record) => format!(
                    "{}: {} says that another run renders there, and cannot be read; wait for its end, or remove the file if there is none",
                    job.output.shown(),
                    record.display()
                ),
            };
            return Err(Error::Temporary { message });
        }
        if !plan.is_current() {
            let message = format!(
                "{}: another run has changed files while this one started; start it again",
                job.output.shown()
            );
            return Err(Error::Temporary { message });
        }
        Ok(own.hold(&path).map(|record| Self { _record: record }))
    }
}

impl RunRecord {
    fn new(job: &SequenceJob, plan: &Plan) -> Self {
        let frames: Vec<_> = plan.frames.iter().map(|planned| planned.frame).collect();
        let is_movie = job.output.is_movie();
        Self {
            process: std::process::id(),
            host: host_name(),
            since: universal_time_now(),
            frames: job.output.is_numbered().then(|| frame_list(&frames)),
            shares: job.existing == ExistingFiles::Resume && !is_movie,
            hash: run_hash(job),
        }
    }

    /// Whether this run cannot go on while the other does.
    fn excludes(&self, other: &Self) -> bool {
        let is_shared = self.shares && other.shares && self.hash == other.hash;
        !is_shared && self.has_frame_of(other)
    }

    fn has_frame_of(&self, other: &Self) -> bool {
        match (listed(self.frames.as_deref()), listed(other.frames.as_deref())) {
            (Some(own), Some(others)) => !own.is_disjoint(&others),
            // All frames are in one file, or the other list cannot be read.
            _ => true,
        }
    }

    fn refusal(&self, other: &Self, output: &str) -> String {
        let host = other.host.as_ref().map(|host| format!(" on {host}")).unwrap_or_default();
        let plural = |frames: &str| if frames.parse::<i64>().is_ok() { "frame" } else { "frames" };
        let frames = other
            .frames
            .as_ref()
            .map(|frames| format!("{} {frames} of ", plural(frames)))
            .unwrap_or_default();
        let remedy = if self.hash == other.hash {
            "wait for its end, or run both with `resume` to share the frames"
        } else {
            "it is another scene or has other settings; wait for its end, or choose another name"
        };
        let RunRecord { process, since, .. } = other;
        format!("{output}: process {process}{host} has been rendering {frames}it since {since} UTC; {remedy}")
    }

    /// Holds the record beside `path`. A record that cannot be written excludes no other run.
    fn hold(&self, path: &Path) -> Option<LockFile> {
        static HELD: AtomicU32 = AtomicU32::new(0);
        let number = HELD.fetch_add(1, Ordering::Relaxed);
        let mut name = hidden_prefix(path);
        name.push(format!("{}-{number}{RECORD_ENDING}", process_mark()));
        let Attempt::Held(record) = LockFile::try_hold(&path.with_file_name(name)) else { return None };
        let text = serde_json::to_vec(self).unwrap_or_default();
        // Other machines read it from the file server.
        let write = |mut file: &File| {
            file.set_len(0).and_then(|()| file.write_all(&text)).and_then(|()| file.sync_all())
        };
        let _ = write(record.file());
        Some(record)
    }
}

/// Frames as `-f` takes them.
fn frame_list(frames: &[i64]) -> String {
    let text = frames_text(frames);
    text.trim_start_matches("frames ").trim_start_matches("frame ").to_owned()
}

fn listed(frames: Option<&str>) -> Option<BTreeSet<i64>> {
    match FrameSpec::parse(frames?) {
        Ok(FrameSpec::Listed(frames)) => Some(frames.into_iter().collect()),
        _ => None,
    }
}

/// The lock under which a run registers; `None` where there are no locks.
fn wait_for_registration(path: &Path, cancel: &CancelFlag) -> Result<Option<LockFile>> {
    let mut name = hidden_prefix(path);
    name.push("lock");
    let lock = path.with_file_name(name);
    let start = Instant::now();
    while start.elapsed() < MOST_WAIT {
        cancel.check()?;
        match LockFile::try_hold(&lock) {
            Attempt::Held(lock) => return Ok(Some(lock)),
            Attempt::Unavailable => return Ok(None),
            Attempt::Busy => thread::sleep(NAP),
        }
    }
    let message =
        format!("{}: another run has held this lock for long; try again, or end it", lock.display());
    Err(Error::Temporary { message })
}

/// Another run.
enum Other {
    /// One that is still going on.
    Running(RunRecord),
    /// One whose record cannot be read or tried.
    Unknown(PathBuf),
}

/// The runs beside `path` that are still going on, or may be. Records of ended ones are removed.
fn running(path: &Path) -> Vec<Other> {
    let prefix = hidden_prefix(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let Ok(entries) = fs::read_dir(folder.unwrap_or(Path::new("."))) else { return Vec::new() };
    let records = entries.flatten().filter(|entry| is_record(&entry.file_name(), &prefix));
    let records = records.map(|entry| entry.path());
    records.filter_map(|record| state_of(&record)).collect()
}

fn state_of(record: &Path) -> Option<Other> {
    match LockFile::try_hold(record) {
        // A killed run left it. It is removed when it is dropped.
        Attempt::Held(_) => return None,
        // Without locks of regions, what is locked on Windows cannot be read.
        Attempt::Busy if cfg!(windows) => return None,
        Attempt::Busy => {}
        Attempt::Unavailable => return record.exists().then(|| Other::Unknown(record.to_owned())),
    }
    match fs::read(record) {
        // It has ended meanwhile.
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        read => Some(match read.ok().and_then(|text| serde_json::from_slice(&text).ok()) {
            Some(other) => Other::Running(other),
            None => Other::Unknown(record.to_owned()),
        }),
    }
}

fn is_record(name: &OsString, prefix: &OsString) -> bool {
    let name = name.as_encoded_bytes();
    name.starts_with(prefix.as_encoded_bytes()) && name.ends_with(RECORD_ENDING.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(frames: Option<&str>, shares: bool, hash: &str) -> RunRecord {
        RunRecord {
            process: 4711,
            host: Some("render07".to_owned()),
            since: "2026-11-23 21:00:11".to_owned(),
            frames: frames.map(str::to_owned),
            shares,
            hash: hash.to_owned(),
        }
    }

    #[test]
    fn runs_of_the_same_frames_exclude_each_other() {
        let excludes = |a: &RunRecord, b: &RunRecord| {
            assert_eq!(a.excludes(b), b.excludes(a), "{a:?} {b:?}");
            a.excludes(b)
        };
        let frames = |frames| record(Some(frames), false, "a");
        assert!(excludes(&frames("1-10"), &frames("10-20")));
        assert!(excludes(&frames("1-10"), &frames("7")));
        assert!(!excludes(&frames("1-10"), &frames("11-20")), "chunks of a farm");
        assert!(!excludes(&frames("1-9x2"), &frames("2-10x2")), "interleaved chunks");
        assert!(excludes(&record(None, false, "a"), &record(None, false, "a")));

        let resuming = |hash| record(Some("1-10"), true, hash);
        assert!(!excludes(&resuming("a"), &resuming("a")), "equal runs that resume share the frames");
        assert!(excludes(&resuming("a"), &resuming("b")));
        assert!(excludes(&resuming("a"), &frames("1-10")));
        assert!(!excludes(&record(None, true, "a"), &record(None, true, "a")));
    }

    #[test]
    fn a_refusal_names_the_other_run_and_a_remedy() {
        let other = record(Some("1-10"), false, "a");
        let text = record(Some("7"), false, "a").refusal(&other, "out/a.####.exr");
        assert_eq!(
            text,
            "out/a.####.exr: process 4711 on render07 has been rendering frames 1-10 of it since 2026-11-23 21:00:11 UTC; \
             wait for its end, or run both with `resume` to share the frames"
        );
    }

    #[test]
    fn frames_are_read_as_they_are_written() {
        for frames in [vec![7], (1..=100).collect(), vec![-3, -2, 5, 9, 13], vec![10, 9, 8]] {
            let text = frame_list(&frames);
            assert_eq!(listed(Some(&text)), Some(frames.into_iter().collect()), "{text}");
        }
    }
}
