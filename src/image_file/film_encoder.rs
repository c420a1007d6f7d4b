//! A film in the making: the process of `ffmpeg`, the thread that passes frames to it, and what it says.
//!
//! However the process behaves, the run goes on or ends with an error. What it says goes to a file, because a full pipe would stop it.
//! A thread passes the frames, because a process that reads nothing would stop whoever writes to it.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::cancel::{CancelFlag, Cancelled};
use crate::child_process::OwnedChild;
use crate::error::{Error, Result};

/// Time between two looks at the cancellation flag.
const NAP: Duration = Duration::from_millis(20);
/// Time that a failing process has for its last words.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Bytes of its last words that are read.
const END_BYTES: u64 = 1 << 16;
/// Characters of them that are shown.
const SHOWN_CHARACTERS: usize = 300;

/// A running encoder.
pub(super) struct FilmEncoder {
    /// Final path of the film, for messages.
    path: PathBuf,
    process: OwnedChild,
    /// Its standard error stream.
    said: Option<File>,
    /// Frames for the thread; `None` after the last one.
    frames: Option<SyncSender<Vec<u8>>>,
    /// What became of each.
    passed: Receiver<io::Result<()>>,
    cancel: CancelFlag,
}

impl FilmEncoder {
    /// Starts `command`, which reads frames from its standard input.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] where it cannot be started, [`Error::Temporary`] where the system starts no thread.
    pub(super) fn start(mut command: Command, path: &Path, cancel: &CancelFlag) -> Result<Self> {
        // Without a place for temporary files only the reason of a failure is lost.
        let said = tempfile::tempfile().ok();
        let errors = said.as_ref().and_then(|said| said.try_clone().ok());
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(errors.map_or(Stdio::null(), Stdio::from));
        let started = command.spawn().map_err(|error| Error::CannotCreate {
            path: path.to_owned(),
            message: format!(
                "ffmpeg cannot be started: {error}; .apng, .webp and .gif need no other program"
            ),
        });
        let mut process = OwnedChild(started?);
        let (frames, received) = sync_channel(0);
        let (passed, results) = channel();
        let input = process.0.stdin.take();
        let pass = move || pass_frames(input, &received, &passed);
        thread::Builder::new().spawn(pass).map_err(Error::no_threads)?;
        let (path, frames, cancel) = (path.to_owned(), Some(frames), cancel.clone());
        Ok(Self { path, process, said, frames, passed: results, cancel })
    }

    /// Passes the next frame. Returns when it is read.
    ///
    /// # Errors
    /// [`Error::WriteFailed`] where the process reads no more, [`Error::Interrupted`] when cancelled.
    pub(super) fn add(&mut self, frame: Vec<u8>) -> Result<()> {
        let is_sent = self.frames.as_ref().is_some_and(|frames| frames.send(frame).is_ok());
        if !is_sent {
            return Err(self.failed("it ended early"));
        }
        loop {
            match self.passed.recv_timeout(NAP) {
                Ok(Ok(())) => return Ok(()),
                Ok(Err(error)) => return Err(self.failed(&error.to_string())),
                Err(RecvTimeoutError::Timeout) => self.cancel.check()?,
                Err(RecvTimeoutError::Disconnected) => return Err(self.failed("it ended early")),
            }
        }
    }

    /// Waits until the process has written everything to `temporary`.
    ///
    /// # Errors
    /// [`Error::WriteFailed`] where it fails or writes nothing, [`Error::Interrupted`] when cancelled.
    pub(super) fn finish(mut self, temporary: &Path) -> Result<()> {
        drop(self.frames.take());
        match self.process.wait_unless(|| self.cancel.is_raised()) {
            Ok(Some(status)) if !status.success() => Err(self.failed("it ended early")),
            Ok(Some(_)) if temporary.metadata().is_ok_and(|written| written.len() > 0) => Ok(()),
            Ok(Some(_)) => Err(self.failed("it wrote no film")),
            Ok(None) => Err(Error::Interrupted(Cancelled)),
            Err(error) => Err(self.failed(&error.to_string())),
        }
    }

    /// The error with the last line that the process said, or else `why`.
    fn failed(&mut self, why: &str) -> Error {
        drop(self.frames.take());
        let start = Instant::now();
        let _ = self.process.wait_unless(|| self.cancel.is_raised() || start.elapsed() > LAST_WORDS);
        let said = self.said.as_mut().and_then(|said| end_of(said).ok()).unwrap_or_default();
        let line = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or(why);
        let line: String = line.chars().take(SHOWN_CHARACTERS).collect();
        let source = io::Error::other(format!("ffmpeg: {line}"));
        Error::WriteFailed { path: self.path.clone(), source }
    }
}

/// Writes the frames to the standard input of the process, up to the first failure, and closes it.
fn pass_frames(input: Option<impl io::Write>, frames: &Receiver<Vec<u8>>, passed: &Sender<io::Result<()>>) {
    let Some(mut input) = input else { return };
    for frame in frames {
        let written = input.write_all(&frame);
        let is_last = written.is_err();
        if passed.send(written).is_err() || is_last {
            return;
        }
    }
}

fn end_of(file: &mut File) -> io::Result<String> {
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(END_BYTES)))?;
    let mut bytes = Vec::new();
    file.take(END_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
