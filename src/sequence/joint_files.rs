//! Files that all frames of a sequence make together: movie and contact sheet.

use std::path::Path;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result, Warning};
use crate::image_file::{
    CONTACT_SHEET, DisplayImage, MovieFormat, MovieWriter, encode_png, write_atomically,
};
use crate::output::ContactSheet;

use super::SequenceJob;

/// Movie and contact sheet to which frames are added in their order. Dropping it leaves nothing under the final names.
pub(super) struct JointFiles<'a> {
    movie: Option<MovieWriter>,
    sheet: Option<(&'a Path, ContactSheet)>,
}

impl<'a> JointFiles<'a> {
    /// Begins the `movie`, and the contact sheet of `job`, for `frames` frames.
    ///
    /// # Errors
    /// Those of [`MovieWriter::begin`].
    pub(super) fn begin(
        job: &'a SequenceJob,
        movie: Option<&Path>,
        frames: u32,
        cancel: &CancelFlag,
    ) -> Result<Self> {
        let size = job.render.window.size();
        let movie = match movie {
            Some(path) => {
                let format = MovieFormat::of_path(path).ok_or_else(|| Error::Internal {
                    message: format!("\"{}\" is no movie, and was not refused", path.display()),
                })?;
                let (numerator, denominator) = job.rate.as_exr_rational();
                let rate = (numerator.unsigned_abs(), denominator);
                Some(MovieWriter::begin(path, format, size, rate, frames, cancel)?)
            }
            None => None,
        };
        let sheet = job.sequence_outputs.contact_sheet.as_deref();
        Ok(Self { movie, sheet: sheet.map(|path| (path, ContactSheet::new(frames, size))) })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// Those of [`MovieWriter::add`].
    pub(super) fn add(&mut self, frame: i64, image: &DisplayImage) -> Result<()> {
        if let Some(movie) = &mut self.movie {
            movie.add(&image.pixels)?;
        }
        if let Some((_, sheet)) = &mut self.sheet {
            sheet.add(frame, image);
        }
        Ok(())
    }

    /// Completes the files under their names. Returns what the movie does not keep of its frames.
    ///
    /// # Errors
    /// Those of writing them.
    pub(super) fn finish(self) -> Result<Vec<Warning>> {
        let warnings = self.movie.as_ref().map(MovieWriter::warnings).unwrap_or_default();
        if let Some(movie) = self.movie {
            movie.finish()?;
        }
        if let Some((path, sheet)) = self.sheet {
            let DisplayImage { size, pixels } = sheet.image();
            write_atomically(path, &encode_png(*size, pixels, CONTACT_SHEET)?)?;
        }
        Ok(warnings)
    }
}
