//! Checkpoints: the finished passes of a frame, kept in a file beside it until the frame is done.

use std::io::Cursor;
use std::path::PathBuf;

use crate::error::{Error, Result, over_limit};
use crate::film::PixelWindow;
use crate::image::{Channel, ColorEncoding, Image, RenderedScene, Samples};
use crate::image_file::{
    ExrCompression, ExrHeader, ExrIntegrity, FrameAttributes, SAMPLE_RANGE, decode_exr, encode_exr,
    verify_exr, write_atomically,
};
use crate::integrator::Integrator;
use crate::output::{SOFTWARE, sum_channels, sums_of_image};
use crate::render::{PathFrame, RenderSettings, RenderStatistics};

use super::memory::bytes_with_stored_sums;
use super::{PlannedFrame, SequenceJob};

/// Text attribute of the samples that are done.
const TAKEN: &str = "samplesTaken";
/// Text attribute of the statistics of these samples, as JSON.
const STATISTICS: &str = "statistics";
/// Channel of the pixels that take no more samples.
const FINISHED: &str = "finished";

/// The checkpoint of a frame: an OpenEXR file of exact sums.
#[derive(Debug)]
pub(crate) struct Checkpoint<'a> {
    path: PathBuf,
    job: &'a SequenceJob,
    planned: &'a PlannedFrame,
}

impl<'a> Checkpoint<'a> {
    /// The checkpoint of a frame, where the job keeps them.
    pub(super) fn of(job: &'a SequenceJob, planned: &'a PlannedFrame) -> Option<Self> {
        job.checkpoint.then(|| Self { path: planned.checkpoint_path(), job, planned })
    }

    /// The stored passes of a frame of `shutter_samples`, and their statistics; `None` where there are none of this frame.
    ///
    /// # Errors
    /// [`Error::Refused`] where these passes need more memory than the job may use: the next ones would replace them.
    pub(super) fn load(
        &self,
        settings: &RenderSettings,
        shutter_samples: u32,
    ) -> Result<Option<(PathFrame, RenderStatistics)>> {
        let header = ExrHeader::read(&self.path).ok();
        let Some(header) = header.filter(|header| self.is_of_frame(header, settings)) else {
            return Ok(None);
        };
        let remove = Some("remove it to begin anew");
        self.check_memory(header.pixel_bytes(), "continuing this frame", remove)?;
        let Some(image) = self.whole_image()? else { return Ok(None) };
        Ok(continued(&header, &image, PathFrame::new(settings, shutter_samples)))
    }

    /// The image of the file; `None` where it is damaged.
    fn whole_image(&self) -> Result<Option<Image>> {
        let Ok(bytes) = std::fs::read(&self.path) else { return Ok(None) };
        let integrity = verify_exr(&mut Cursor::new(&bytes));
        if !integrity.is_ok_and(|integrity| integrity == ExrIntegrity::Whole) {
            return Ok(None);
        }
        match decode_exr(&self.path, &bytes, self.job.max_memory_bytes) {
            Err(refused @ Error::Refused { .. }) => Err(refused),
            image => Ok(image.ok()),
        }
    }

    /// Refuses passes that take `pixel_bytes` a pixel in the file, where the frame needs more memory with them than the job may use. Nobody
    /// knows before they are traced how many mesh instances pixels show.
    fn check_memory(&self, pixel_bytes: u64, what: &str, instead: Option<&'static str>) -> Result<()> {
        let Some(needed) = bytes_with_stored_sums(self.job, pixel_bytes) else { return Ok(()) };
        let limit = u128::from(self.job.max_memory_bytes);
        if needed <= limit {
            return Ok(());
        }
        let message = format!("{what} needs about {}", over_limit(needed, limit));
        Err(Error::over_memory(&self.path, "", message, instead))
    }

    /// Whether a file with this header holds passes of the frame: of the same image, pixels and samples.
    fn is_of_frame(&self, header: &ExrHeader, settings: &RenderSettings) -> bool {
        header.text(TAKEN).is_some()
            && header.render_hash().as_deref() == Some(self.planned.render_hash.as_str())
            && header.text(SAMPLE_RANGE) == settings.sample_range_text()
            && header.data_window == settings.window.into()
    }

    /// Removes the checkpoint of a frame that is finished: where the job keeps checkpoints any of that name, else the one that an earlier run of
    /// the same frame left.
    pub(super) fn remove_of_finished(job: &'a SequenceJob, planned: &'a PlannedFrame) {
        let checkpoint = Self { path: planned.checkpoint_path(), job, planned };
        if job.checkpoint || checkpoint.is_left_of_frame() {
            // A file that stays is replaced or ignored by the next run.
            let _ = std::fs::remove_file(&checkpoint.path);
        }
    }

    fn is_left_of_frame(&self) -> bool {
        // Neither whitted frames nor movies have any, and links are those of others.
        self.job.render.integrator == Integrator::Path
            && !self.job.output.is_movie()
            && self.path.symlink_metadata().is_ok_and(|metadata| metadata.is_file())
            && ExrHeader::read(&self.path).is_ok_and(|header| self.is_of_frame(&header, &self.job.render))
    }

    /// Stores the passes of a frame.
    ///
    /// # Errors
    /// [`Error::Refused`] where their channels need more memory than the job may use, and the passes before stay; those of writing the file.
    pub(super) fn save(&self, frame: &PathFrame, statistics: &RenderStatistics) -> Result<()> {
        let (width, height) = self.job.render.resolution;
        let finished =
            Samples::Uint(frame.finished().iter().map(|&is_finished| is_finished.into()).collect());
        let mut channels = sum_channels(frame.sums());
        channels.push(Channel { name: FINISHED.to_owned(), samples: finished });
        let pixel_bytes = (channels.len() * size_of::<u32>()) as u64;
        self.check_memory(pixel_bytes, "keeping the passes of this frame", None)?;
        let image = Image {
            display_window: PixelWindow::full(width, height),
            data_window: frame.sums().window,
            encoding: ColorEncoding::Linear,
            channels,
            scene: RenderedScene::default(),
        };
        let statistics = serde_json::to_string(statistics)
            .map_err(|error| Error::Internal { message: error.to_string() })?;
        let mut texts =
            vec![(TAKEN.to_owned(), frame.taken().to_string()), (STATISTICS.to_owned(), statistics)];
        texts.extend(self.job.render.sample_range_text().map(|range| (SAMPLE_RANGE.to_owned(), range)));
        let attributes = FrameAttributes {
            software: SOFTWARE.to_owned(),
            render_hash: self.planned.render_hash.clone(),
            texts,
            ..FrameAttributes::unknown()
        };
        // Sums hardly compress.
        write_atomically(&self.path, &encode_exr(image, ExrCompression::None, &attributes)?)
    }
}

/// `frame` continued by the passes in a file, and their statistics; `None` where the file lacks something.
fn continued(header: &ExrHeader, image: &Image, frame: PathFrame) -> Option<(PathFrame, RenderStatistics)> {
    let taken = header.text(TAKEN)?.parse().ok()?;
    let statistics = serde_json::from_str(&header.text(STATISTICS)?).ok()?;
    let sums = sums_of_image(image, frame.sums().flags())?;
    let Samples::Uint(finished) = &image.channel(FINISHED)?.samples else { return None };
    let finished = finished.iter().map(|&is_finished| is_finished != 0).collect();
    Some((frame.resumed(sums, finished, taken)?, statistics))
}
