//! Outputs of a sequence as a whole: movie, contact sheet, frames on the terminal.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::image_file::{MOVIE_ENDINGS, MovieFormat};

/// Outputs made of all frames together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SequenceOutputs {
    /// Movie of all frames.
    pub movie: Option<PathBuf>,
    /// PNG image with small versions of all frames.
    pub contact_sheet: Option<PathBuf>,
    /// Whether a frame is shown on a contact sheet of several sequences, which the caller makes.
    pub is_on_common_sheet: bool,
    /// Whether finished frames are shown on the terminal.
    pub shows_frames: bool,
}

impl SequenceOutputs {
    /// Whether any of them tone-maps frames.
    pub fn needs_tone_mapping(&self) -> bool {
        self.movie.is_some() || self.contact_sheet.is_some() || self.is_on_common_sheet || self.shows_frames
    }

    /// The files, each with the setting that requests it.
    pub fn files(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        let movie = self.movie.as_deref().map(|path| (path, "movie"));
        movie.into_iter().chain(self.contact_sheet.as_deref().map(|path| (path, "contact_sheet")))
    }

    /// Checks names and tools before the first frame; `size` is that of the frames.
    ///
    /// # Errors
    /// [`Error::Setting`] for a name with an unknown ending, for a film format where `ffmpeg` is not installed, and for frames that are
    /// too large for the format.
    pub fn check(&self, size: (u32, u32)) -> Result<()> {
        if let Some(path) = &self.movie {
            match MovieFormat::of_path(path) {
                None => {
                    return Err(Error::setting(
                        "movie",
                        format!("\"{}\" does not end in {MOVIE_ENDINGS}", path.display()),
                    ));
                }
                Some(format) => format.check(size).map_err(|why| Error::setting("movie", why))?,
            }
        }
        match &self.contact_sheet {
            Some(path) if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) => {
                Err(Error::setting("contact_sheet", format!("\"{}\" does not end in .png", path.display())))
            }
            _ => Ok(()),
        }
    }
}
