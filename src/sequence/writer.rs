//! The far end of the loop: files of frames that are traced, while the next frame is under way.
//!
//! Encoding is a task of the rayon pool, started by the loop as soon as a frame is traced. Waiting for the disk is left to
//! one thread, which also settles every frame, in the loop's order: it tells the event that ends the frame and keeps the
//! summary. So of several failures the first frame's comes first, whatever happened first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};

use rayon::{Scope, Yield};
use sha2::{Digest as _, Sha256};

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::image_file::{FrameAttributes, decode_exr_rgba, write_atomically};
use crate::output::{ExrFiles, ExrOutput, InstanceIds, PreviewLook, exr_files, png_file};

use super::frame_loop::panic_error;
use super::render_hash::hex;
use super::statistics::peak_memory_bytes;
use super::{
    AovFileReport, FailedFrame, FrameReport, OutputFormat, Phases, PlannedFrame, RayReport, SequenceEvent,
    SequenceJob, Summary, TreeReport,
};

/// How long a thread sleeps that has nothing to do but wait.
const NAP: Duration = Duration::from_millis(1);

/// What the loop hands over about each frame.
pub(super) enum HandedOver<'a> {
    /// It is traced; its files are being encoded.
    Traced(Box<TracedFrame<'a>>),
    /// It was there already. Its preview is made anew if a look is given.
    Kept(&'a PlannedFrame, Option<PreviewLook>),
    /// It could not be made.
    Failed(&'a PlannedFrame, Error),
}

/// A frame without its files.
pub(super) struct TracedFrame<'a> {
    pub(super) planned: &'a PlannedFrame,
    pub(super) started: Instant,
    pub(super) seconds: Phases,
    pub(super) tree: TreeReport,
    pub(super) rays: RayReport,
    pub(super) encoded: Receiver<Result<EncodedFrame>>,
}

/// What a frame's files are made from.
pub(super) struct Picture<'a> {
    pub(super) planned: &'a PlannedFrame,
    pub(super) film: Film,
    pub(super) attributes: FrameAttributes,
    pub(super) look: PreviewLook,
    pub(super) format: OutputFormat,
    pub(super) exr: &'a ExrOutput,
    pub(super) shapes: Arc<InstanceIds>,
}

/// A frame's files before they are written.
pub(super) struct EncodedFrame {
    film: Film,
    files: ExrFiles,
    preview: Option<Vec<u8>>,
    sha256: String,
    seconds: f64,
}

/// Writes and settles frames.
pub(super) struct Writer<'a> {
    pub(super) job: &'a SequenceJob,
    /// The user's flag.
    pub(super) cancel: &'a CancelFlag,
    /// The loop's flag, raised when a frame's failure ends the run.
    pub(super) stop: &'a CancelFlag,
    pub(super) on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
    /// Films whose frames are on disk.
    pub(super) spent_films: Sender<Film>,
}

impl<'a> Picture<'a> {
    /// Encodes the files as a task of `pool`, beside whatever else it has to do.
    pub(super) fn encode_in<'s>(self, pool: &Scope<'s>) -> Receiver<Result<EncodedFrame>>
    where
        'a: 's,
    {
        let (sender, receiver) = channel();
        let work = move || {
            let frame = self.planned.frame;
            let encoded = catch_unwind(AssertUnwindSafe(|| self.encode()));
            let encoded = encoded.unwrap_or_else(|payload| Err(panic_error(frame, payload.as_ref())));
            // A run that has ended wants no more files.
            let _ = sender.send(encoded);
        };
        // A pool of one would not come to it before the next frame is traced.
        if rayon::current_num_threads() == 1 {
            work();
        } else {
            pool.spawn(move |_| work());
        }
        receiver
    }

    fn encode(self) -> Result<EncodedFrame> {
        let start = Instant::now();
        let Self { planned, film, attributes, look, format, exr, shapes } = self;
        let size = (film.window.width(), film.window.height());
        let png = || png_file(size, &film.pixels, look, &planned.render_hash);
        let file = || match format {
            OutputFormat::Png => png().map(|main| ExrFiles { main, aovs: Vec::new() }),
            OutputFormat::Exr => exr_files(&film, &attributes, exr, &shapes),
        };
        let (files, preview) = rayon::join(file, || planned.preview_path.is_some().then(png).transpose());
        let (files, preview) = (files?, preview?);
        let sha256 = hex(&Sha256::digest(&files.main));
        Ok(EncodedFrame { film, files, preview, sha256, seconds: start.elapsed().as_secs_f64() })
    }
}

impl Writer<'_> {
    /// Settles frames until the loop ends or the run is stopped.
    pub(super) fn settle(self, frames: Receiver<HandedOver<'_>>) -> Summary {
        let mut summary = Summary::default();
        let mut last_settled = None;
        for frame in frames {
            if self.cancel.is_raised() {
                summary.is_interrupted = true;
                break;
            }
            let (planned, settled) = match frame {
                HandedOver::Kept(planned, look) => {
                    let kept = self.keep(planned, look);
                    summary.previews += usize::from(look.is_some() && kept.is_ok());
                    (planned, kept.map(|()| None))
                }
                HandedOver::Failed(planned, error) => (planned, Err(error)),
                HandedOver::Traced(frame) => (frame.planned, self.write(frame, last_settled).map(Some)),
            };
            last_settled = Some(Instant::now());
            match settled {
                Ok(Some(report)) => {
                    (self.on_event)(SequenceEvent::FrameWritten(&report));
                    summary.written.push(report);
                }
                Ok(None) => {
                    (self.on_event)(SequenceEvent::FrameKept(planned));
                    summary.kept.push(planned.frame);
                }
                Err(Error::Interrupted(_)) => {
                    summary.is_interrupted = true;
                    break;
                }
                Err(error) => {
                    (self.on_event)(SequenceEvent::FrameFailed(planned, &error));
                    summary.failed.push(FailedFrame { frame: planned.frame, error });
                    if !self.job.keep_going {
                        self.stop.raise();
                        break;
                    }
                }
            }
        }
        summary
    }

    /// Writes a frame's files. The picture comes last: where it is, all is.
    fn write(&self, frame: Box<TracedFrame<'_>>, last_settled: Option<Instant>) -> Result<FrameReport> {
        let TracedFrame { planned, started, mut seconds, tree, rays, encoded } = *frame;
        let encoded = encoded.recv().unwrap_or_else(|_| {
            Err(Error::Internal { message: format!("frame {}: the encoder is gone", planned.frame) })
        });
        // Whatever becomes of the frame, the loop gets a film back.
        let EncodedFrame { film, files, preview, sha256, seconds: encode_seconds } = match encoded {
            Ok(encoded) => encoded,
            Err(error) => {
                let _ = self.spent_films.send(empty_film(self.job));
                return Err(error);
            }
        };
        let writing = Instant::now();
        let written = self.cancel.check().map_err(Error::from).and_then(|()| {
            guarded(planned, || {
                if let (Some(path), Some(preview)) = (&planned.preview_path, &preview) {
                    write_atomically(path, preview)?;
                }
                for (path, file) in planned.aov_paths.iter().zip(&files.aovs) {
                    write_atomically(path, file)?;
                }
                write_atomically(&planned.path, &files.main)
            })
        });
        let _ = self.spent_films.send(film);
        written?;

        seconds.write = encode_seconds + writing.elapsed().as_secs_f64();
        seconds.total = started.elapsed().as_secs_f64();
        seconds.period =
            last_settled.map_or(seconds.total, |last| last.elapsed().as_secs_f64().min(seconds.total));
        Ok(FrameReport {
            frame: planned.frame,
            time_seconds: planned.time_seconds,
            path: planned.path.clone(),
            sha256,
            bytes: files.main.len(),
            layers: layer_reports(planned, &files.aovs),
            seconds,
            tree,
            rays,
            peak_memory_bytes: peak_memory_bytes(),
        })
    }

    /// Makes the preview of a frame that is kept, from its file.
    fn keep(&self, planned: &PlannedFrame, look: Option<PreviewLook>) -> Result<()> {
        let (Some(preview_path), Some(look)) = (&planned.preview_path, look) else {
            return Ok(());
        };
        guarded(planned, || {
            let (size, pixels) = read_frame(&planned.path, self.job.max_memory_bytes)?;
            write_atomically(preview_path, &png_file(size, &pixels, look, &planned.render_hash)?)
        })
    }
}

/// A film for a frame with all of its layers.
pub(super) fn empty_film(job: &SequenceJob) -> Film {
    let settings = &job.render;
    Film::with_aovs(settings.resolution, settings.window, settings.aovs)
}

fn layer_reports(planned: &PlannedFrame, files: &[Vec<u8>]) -> Vec<AovFileReport> {
    let report = |(path, file): (&PathBuf, &Vec<u8>)| AovFileReport {
        path: path.clone(),
        sha256: hex(&Sha256::digest(file)),
        bytes: file.len(),
    };
    planned.aov_paths.iter().zip(files).map(report).collect()
}

/// Waits for `channel` and does the pool's work meanwhile; `None` when nothing will come.
pub(super) fn receive_working<T>(channel: &Receiver<T>) -> Option<T> {
    loop {
        match channel.try_recv() {
            Ok(value) => return Some(value),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) if rayon::yield_now() == Some(Yield::Executed) => {}
            Err(TryRecvError::Empty) => {
                if let Ok(value) = channel.recv_timeout(NAP) {
                    return Some(value);
                }
            }
        }
    }
}

fn guarded(planned: &PlannedFrame, work: impl FnOnce() -> Result<()>) -> Result<()> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|payload| Err(panic_error(planned.frame, payload.as_ref())))
}

type SizedPixels = ((u32, u32), Vec<[f32; 4]>);

pub(super) fn read_frame(path: &Path, max_memory_bytes: u64) -> Result<SizedPixels> {
    let bytes = std::fs::read(path).map_err(Error::missing(path))?;
    let image = decode_exr_rgba(path, &bytes, max_memory_bytes)?;
    Ok((image.size, image.pixels))
}
