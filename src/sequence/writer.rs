//! Encoding and writing of traced frames, while the next frame is rendered.
//!
//! Encoding is a task of the rayon pool, which the frame loop starts as soon as a frame is traced. One thread writes to the
//! disk. It also completes every frame in the loop's order: it sends the event that ends the frame and keeps the summary. So
//! of several failures the first frame's comes first, whatever happened first.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};

use rayon::{Scope, Yield};
use sha2::{Digest as _, Sha256};

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::image_file::{DisplayImage, FrameAttributes, WrittenExr, insert_preview_hash, write_atomically};
use crate::output::{ExrFiles, ExrOutput, InstanceIds, PreviewLook, display_image, exr_files, png_file};
use crate::sha256::hex;

use super::banded_frame::BandedFrame;
use super::checkpoint::Checkpoint;
use super::frame_claim::FrameClaim;
use super::frame_tracer::FrameTracer;
use super::kept_preview::KeptPreview;
use super::movie_output::MovieOutput;
use super::panic::catch_panic;
use super::statistics::peak_memory_bytes;
use super::{
    AovFileReport, FailedFrame, FrameReport, OutputFormat, Phases, PlannedFrame, RayReport, SequenceEvent,
    SequenceJob, Summary, TreeReport,
};

/// Sleep of a waiting thread between checks for work in the pool.
const NAP: Duration = Duration::from_millis(1);

/// Result of the frame loop for one frame.
pub(super) enum LoopResult<'a> {
    /// The frame is traced, and its files are being encoded.
    Traced(Box<TracedFrame<'a>>),
    /// The frame exists. Its preview is being written anew, where there are previews.
    Kept(&'a PlannedFrame, Option<KeptPreview>),
    /// The frame failed.
    Failed(&'a PlannedFrame, Error),
}

/// A traced frame whose files are being encoded.
pub(super) struct TracedFrame<'a> {
    pub(super) planned: &'a PlannedFrame,
    /// Held until the frame is written.
    pub(super) claim: FrameClaim,
    pub(super) started: Instant,
    /// Seconds of tracing before, in earlier runs.
    pub(super) earlier_seconds: f64,
    pub(super) seconds: Phases,
    pub(super) tree: TreeReport,
    pub(super) rays: RayReport,
    pub(super) files: FrameFiles,
}

/// The files of a traced frame.
pub(super) enum FrameFiles {
    /// They are being encoded in memory.
    InMemory(Receiver<Result<EncodedFrame>>),
    /// They are written but for their ends.
    Bands(Box<BandedFrame>),
}

/// What was written of a frame.
struct WrittenFrame {
    sha256: String,
    bytes: usize,
    aov_files: Vec<AovFileReport>,
    /// Seconds of encoding and writing before the writer.
    seconds: f64,
}

/// Input of the encoding of a frame's files.
pub(super) struct FrameEncoder<'a> {
    pub(super) planned: &'a PlannedFrame,
    pub(super) film: Film,
    pub(super) attributes: FrameAttributes,
    pub(super) look: PreviewLook,
    /// Hash of the preview, where the frame has one.
    pub(super) preview_hash: Option<String>,
    pub(super) format: OutputFormat,
    pub(super) exr: &'a ExrOutput,
    pub(super) instance_ids: Arc<InstanceIds>,
}

/// Encoded files of a frame.
pub(super) struct EncodedFrame {
    film: Film,
    files: ExrFiles,
    /// Tone-mapped image of a frame of a movie.
    image: Option<DisplayImage>,
    preview: Option<Vec<u8>>,
    sha256: String,
    seconds: f64,
}

/// Writes and completes frames.
pub(super) struct Writer<'a> {
    pub(super) job: &'a SequenceJob,
    /// The user's flag.
    pub(super) cancel: &'a CancelFlag,
    /// The frame loop's flag, raised when a frame's failure ends the run.
    pub(super) stop: &'a CancelFlag,
    pub(super) on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
    /// Takes back films whose frames are written.
    pub(super) free_films: Sender<Film>,
    /// Is told of each traced frame that is written or has failed, after its event.
    pub(super) written: Sender<()>,
    /// The movie, where it is the output.
    pub(super) movie: Option<MovieOutput<'a>>,
}

impl<'a> FrameEncoder<'a> {
    /// Encodes the files as a task of `pool`.
    pub(super) fn spawn<'s>(self, pool: &Scope<'s>) -> Receiver<Result<EncodedFrame>>
    where
        'a: 's,
    {
        let (sender, receiver) = channel();
        let work = move || {
            let frame = self.planned.frame;
            // The receiver is gone when the run has ended.
            let _ = sender.send(catch_panic(frame, || self.encode()));
        };
        // A pool of one thread would not start the task before the next frame is traced.
        if rayon::current_num_threads() == 1 {
            work();
        } else {
            pool.spawn(move |_| work());
        }
        receiver
    }

    fn encode(self) -> Result<EncodedFrame> {
        let start = Instant::now();
        let Self { planned, film, attributes, look, preview_hash, format, exr, instance_ids } = self;
        let png = || png_file(&film, look, &planned.render_hash);
        if let OutputFormat::Movie(_) = format {
            let image = display_image(film.window.size(), &film.pixels, film.plate.as_deref(), look);
            let sha256 = hex(&Sha256::digest(image.pixels.as_flattened()));
            let files = ExrFiles { main: Vec::new(), aovs: Vec::new() };
            let seconds = start.elapsed().as_secs_f64();
            return Ok(EncodedFrame { film, files, image: Some(image), preview: None, sha256, seconds });
        }
        let file = || match format {
            OutputFormat::Png | OutputFormat::Movie(_) => {
                png().map(|main| ExrFiles { main, aovs: Vec::new() })
            }
            OutputFormat::Exr => exr_files(&film, &attributes, exr, &instance_ids),
        };
        let preview = || {
            let Some(hash) = preview_hash else { return Ok(None) };
            let mut png = png()?;
            insert_preview_hash(&mut png, &hash);
            Ok::<_, Error>(Some(png))
        };
        let (files, preview) = rayon::join(file, preview);
        let (files, preview) = (files?, preview?);
        let sha256 = hex(&Sha256::digest(&files.main));
        Ok(EncodedFrame { film, files, image: None, preview, sha256, seconds: start.elapsed().as_secs_f64() })
    }
}

impl Writer<'_> {
    /// Completes frames until the loop ends or the run is cancelled.
    pub(super) fn complete_all(mut self, frames: Receiver<LoopResult<'_>>) -> Summary {
        let mut summary = Summary::default();
        let mut last_completed = None;
        for frame in frames {
            if self.cancel.is_raised() {
                summary.is_interrupted = true;
                break;
            }
            let mut is_traced = false;
            let (planned, completed) = match frame {
                LoopResult::Kept(planned, None) => (planned, Ok(None)),
                LoopResult::Kept(planned, Some(preview)) => {
                    let written = preview.written(planned.frame);
                    summary.previews += usize::from(matches!(written, Ok(true)));
                    (planned, written.map(|_| None))
                }
                LoopResult::Failed(planned, error) => (planned, Err(error)),
                LoopResult::Traced(frame) => {
                    is_traced = true;
                    (frame.planned, self.write(frame, last_completed).map(Some))
                }
            };
            last_completed = Some(Instant::now());
            match completed {
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
            if is_traced {
                let _ = self.written.send(());
            }
        }
        summary
    }

    /// Writes a frame's files, the main file last: where it exists, all of them do.
    fn write(&mut self, frame: Box<TracedFrame<'_>>, last_completed: Option<Instant>) -> Result<FrameReport> {
        let TracedFrame { planned, claim: _claim, started, earlier_seconds, mut seconds, tree, rays, files } =
            *frame;
        let writing = Instant::now();
        let written = match files {
            FrameFiles::InMemory(encoded) => self.write_encoded(planned, &encoded)?,
            FrameFiles::Bands(bands) => self.finish_bands(planned, *bands)?,
        };
        Checkpoint::remove_of_finished(self.job, planned);

        seconds.write = written.seconds + writing.elapsed().as_secs_f64();
        let elapsed = started.elapsed().as_secs_f64();
        seconds.total = earlier_seconds + elapsed;
        seconds.period = last_completed.map_or(elapsed, |last| last.elapsed().as_secs_f64().min(elapsed));
        Ok(FrameReport {
            frame: planned.frame,
            time_seconds: planned.time_seconds,
            path: planned.path.clone(),
            sha256: written.sha256,
            bytes: written.bytes,
            aov_files: written.aov_files,
            seconds,
            tree,
            rays,
            peak_memory_bytes: peak_memory_bytes(),
        })
    }

    /// Waits for the encoder and writes its files.
    fn write_encoded(
        &mut self,
        planned: &PlannedFrame,
        encoded: &Receiver<Result<EncodedFrame>>,
    ) -> Result<WrittenFrame> {
        let encoded = encoded.recv().unwrap_or_else(|_| {
            Err(Error::Internal {
                message: format!("frame {}: the encoder ended without a result", planned.frame),
            })
        });
        // The loop gets a film back in every case.
        let EncodedFrame { film, files, image, preview, sha256, seconds: encode_seconds } = match encoded {
            Ok(encoded) => encoded,
            Err(error) => {
                let _ = self.free_films.send(FrameTracer::empty_film(self.job));
                return Err(error);
            }
        };
        let written = self.cancel.check().map_err(Error::from).and_then(|()| {
            catch_panic(planned.frame, || {
                if let (Some(movie), Some(image)) = (&mut self.movie, &image) {
                    return movie.add(planned.frame, image, self.on_event);
                }
                if let (Some(path), Some(preview)) = (&planned.preview_path, &preview) {
                    write_atomically(path, preview)?;
                }
                for (path, file) in planned.aov_paths.iter().zip(&files.aovs) {
                    write_atomically(path, file)?;
                }
                write_atomically(&planned.path, &files.main)
            })
        });
        let _ = self.free_films.send(film);
        written?;
        Ok(WrittenFrame {
            sha256,
            bytes: image.map_or(files.main.len(), |image| image.pixels.as_flattened().len()),
            aov_files: aov_reports(planned, &files.aovs),
            seconds: encode_seconds,
        })
    }

    /// Completes the files of a frame that is rendered in bands.
    fn finish_bands(&self, planned: &PlannedFrame, bands: BandedFrame) -> Result<WrittenFrame> {
        let (main, aovs, seconds) = catch_panic(planned.frame, || bands.finish(self.cancel))?;
        let Some(WrittenExr { sha256, bytes }) = main else {
            return Err(Error::Internal { message: format!("frame {}: no band was written", planned.frame) });
        };
        let report = |(path, WrittenExr { sha256, bytes }): (&PathBuf, WrittenExr)| AovFileReport {
            path: path.clone(),
            sha256,
            bytes,
        };
        let aov_files = planned.aov_paths.iter().zip(aovs).map(report).collect();
        Ok(WrittenFrame { sha256, bytes, aov_files, seconds })
    }
}

fn aov_reports(planned: &PlannedFrame, files: &[Vec<u8>]) -> Vec<AovFileReport> {
    let report = |(path, file): (&PathBuf, &Vec<u8>)| AovFileReport {
        path: path.clone(),
        sha256: hex(&Sha256::digest(file)),
        bytes: file.len(),
    };
    planned.aov_paths.iter().zip(files).map(report).collect()
}

/// Waits for a value and runs tasks of the pool meanwhile; `None` when the channel is closed.
pub(super) fn receive_while_working<T>(channel: &Receiver<T>) -> Option<T> {
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
