//! Checkpoints: the finished passes of a frame, kept in a file beside it until the frame is done.

use std::path::PathBuf;

use crate::error::Result;
use crate::film::PixelWindow;
use crate::image::{Channel, ColorEncoding, Image, Samples};
use crate::image_file::{
    ExrCompression, ExrHeader, FrameAttributes, SAMPLE_RANGE, decode_exr, encode_exr, write_atomically,
};
use crate::output::{SOFTWARE, sum_channels, sums_of_image};
use crate::render::{PathFrame, RenderSettings};

use super::{PlannedFrame, SequenceJob};

/// Text attribute of the samples that are done.
const TAKEN: &str = "samplesTaken";
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
        let mut name = planned.path.file_name()?.to_owned();
        name.push(".checkpoint");
        job.checkpoint.then(|| Self { path: planned.path.with_file_name(name), job, planned })
    }

    /// The stored passes of a frame of `shutter_samples`; `None` where there are none of this frame.
    pub(super) fn load(&self, settings: &RenderSettings, shutter_samples: u32) -> Option<PathFrame> {
        let header = ExrHeader::read(&self.path).ok()?;
        let is_same = header.render_hash().as_deref() == Some(self.planned.render_hash.as_str())
            && header.text(SAMPLE_RANGE) == settings.sample_range_text()
            && header.data_window == settings.window.into();
        let taken = header.text(TAKEN).filter(|_| is_same)?.parse().ok()?;
        let bytes = std::fs::read(&self.path).ok()?;
        let image = decode_exr(&self.path, &bytes, self.job.max_memory_bytes).ok()?;
        let frame = PathFrame::new(settings, shutter_samples);
        let sums = sums_of_image(&image, frame.sums().flags())?;
        let Samples::Uint(finished) = &image.channel(FINISHED)?.samples else { return None };
        frame.resumed(sums, finished.iter().map(|&is_finished| is_finished != 0).collect(), taken)
    }

    /// Removes the file, if it is there.
    pub(super) fn remove(&self) {
        // A file that stays is replaced or ignored by the next run.
        let _ = std::fs::remove_file(&self.path);
    }

    /// Stores the passes of a frame.
    ///
    /// # Errors
    /// Those of writing the file.
    pub(super) fn save(&self, frame: &PathFrame) -> Result<()> {
        let (width, height) = self.job.render.resolution;
        let finished =
            Samples::Uint(frame.finished().iter().map(|&is_finished| is_finished.into()).collect());
        let mut channels = sum_channels(frame.sums());
        channels.push(Channel { name: FINISHED.to_owned(), samples: finished });
        let image = Image {
            display_window: PixelWindow::full(width, height),
            data_window: frame.sums().window,
            encoding: ColorEncoding::Linear,
            channels,
        };
        let mut texts = vec![(TAKEN.to_owned(), frame.taken().to_string())];
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
