//! A frame that is rendered in bands of rows, and written to temporary files meanwhile.

use std::sync::Arc;
use std::time::Instant;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::image_file::{FrameAttributes, WrittenExr};
use crate::output::{ExrBandFiles, InstanceIds, run_stamp};

use super::bands::bands;
use super::frame_tracer::{FrameStatistics, FrameTracer, OnProgress};
use super::frame_warnings::LitPixels;
use super::{FrameProgress, PlannedFrame, SequenceJob};

/// A frame whose bands are traced, encoded and written.
pub(super) struct BandedFrame {
    files: ExrBandFiles,
    attributes: FrameAttributes,
    instance_ids: Arc<InstanceIds>,
    /// Seconds of encoding and writing.
    seconds: f64,
}

/// What tracing a frame in bands gives besides its files.
pub(super) struct BandedResult {
    pub(super) frame: BandedFrame,
    pub(super) statistics: FrameStatistics,
    pub(super) lit: LitPixels,
}

impl BandedFrame {
    /// Renders a frame in bands of `rows`. Pixels are counted as lit at `exposure_ev`.
    pub(super) fn render(
        job: &SequenceJob,
        tracer: &mut FrameTracer<'_>,
        (planned, rows): (&PlannedFrame, u32),
        exposure_ev: f32,
        on_progress: OnProgress<'_>,
    ) -> Result<BandedResult> {
        let settings = &job.render;
        let mut files =
            ExrBandFiles::new(settings.window, &job.exr, planned.path.clone(), &planned.aov_paths);
        let mut statistics = FrameStatistics { is_reused: true, ..FrameStatistics::default() };
        let (mut lit, mut seconds) = (LitPixels::default(), 0.0);
        let (mut attributes, mut film_of_band_before) = (None, None);
        for window in bands(settings.window, rows) {
            let before = f64::from(window.y0 - settings.window.y0);
            let on_band = |progress: FrameProgress| {
                let rows = before + f64::from(progress.share) * f64::from(window.height());
                let share = (rows / f64::from(settings.window.height())) as f32;
                on_progress(FrameProgress { share, path: None });
            };
            // Bands of one height share a film.
            let used = film_of_band_before.take().filter(|film: &Film| film.window.size() == window.size());
            let new = || Film::with_aovs(settings.resolution, window, settings.aovs);
            let mut film = used.map_or_else(new, |film| Film { window, sums: None, ..film });
            statistics.add(&tracer.render(planned.frame, &mut film, None, &on_band)?);
            lit.add(&LitPixels::of(&film, exposure_ev));

            let writing = Instant::now();
            let attributes =
                attributes.get_or_insert_with(|| tracer.attributes(planned.frame, &planned.render_hash));
            stamp(attributes, job, &statistics);
            files.write(&film, attributes, &tracer.instance_ids())?;
            seconds += writing.elapsed().as_secs_f64();
            film_of_band_before = Some(film);
        }
        let Some(attributes) = attributes else {
            return Err(Error::Internal { message: "a frame has no rows".to_owned() });
        };
        let frame = Self { files, attributes, instance_ids: tracer.instance_ids(), seconds };
        Ok(BandedResult { frame, statistics, lit })
    }

    /// Completes the files. Returns what was written to the main file and to those of AOVs, and the seconds that encoding and writing took
    /// before.
    pub(super) fn finish(self, cancel: &CancelFlag) -> Result<(Option<WrittenExr>, Vec<WrittenExr>, f64)> {
        let Self { files, attributes, instance_ids, seconds } = self;
        let (main, aovs) = files.finish(&attributes, &instance_ids, cancel)?;
        Ok((main, aovs, seconds))
    }
}

/// Stamps the attributes of a frame, where the job asks for it.
fn stamp(attributes: &mut FrameAttributes, job: &SequenceJob, statistics: &FrameStatistics) {
    if job.exr.is_stamped {
        let seconds = statistics.phases.render_seconds() + statistics.rays.trace_seconds;
        attributes.stamp = Some(run_stamp(seconds));
    }
}
