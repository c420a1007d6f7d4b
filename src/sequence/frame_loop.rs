//! The loop over frames: pose, build, render, write.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use sha2::{Digest as _, Sha256};

use crate::bvh::BuildStatistics;
use crate::cancel::CancelFlag;
use crate::error::{Error, Result, Warning};
use crate::film::Film;
use crate::image_file::{decode_exr, write_atomically};
use crate::integrator::PASS_THROUGH_LIMIT;
use crate::output::{PreviewLook, exr_file, frame_attributes, png_file};
use crate::render::{RenderInput, RenderStatistics, render_frame};

use super::exposure::exposure_ev;
use super::posed_frames::PosedFrames;
use super::render_hash::hex;
use super::statistics::peak_memory_bytes;
use super::{
    Exposure, FailedFrame, FrameReport, OutputFormat, Phases, Plan, PlannedFrame, RayReport, SequenceEvent,
    SequenceJob, Summary, TreeReport,
};

/// Renders the frames of `plan` in order, on the current rayon pool, and writes each as soon as it is finished.
///
/// A panic in a frame fails that frame alone. The first failure ends the run unless `job.keep_going`; a raised `cancel`
/// ends it within a second. Frames that are written stay in every case.
pub fn run(
    job: &SequenceJob,
    plan: &Plan,
    cancel: &CancelFlag,
    on_event: &(dyn Fn(SequenceEvent<'_>) + Sync),
) -> Summary {
    let start = Instant::now();
    let mut summary = Summary::default();
    on_event(SequenceEvent::Started {
        to_render: plan.remaining(),
        kept: plan.frames.len() - plan.remaining(),
    });
    let mut frame_loop = FrameLoop::new(job, cancel, on_event);
    for planned in &plan.frames {
        if cancel.is_raised() {
            summary.is_interrupted = true;
            break;
        }
        match frame_loop.guarded(planned) {
            Ok(Some(report)) => {
                on_event(SequenceEvent::FrameWritten(&report));
                summary.written.push(report);
            }
            Ok(None) => {
                on_event(SequenceEvent::FrameKept(planned));
                summary.kept.push(planned.frame);
            }
            Err(Error::Interrupted(_)) => {
                summary.is_interrupted = true;
                break;
            }
            Err(error) => {
                on_event(SequenceEvent::FrameFailed(planned, &error));
                let frame = planned.frame;
                summary.failed.push(FailedFrame { frame, error });
                if !job.keep_going {
                    break;
                }
            }
        }
    }
    summary.seconds = start.elapsed().as_secs_f64();
    on_event(SequenceEvent::Finished(&summary));
    summary
}

/// What lives from frame to frame.
struct FrameLoop<'a> {
    job: &'a SequenceJob,
    cancel: &'a CancelFlag,
    on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
    look: Option<PreviewLook>,
    posed: PosedFrames,
    warned: Vec<Warning>,
}

impl<'a> FrameLoop<'a> {
    fn new(
        job: &'a SequenceJob,
        cancel: &'a CancelFlag,
        on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
    ) -> Self {
        Self { job, cancel, on_event, look: None, posed: PosedFrames::default(), warned: Vec::new() }
    }

    /// One frame with panics turned into errors; `None` when it was there already.
    fn guarded(&mut self, planned: &PlannedFrame) -> Result<Option<FrameReport>> {
        catch_unwind(AssertUnwindSafe(|| self.one(planned))).unwrap_or_else(|payload| {
            // What the panic left half made must not reach the next frame.
            self.posed = PosedFrames::default();
            Err(Error::Internal {
                message: format!("frame {}: {}", planned.frame, panic_message(payload.as_ref())),
            })
        })
    }

    fn one(&mut self, planned: &PlannedFrame) -> Result<Option<FrameReport>> {
        if planned.is_done {
            self.renew_preview(planned)?;
            return Ok(None);
        }
        (self.on_event)(SequenceEvent::FrameStarted(planned));
        let start = Instant::now();
        let mut seconds = Phases::default();

        // Pose the scene and build its hierarchy, unless the last one still fits.
        let look = self.look()?;
        let is_reused = self.posed.advance(self.job, planned.time_seconds, self.cancel, &mut seconds)?;
        let Some(bvh) = &self.posed.bvh else {
            return Err(Error::Internal { message: "there is no hierarchy to trace".to_owned() });
        };
        let tree = bvh.statistics();

        // Trace.
        let input = RenderInput {
            scene: &self.job.scene,
            frame: &self.posed.current,
            bvh,
            environment: &self.job.environment,
        };
        let on_event = self.on_event;
        let on_progress = |share: f32| on_event(SequenceEvent::FrameProgress(planned, share));
        let (film, rays) = render_frame(&input, &self.job.render, self.cancel, &on_progress)?;
        seconds.trace = rays.trace_seconds;
        self.examine(planned, &tree, &rays)?;

        // Write.
        let writing = Instant::now();
        let file = self.write(planned, &film, look)?;
        seconds.write = writing.elapsed().as_secs_f64();
        seconds.total = start.elapsed().as_secs_f64();
        Ok(Some(FrameReport {
            frame: planned.frame,
            time_seconds: planned.time_seconds,
            path: planned.path.clone(),
            sha256: hex(&Sha256::digest(&file)),
            bytes: file.len(),
            seconds,
            tree: TreeReport::new(&tree, is_reused),
            rays: RayReport::new(&rays),
            peak_memory_bytes: peak_memory_bytes(),
        }))
    }

    /// How tone-mapped files look; found once, and only when there are any.
    fn look(&mut self) -> Result<PreviewLook> {
        if let Some(look) = self.look {
            return Ok(look);
        }
        let is_needed = self.job.preview || self.job.output.format() == OutputFormat::Png;
        let exposure_ev = if is_needed { exposure_ev(self.job, self.cancel)? } else { 0.0 };
        if is_needed {
            let is_automatic = self.job.exposure == Exposure::Auto;
            (self.on_event)(SequenceEvent::ExposureFound { ev: exposure_ev, is_automatic });
        }
        let tone = self.job.tone;
        Ok(*self.look.insert(PreviewLook { exposure_ev, tone }))
    }

    /// Fails or warns about what the statistics say.
    fn examine(
        &mut self,
        planned: &PlannedFrame,
        tree: &BuildStatistics,
        rays: &RenderStatistics,
    ) -> Result<()> {
        if rays.non_finite_pixels > 0 && self.job.strict {
            return Err(Error::Internal {
                message: format!(
                    "frame {}: {} pixels are infinite or not a number",
                    planned.frame, rays.non_finite_pixels
                ),
            });
        }
        if rays.non_finite_pixels > 0 {
            self.warn(format!(
                "frame {}: {} pixels were infinite or not a number and are black; this is a bug worth reporting",
                planned.frame, rays.non_finite_pixels
            ));
        }
        if rays.integrator.pass_through_limit_reached > 0 {
            self.warn(format!(
                "some samples met more than {PASS_THROUGH_LIMIT} see-through surfaces; what lies behind them is missing"
            ));
        }
        if tree.budget_reached {
            self.warn(format!(
                "--split: the area would make more than {} references a triangle and was raised",
                self.job.build.reference_budget
            ));
        }
        Ok(())
    }

    fn warn(&mut self, message: String) {
        let warning = Warning { pointer: String::new(), message };
        if !self.warned.contains(&warning) {
            (self.on_event)(SequenceEvent::Warned(&warning));
            self.warned.push(warning);
        }
    }

    /// Writes the frame's files and returns the first one's bytes. The preview comes first: where the frame is, all is.
    fn write(&self, planned: &PlannedFrame, film: &Film, look: PreviewLook) -> Result<Vec<u8>> {
        let size = (film.window.width(), film.window.height());
        let file = match self.job.output.format() {
            OutputFormat::Png => png_file(size, &film.pixels, look, &planned.render_hash)?,
            OutputFormat::Exr => {
                let attributes = frame_attributes(
                    planned.frame,
                    planned.time_seconds,
                    self.job.rate.as_exr_rational(),
                    &planned.render_hash,
                    (&self.posed.current.camera, film.resolution),
                );
                exr_file(film, &attributes)?
            }
        };
        if let Some(preview_path) = &planned.preview_path {
            let preview = png_file(size, &film.pixels, look, &planned.render_hash)?;
            write_atomically(preview_path, &preview)?;
        }
        write_atomically(&planned.path, &file)?;
        Ok(file)
    }

    /// Makes the preview of a frame that is kept, from its file.
    fn renew_preview(&mut self, planned: &PlannedFrame) -> Result<()> {
        let Some(preview_path) = &planned.preview_path else {
            return Ok(());
        };
        let look = self.look()?;
        let (size, pixels) = read_frame(&planned.path, self.job.max_memory_bytes)?;
        write_atomically(preview_path, &png_file(size, &pixels, look, &planned.render_hash)?)
    }
}

type SizedPixels = ((u32, u32), Vec<[f32; 4]>);

fn read_frame(path: &Path, max_memory_bytes: u64) -> Result<SizedPixels> {
    let bytes = std::fs::read(path).map_err(|source| Error::Missing {
        path: path.to_owned(),
        pointer: String::new(),
        source,
    })?;
    let image = decode_exr(path, &bytes, max_memory_bytes)?;
    Ok((image.size, image.pixels))
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(ToString::to_string)
        .or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "a worker panicked".to_owned())
}
