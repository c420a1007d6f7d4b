//! The loop over frames: pose, build, trace, and hand over to the writer.
//!
//! While a frame is encoded and written, the next one is posed, built and traced. There are two films, so that the loop is
//! never further ahead. Without write-behind, a frame is on the disk before the next one begins.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use rayon::Scope;

use crate::cancel::{CancelFlag, Cancelled};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::output::{PreviewLook, run_stamp};

use super::banded_frame::{BandedFrame, BandedResult};
use super::checkpoint::Checkpoint;
use super::environment_shares::environment_shares;
use super::exposure::exposure_ev;
use super::frame_claim::{Claimed, FrameClaim, LongWait};
use super::frame_tracer::{FrameStatistics, FrameTracer};
use super::frame_warnings::{FrameWarnings, LitPixels, depth_warning};
use super::kept_preview::KeptPreview;
use super::movie_output::MovieOutput;
use super::panic::catch_panic;
use super::render_hash::preview_hash;
use super::writer::{FrameEncoder, FrameFiles, LoopResult, TracedFrame, Writer, receive_while_working};
use super::{
    Exposure, FailedFrame, OutputFormat, Phases, Plan, PlannedFrame, RayReport, SequenceEvent, SequenceJob,
    Summary, TreeReport,
};

/// Most films: one is traced, one is written.
const FILMS: usize = 2;
/// The same where nothing is traced while a frame is written.
const FILMS_WITHOUT_WRITE_BEHIND: usize = 1;

/// Pause between two looks at frames that other runs render.
const PAUSE: Duration = Duration::from_millis(100);

/// Receiver of events, called from several threads.
type OnEvent<'a> = &'a (dyn Fn(SequenceEvent<'_>) + Sync);

/// Renders the frames of `plan` in order on the current rayon pool. A frame is written while the next one is rendered.
///
/// A panic in a frame fails that frame alone. The first failure ends the run unless `job.keep_going`. A raised `cancel` ends
/// it within a second. Written frames stay in every case.
pub fn run(job: &SequenceJob, plan: &Plan, cancel: &CancelFlag, on_event: OnEvent<'_>) -> Summary {
    let start = Instant::now();
    on_event(SequenceEvent::Started {
        to_render: plan.remaining(),
        kept: plan.frames.len() - plan.remaining(),
    });
    if plan.remaining() == 0 {
        job.first_pose.clear();
    }
    let stop = cancel.inner();
    let measured = measure(job, plan, &stop).and_then(|()| tone_mapping(job, plan, &stop, on_event));
    let mut summary = match measured {
        Ok(look) => Summary { look, ..render_and_write(&Run { job, plan, cancel, stop, look, on_event }) },
        Err(Cancelled) => Summary { is_interrupted: true, ..Summary::default() },
    };
    summary.seconds = start.elapsed().as_secs_f64();
    if let Some(warning) = depth_warning(&summary, job.render.max_depth) {
        on_event(SequenceEvent::Warned(&warning));
    }
    on_event(SequenceEvent::Finished(&summary));
    summary
}

/// Measures what frames have in common besides the exposure, so that the first frame takes no longer than others. Where that panics, so does the first
/// frame, which fails.
fn measure(job: &SequenceJob, plan: &Plan, cancel: &CancelFlag) -> std::result::Result<(), Cancelled> {
    if plan.remaining() == 0 {
        return Ok(());
    }
    let measured = catch_panic(0, || Ok(environment_shares(job, &job.selection, &job.render, cancel)?));
    if measured.is_err() { cancel.check() } else { Ok(()) }
}

/// Tone mapping of the run, where anything is tone-mapped or rendered by the exposure. Automatic exposure is computed here, once.
fn tone_mapping(
    job: &SequenceJob,
    plan: &Plan,
    cancel: &CancelFlag,
    on_event: OnEvent<'_>,
) -> std::result::Result<Option<PreviewLook>, Cancelled> {
    let is_display = job.output.format() != OutputFormat::Exr;
    let is_rendered_by_it = plan.remaining() > 0 && (is_display || job.renders_by_exposure());
    if !(job.preview || is_rendered_by_it || job.sequence_outputs.needs_tone_mapping()) {
        return Ok(None);
    }
    let exposure_ev = exposure_ev(job, cancel)?;
    let is_automatic = job.exposure == Exposure::Auto;
    on_event(SequenceEvent::ExposureFound { ev: exposure_ev, is_automatic });
    Ok(Some(job.look(exposure_ev)))
}

/// Inputs of a run.
struct Run<'a> {
    job: &'a SequenceJob,
    plan: &'a Plan,
    /// The user's flag.
    cancel: &'a CancelFlag,
    /// The frame loop's flag, which a failure raises, too.
    stop: CancelFlag,
    look: Option<PreviewLook>,
    on_event: OnEvent<'a>,
}

/// Runs the frame loop on this thread and the writer on its own.
fn render_and_write(run: &Run<'_>) -> Summary {
    let Run { job, plan, cancel, stop, look, on_event } = run;
    let (results, received_results) = channel();
    let (free_films, films) = channel();
    // Bands have films of their own.
    let most_films = if job.write_behind { FILMS } else { FILMS_WITHOUT_WRITE_BEHIND };
    let films_needed = if plan.band_rows.is_none() { most_films.min(plan.remaining()) } else { 0 };
    for _ in 0..films_needed {
        let _ = free_films.send(FrameTracer::empty_film(job));
    }
    let (writer_lives, writer_ended) = channel::<()>();
    let (written, received_written) = channel();
    let movie = MovieOutput::new(job, plan, cancel);
    let writer = Writer { job, cancel, stop, on_event, free_films, written, movie };
    rayon::in_place_scope(|pool| {
        thread::scope(|threads| {
            let write = move || {
                // Closes the channel when the writer ends.
                let _writer_lives = writer_lives;
                writer.complete_all(received_results)
            };
            let writing = match thread::Builder::new().spawn_scoped(threads, write) {
                Ok(writing) => writing,
                Err(error) => return no_thread(plan, &error),
            };
            let frame_loop = FrameLoop {
                job,
                stop,
                on_event,
                pool,
                results,
                films,
                film: None,
                written: received_written,
                has_unwritten: false,
                band_rows: plan.band_rows,
                look: look.unwrap_or(job.look(0.0)),
                tracer: FrameTracer::new(job, stop).with_exposure(look.map(|look| look.exposure_ev)),
                warnings: FrameWarnings::default(),
            };
            let reached_the_end = frame_loop.run(plan);
            let _ = receive_while_working(&writer_ended);
            let mut summary = writing.join().unwrap_or_else(|payload| resume_unwind(payload));
            summary.is_movie = job.output.is_movie();
            summary.is_interrupted |= !reached_the_end;
            // A failure that ended the run is no interruption.
            summary.is_interrupted &= job.keep_going || summary.failed.is_empty();
            summary
        })
    })
}

/// State of the frame loop.
struct FrameLoop<'a, 's, 'p> {
    job: &'a SequenceJob,
    stop: &'a CancelFlag,
    on_event: OnEvent<'a>,
    pool: &'s Scope<'p>,
    results: Sender<LoopResult<'a>>,
    films: Receiver<Film>,
    /// The film of the current frame.
    film: Option<Film>,
    /// A value for each traced frame that the writer is done with.
    written: Receiver<()>,
    /// Whether the writer may not be done with the last frame. Stays false where the job writes behind.
    has_unwritten: bool,
    /// Rows of the bands that frames are rendered in.
    band_rows: Option<u32>,
    look: PreviewLook,
    tracer: FrameTracer<'a>,
    warnings: FrameWarnings,
}

impl<'a: 'p, 'p> FrameLoop<'a, '_, 'p> {
    /// Renders frames up to the last one, the first failure, or a raised flag. Returns false for a raised flag.
    fn run(mut self, plan: &'a Plan) -> bool {
        let mut frames: Vec<_> = plan.frames.iter().collect();
        let mut long_wait = LongWait::default();
        loop {
            let mut elsewhere = Vec::new();
            for planned in frames {
                if self.stop.is_raised() {
                    return false;
                }
                let result = match self.frame_or_panic(planned) {
                    Ok(Some(result)) => result,
                    Ok(None) => {
                        elsewhere.push(planned);
                        continue;
                    }
                    Err(Error::Interrupted(_)) => return false,
                    Err(error) => LoopResult::Failed(planned, error),
                };
                self.has_unwritten |= !self.job.write_behind && matches!(result, LoopResult::Traced(_));
                let is_last = matches!(result, LoopResult::Failed(..)) && !self.job.keep_going;
                if self.results.send(result).is_err() {
                    // The writer has ended the run.
                    return false;
                }
                if is_last {
                    return true;
                }
            }
            if elsewhere.is_empty() {
                return true;
            }
            // Other runs finish these, or leave them to this one when they end.
            if let Some(warning) = long_wait.warning(&elsewhere) {
                (self.on_event)(SequenceEvent::Warned(&warning));
            }
            thread::sleep(PAUSE);
            frames = elsewhere;
        }
    }

    /// Renders one frame; `None` for one that another run renders. A panic becomes an error.
    fn frame_or_panic(&mut self, planned: &'a PlannedFrame) -> Result<Option<LoopResult<'a>>> {
        let mut has_returned = false;
        let result = catch_panic(planned.frame, || {
            let result = self.frame(planned);
            has_returned = true;
            result
        });
        if !has_returned {
            // A state that the panic left inconsistent must not reach the next frame.
            self.tracer.reset();
            // The panic took the film with it, and the writer may have none to return.
            if self.band_rows.is_none() && self.film.is_none() {
                self.film = Some(FrameTracer::empty_film(self.job));
            }
        }
        result
    }

    fn frame(&mut self, planned: &'a PlannedFrame) -> Result<Option<LoopResult<'a>>> {
        // Wait until the frame before the previous one is written, or the previous one. Until then another run may claim the frame.
        let started = Instant::now();
        if !planned.is_done && self.has_unwritten {
            receive_while_working(&self.written).ok_or(Cancelled)?;
            self.has_unwritten = false;
        }
        if !planned.is_done && self.band_rows.is_none() && self.film.is_none() {
            self.film = Some(receive_while_working(&self.films).ok_or(Cancelled)?);
        }
        let mut seconds = Phases { wait: started.elapsed().as_secs_f64(), ..Phases::default() };

        let claim = match FrameClaim::of(self.job, planned)? {
            Claimed::Here(claim) => claim,
            Claimed::Elsewhere => return Ok(None),
            Claimed::Done => {
                // A run may have ended between a frame and its checkpoint.
                Checkpoint::remove_of_finished(self.job, planned);
                let preview = KeptPreview::spawn((self.job, planned), self.look, self.stop, self.pool);
                return Ok(Some(LoopResult::Kept(planned, preview)));
            }
        };
        (self.on_event)(SequenceEvent::FrameStarted(planned));
        if let Some(rows) = self.band_rows {
            return self.banded_frame((planned, claim), rows, started).map(Some);
        }
        let mut film = self.film.take().ok_or(Cancelled)?;

        // Pose, build and trace.
        let rendered = match self.render(planned, &mut film) {
            Ok(rendered) => rendered,
            Err(error) => {
                self.film = Some(film);
                return Err(error);
            }
        };
        seconds = Phases { wait: seconds.wait, trace: rendered.rays.trace_seconds, ..rendered.phases };

        // Hand over to the writer.
        let mut attributes = self.tracer.attributes(planned.frame, &planned.render_hash);
        if self.job.exr.is_stamped {
            attributes.stamp = Some(run_stamp(seconds.render_seconds()));
        }
        let format = self.job.output.format();
        let (exr, look, instance_ids) = (&self.job.exr, self.look, self.tracer.instance_ids());
        let has_preview = planned.preview_path.is_some();
        let preview_hash = has_preview.then(|| preview_hash(self.job, &planned.render_hash, look));
        let encoder =
            FrameEncoder { planned, film, attributes, look, preview_hash, format, exr, instance_ids };
        let files = FrameFiles::InMemory(encoder.spawn(self.pool));
        Ok(Some(self.traced((planned, claim), (started, seconds), &rendered, files)))
    }

    /// Renders a frame in bands of `rows`.
    fn banded_frame(
        &mut self,
        (planned, claim): (&'a PlannedFrame, FrameClaim),
        rows: u32,
        started: Instant,
    ) -> Result<LoopResult<'a>> {
        let on_event = self.on_event;
        let on_progress = |progress| on_event(SequenceEvent::FrameProgress(planned, progress));
        let (job, exposure_ev) = (self.job, self.look.exposure_ev);
        let BandedResult { frame, statistics, lit } =
            BandedFrame::render(job, &mut self.tracer, (planned, rows), exposure_ev, &on_progress)?;
        self.warn(planned, &statistics, || lit)?;
        let seconds = Phases { trace: statistics.rays.trace_seconds, ..statistics.phases };
        let files = FrameFiles::Bands(Box::new(frame));
        Ok(self.traced((planned, claim), (started, seconds), &statistics, files))
    }

    /// A traced frame for the writer.
    fn traced(
        &self,
        (planned, claim): (&'a PlannedFrame, FrameClaim),
        (started, seconds): (Instant, Phases),
        FrameStatistics { tree, rays, is_reused, earlier_seconds, .. }: &FrameStatistics,
        files: FrameFiles,
    ) -> LoopResult<'a> {
        let tree = TreeReport::new(tree, self.job.build.builder, *is_reused);
        LoopResult::Traced(Box::new(TracedFrame {
            planned,
            claim,
            started,
            earlier_seconds: *earlier_seconds,
            seconds,
            tree,
            rays: RayReport::new(rays),
            files,
        }))
    }

    /// Renders a frame and sends its warnings.
    fn render(&mut self, planned: &PlannedFrame, film: &mut Film) -> Result<FrameStatistics> {
        let on_event = self.on_event;
        let on_progress = |progress| on_event(SequenceEvent::FrameProgress(planned, progress));
        let checkpoint = Checkpoint::of(self.job, planned);
        let rendered = self.tracer.render(planned.frame, film, checkpoint.as_ref(), &on_progress)?;
        let exposure_ev = self.look.exposure_ev;
        self.warn(planned, &rendered, || LitPixels::of(film, exposure_ev))?;
        Ok(rendered)
    }

    /// Sends the warnings of a traced frame.
    fn warn(
        &mut self,
        planned: &PlannedFrame,
        FrameStatistics { tree, rays, .. }: &FrameStatistics,
        lit: impl FnOnce() -> LitPixels,
    ) -> Result<()> {
        let warnings = self.warnings.of_frame(self.job, planned.frame, tree, rays)?;
        let hint = self.warnings.studio_hint(self.job, rays, lit);
        for warning in warnings.iter().chain(&hint) {
            (self.on_event)(SequenceEvent::Warned(warning));
        }
        Ok(())
    }
}

/// Summary of a run whose writer thread cannot start.
fn no_thread(plan: &Plan, error: &std::io::Error) -> Summary {
    let frame = plan.frames.first().map_or(0, |planned| planned.frame);
    let failed = vec![FailedFrame { frame, error: Error::no_threads(error) }];
    Summary { failed, ..Summary::default() }
}
