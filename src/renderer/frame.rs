//! One frame in memory.

use std::path::Path;
use std::sync::Arc;

use crate::cancel::CancelFlag;
use crate::error::{Result, Warning};
use crate::film::Film;
use crate::image::Image;
use crate::image_file::{FrameAttributes, write_atomically};
use crate::output::{ExrOutput, InstanceIds, exr_files, exr_image, png_file};
use crate::sequence::{
    FrameStatistics, FrameTracer, FrameWarnings, SequenceJob, check_whole_frames, exposure_ev, render_hash,
};

/// A rendered frame in memory: linear colour, alpha and AOVs.
#[derive(Clone, Debug)]
pub struct RenderedFrame {
    job: Arc<SequenceJob>,
    frame: i64,
    film: Film,
    /// The pixels over the plate, where there is one.
    over_plate: Option<Vec<[f32; 4]>>,
    attributes: FrameAttributes,
    instance_ids: Arc<InstanceIds>,
    /// The exposure that the frame was rendered by, if it was.
    exposure_ev: Option<f32>,
    warnings: Vec<Warning>,
    cancel: CancelFlag,
}

impl RenderedFrame {
    pub(crate) fn render(job: Arc<SequenceJob>, frame: i64, cancel: &CancelFlag) -> Result<Self> {
        check_whole_frames(&job)?;
        let mut film = FrameTracer::empty_film(&job);
        let mut tracer = FrameTracer::new(&job, cancel);
        let FrameStatistics { tree, rays, .. } = tracer.render(frame, &mut film, None, &|_| ())?;
        let warnings = FrameWarnings::default().of_frame(&job, frame, &tree, &rays)?;
        let attributes = tracer.attributes(frame, &render_hash(&job, frame));
        let instance_ids = tracer.instance_ids();
        let exposure_ev = tracer.exposure_ev();
        drop(tracer);
        let over_plate = film.plate.as_ref().map(|plate| plate.under(&film.pixels));
        let cancel = cancel.clone();
        Ok(Self { job, frame, film, over_plate, attributes, instance_ids, exposure_ev, warnings, cancel })
    }

    /// Frame number.
    pub fn number(&self) -> i64 {
        self.frame
    }

    /// What was noticed while it was rendered: pixels that were not finite and are black, and a camera that sees nothing.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Columns and rows of [`RenderedFrame::pixels`]: the whole image, or the crop.
    pub fn size(&self) -> (u32, u32) {
        self.film.window.size()
    }

    /// Row-major R, G, B, A, top row first: linear Rec.709 radiance, premultiplied, and coverage.
    pub fn pixels(&self) -> &[[f32; 4]] {
        self.over_plate.as_deref().unwrap_or(&self.film.pixels)
    }

    /// The pixel in column `x` and row `y` from the top left of [`RenderedFrame::pixels`]; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let (width, height) = self.size();
        let is_inside = x < width && y < height;
        is_inside.then(|| self.pixels()[y as usize * width as usize + x as usize])
    }

    /// The channels that [`RenderedFrame::write_exr`] writes, AOVs included, such as `Z` and `normal.X`.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) is a bug.
    pub fn image(&self) -> Result<Image> {
        let image = exr_image(&self.film, &self.exr(), &self.instance_ids)?;
        Ok(Image { scene: self.attributes.rendered_scene(), ..image })
    }

    /// Writes the OpenEXR file that `rayframe render` writes, with all AOVs. An existing file is replaced.
    ///
    /// # Errors
    /// [`Error::CannotCreate`](crate::Error::CannotCreate) and [`Error::WriteFailed`](crate::Error::WriteFailed) with the path.
    pub fn write_exr(&self, path: impl AsRef<Path>) -> Result<()> {
        let files = exr_files(&self.film, &self.attributes, &self.exr(), &self.instance_ids)?;
        write_atomically(path.as_ref(), &files.main)
    }

    /// Writes a tone-mapped sRGB image. Automatic exposure renders a few small frames of the animation, unless the frame was rendered by it.
    ///
    /// # Errors
    /// Those of [`RenderedFrame::write_exr`], and [`Error::Interrupted`](crate::Error::Interrupted) where the flag of
    /// [`Renderer::cancelled_by`](crate::Renderer::cancelled_by) is raised during automatic exposure.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<()> {
        let exposure_ev = match self.exposure_ev {
            Some(ev) => ev,
            None => exposure_ev(&self.job, &self.cancel)?,
        };
        let png = png_file(&self.film, self.job.look(exposure_ev), &self.attributes.render_hash)?;
        write_atomically(path.as_ref(), &png)
    }

    fn exr(&self) -> ExrOutput {
        ExrOutput { is_split: false, ..self.job.exr.clone() }
    }
}
