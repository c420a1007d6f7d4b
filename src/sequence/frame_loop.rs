//! The loop over frames: pose, build, trace, and hand over to be written.
//!
//! While a frame is encoded and written, the next one is posed, built and traced. There are two films, so that the loop is
//! never further ahead than that.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Instant;

use rayon::Scope;

use crate::bvh::BuildStatistics;
use crate::cancel::{CancelFlag, Cancelled};
use crate::error::{Error, Result};
use crate::film::{AovFlags, Film};
use crate::output::{InstanceIds, PreviewLook, frame_attributes, run_stamp};
use crate::render::{RenderStatistics, SceneView, ShutterSample, render_frame_into};

use super::exposure::exposure_ev;
use super::notes::{Notes, depth_note};
use super::posed_frames::PosedFrames;
use super::writer::{HandedOver, Picture, TracedFrame, Writer, empty_film, receive_working};
use super::{
    Exposure, FailedFrame, OutputFormat, Phases, Plan, PlannedFrame, RayReport, SequenceEvent, SequenceJob,
    Summary, TreeReport,
};

/// Films in use: one is traced, one is written.
const FILMS: usize = 2;

/// Renders the frames of `plan` in order, on the current rayon pool, and writes each as soon as it is finished, which
/// overlaps the frame after it.
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
    on_event(SequenceEvent::Started {
        to_render: plan.remaining(),
        kept: plan.frames.len() - plan.remaining(),
    });
    let stop = cancel.inner();
    let mut summary = render_and_write(job, plan, (cancel, &stop), on_event);
    summary.seconds = start.elapsed().as_secs_f64();
    if let Some(warning) = depth_note(&summary, job.render.max_depth) {
        on_event(SequenceEvent::Warned(&warning));
    }
    on_event(SequenceEvent::Finished(&summary));
    summary
}

/// The loop on this thread, the writer on one of its own.
fn render_and_write<'a>(
    job: &'a SequenceJob,
    plan: &'a Plan,
    (cancel, stop): (&'a CancelFlag, &'a CancelFlag),
    on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
) -> Summary {
    let (hand_over, handed_over) = channel();
    let (spent_films, films) = channel();
    for _ in 0..FILMS {
        let _ = spent_films.send(empty_film(job));
    }
    let (settled, when_settled) = channel::<()>();
    let writer = Writer { job, cancel, stop, on_event, spent_films };
    rayon::in_place_scope(|pool| {
        thread::scope(|threads| {
            let settle = move || {
                // Dropped at the end, which is what it is for.
                let _settled = settled;
                writer.settle(handed_over)
            };
            let writing = match thread::Builder::new().spawn_scoped(threads, settle) {
                Ok(writing) => writing,
                Err(error) => return no_thread(plan, &error),
            };
            let frame_loop = FrameLoop {
                job,
                stop,
                on_event,
                pool,
                hand_over,
                films,
                film: None,
                scratch: None,
                look: None,
                shapes: None,
                posed: PosedFrames::default(),
                notes: Notes::default(),
            };
            let reached_the_end = frame_loop.go(plan);
            let _ = receive_working(&when_settled);
            let mut summary = writing.join().unwrap_or_else(|payload| resume_unwind(payload));
            summary.is_interrupted |= !reached_the_end;
            // The failure came first, and stopped the rest.
            summary.is_interrupted &= job.keep_going || summary.failed.is_empty();
            summary
        })
    })
}

/// What lives from frame to frame.
struct FrameLoop<'a, 's, 'p> {
    job: &'a SequenceJob,
    stop: &'a CancelFlag,
    on_event: &'a (dyn Fn(SequenceEvent<'_>) + Sync),
    pool: &'s Scope<'p>,
    hand_over: Sender<HandedOver<'a>>,
    films: Receiver<Film>,
    /// The film of the frame at hand.
    film: Option<Film>,
    /// What the shutter sees at one of several times.
    scratch: Option<Film>,
    look: Option<PreviewLook>,
    /// What the shapes of all frames are called.
    shapes: Option<Arc<InstanceIds>>,
    posed: PosedFrames,
    notes: Notes,
}

/// What making a picture took.
#[derive(Default)]
struct Made {
    /// Of the last time.
    tree: BuildStatistics,
    rays: RenderStatistics,
    /// Whether the hierarchy still fitted at every time.
    is_reused: bool,
    phases: Phases,
}

impl<'a: 'p, 'p> FrameLoop<'a, '_, 'p> {
    /// All frames up to the last one, the first failure, or a raised flag; tells whether there was no flag.
    fn go(mut self, plan: &'a Plan) -> bool {
        for planned in &plan.frames {
            if self.stop.is_raised() {
                return false;
            }
            let handed_over = match self.guarded(planned) {
                Ok(handed_over) => handed_over,
                Err(Error::Interrupted(_)) => return false,
                Err(error) => HandedOver::Failed(planned, error),
            };
            let is_last = matches!(handed_over, HandedOver::Failed(..)) && !self.job.keep_going;
            if self.hand_over.send(handed_over).is_err() {
                // The writer has ended the run.
                return false;
            }
            if is_last {
                break;
            }
        }
        true
    }

    /// One frame with panics turned into errors.
    fn guarded(&mut self, planned: &'a PlannedFrame) -> Result<HandedOver<'a>> {
        catch_unwind(AssertUnwindSafe(|| self.one(planned))).unwrap_or_else(|payload| {
            // What the panic left half made must not reach the next frame.
            self.posed = PosedFrames::default();
            Err(panic_error(planned.frame, payload.as_ref()))
        })
    }

    fn one(&mut self, planned: &'a PlannedFrame) -> Result<HandedOver<'a>> {
        if planned.is_done {
            let look = if planned.preview_path.is_some() { Some(self.look()?) } else { None };
            return Ok(HandedOver::Kept(planned, look));
        }
        (self.on_event)(SequenceEvent::FrameStarted(planned));
        let started = Instant::now();
        let mut seconds = Phases::default();

        let look = self.look()?;

        // Wait until the frame before the last is written.
        let waiting = Instant::now();
        let mut film = match self.film.take() {
            Some(film) => film,
            None => receive_working(&self.films).ok_or(Cancelled)?,
        };
        seconds.wait = waiting.elapsed().as_secs_f64();

        // Pose, build and trace.
        let made = match self.make(planned, &mut film) {
            Ok(made) => made,
            Err(error) => {
                self.film = Some(film);
                return Err(error);
            }
        };
        let Made { tree, rays, is_reused, phases } = made;
        seconds = Phases { wait: seconds.wait, trace: rays.trace_seconds, ..phases };

        // Hand over.
        let camera = &self.posed.camera_at(self.job, planned.time_seconds);
        let mut attributes = frame_attributes(
            planned.frame,
            planned.time_seconds,
            self.job.rate.as_exr_rational(),
            &planned.render_hash,
            (camera, film.resolution),
        );
        if self.job.exr.is_stamped {
            attributes.stamp = Some(run_stamp(seconds.of_making()));
        }
        let format = self.job.output.format();
        let (exr, shapes) = (&self.job.exr, self.shapes());
        Ok(HandedOver::Traced(Box::new(TracedFrame {
            planned,
            started,
            seconds,
            tree: TreeReport::new(&tree, self.job.build.builder, is_reused),
            rays: RayReport::new(&rays),
            encoded: Picture { planned, film, attributes, look, format, exr, shapes }.encode_in(self.pool),
        })))
    }

    /// Makes the picture: the mean of what the open shutter sees at each of its times, or what there is at the frame's one time.
    fn make(&mut self, planned: &PlannedFrame, film: &mut Film) -> Result<Made> {
        let times = self.job.shutter.times(planned.time_seconds, self.job.rate);
        let mut made = Made { is_reused: true, ..Made::default() };
        for (index, &time_seconds) in times.iter().enumerate() {
            // Pose the scene and build its hierarchy, unless the last one still fits.
            let mut phases = Phases::default();
            made.is_reused &= self.posed.advance(self.job, time_seconds, self.stop, &mut phases)?;
            made.phases.add(&phases);

            let pass = ShutterSample { index: index as u32, count: times.len() as u32 };
            let (tree, rays) = if index == 0 {
                self.trace(planned, film, pass)?
            } else {
                let mut scratch = self.scratch.take().unwrap_or_else(|| {
                    let summed = AovFlags { centers: false, ..film.aovs.flags() };
                    Film::with_aovs(film.resolution, film.window, summed)
                });
                let traced = self.trace(planned, &mut scratch, pass);
                film.add(&scratch);
                self.scratch = Some(scratch);
                traced?
            };
            made.tree = tree;
            made.rays.add(&rays);
        }
        if times.len() > 1 {
            film.scale(1.0 / times.len() as f32);
        }
        if film.aovs.centers.is_some() {
            let phases = self.posed.record_centres(self.job, planned, film, self.stop)?;
            made.phases.add(&phases);
            made.rays.trace_seconds += phases.trace;
        }
        for warning in self.notes.of_frame(self.job, planned, &made.tree, &made.rays)? {
            (self.on_event)(SequenceEvent::Warned(&warning));
        }
        Ok(made)
    }

    /// Traces the scene as it is posed.
    fn trace(
        &mut self,
        planned: &PlannedFrame,
        film: &mut Film,
        pass: ShutterSample,
    ) -> Result<(BuildStatistics, RenderStatistics)> {
        let Some(bvh) = &self.posed.bvh else {
            return Err(Error::Internal { message: "there is no hierarchy to trace".to_owned() });
        };
        let input = SceneView {
            scene: &self.job.scene,
            frame: &self.posed.current,
            bvh,
            environment: &self.job.environment,
        };
        let on_event = self.on_event;
        let on_progress = |share: f32| {
            let share = (pass.index as f32 + share) / pass.count as f32;
            on_event(SequenceEvent::FrameProgress(planned, share));
        };
        let rays = render_frame_into(film, &input, &self.job.render, pass, self.stop, &on_progress)?;
        Ok((bvh.statistics(), rays))
    }

    /// How tone-mapped files look; found once, and only when there are any.
    fn look(&mut self) -> Result<PreviewLook> {
        if let Some(look) = self.look {
            return Ok(look);
        }
        let is_needed = self.job.preview || self.job.output.format() == OutputFormat::Png;
        let exposure_ev = if is_needed { exposure_ev(self.job, self.stop)? } else { 0.0 };
        if is_needed {
            let is_automatic = self.job.exposure == Exposure::Auto;
            (self.on_event)(SequenceEvent::ExposureFound { ev: exposure_ev, is_automatic });
        }
        let tone = self.job.tone;
        Ok(*self.look.insert(PreviewLook { exposure_ev, tone }))
    }

    /// What the shapes are called; found once, and only when a layer tells.
    fn shapes(&mut self) -> Arc<InstanceIds> {
        let layers = &self.job.exr.aovs;
        let frame = &self.posed.current;
        let find = || {
            if self.job.exr.needs_instances() {
                Arc::new(InstanceIds::new(&self.job.scene, &frame.instances, layers))
            } else {
                Arc::default()
            }
        };
        self.shapes.get_or_insert_with(find).clone()
    }
}

/// The summary of a run whose writer cannot even begin.
fn no_thread(plan: &Plan, error: &std::io::Error) -> Summary {
    let message = format!("the threads cannot be started: {error}");
    let frame = plan.frames.first().map_or(0, |planned| planned.frame);
    let failed = vec![FailedFrame { frame, error: Error::Internal { message } }];
    Summary { failed, ..Summary::default() }
}

/// What a panic while `frame` was made is told as.
pub(super) fn panic_error(frame: i64, payload: &(dyn Any + Send)) -> Error {
    let text = payload
        .downcast_ref::<&str>()
        .map(ToString::to_string)
        .or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "a worker panicked".to_owned());
    Error::Internal { message: format!("frame {frame}: {text}") }
}
