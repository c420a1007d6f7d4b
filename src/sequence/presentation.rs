//! What is made of a whole sequence once its frames are there: a movie, a contact sheet.
//!
//! Both are made from the files, so that frames of earlier runs are in them, too.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{
    DisplayImage, MOVIE_ENDINGS, MovieFormat, MovieWriter, decode_png, encode_png, has_ffmpeg,
    write_atomically,
};
use crate::output::{ContactSheet, PreviewLook, display_picture};

use super::exposure::exposure_ev;
use super::writer::read_frame;
use super::{OutputFormat, Plan, PlannedFrame, SequenceJob};

/// What is made beside the frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Presentation {
    /// All frames as one file that plays.
    pub movie: Option<PathBuf>,
    /// All frames in one PNG picture.
    pub contact_sheet: Option<PathBuf>,
    /// Whether frames are shown when they are finished.
    pub shows_frames: bool,
}

impl Presentation {
    /// Whether anything is tone-mapped for it.
    pub fn needs_look(&self) -> bool {
        self.movie.is_some() || self.contact_sheet.is_some() || self.shows_frames
    }

    /// The files it makes, each with the option that asks for it.
    pub fn files(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        let movie = self.movie.as_deref().map(|path| (path, "--movie"));
        movie.into_iter().chain(self.contact_sheet.as_deref().map(|path| (path, "--contact-sheet")))
    }

    /// Finds before the first frame what cannot be made.
    ///
    /// # Errors
    /// [`Error::Usage`] for a name whose ending says nothing, and for a film where there is no `ffmpeg`.
    pub fn check(&self) -> Result<()> {
        if let Some(path) = &self.movie {
            match MovieFormat::of_path(path) {
                None => {
                    let message = format!("--movie: \"{}\" does not end in {MOVIE_ENDINGS}", path.display());
                    return Err(Error::usage(message));
                }
                Some(MovieFormat::Film { .. }) if !has_ffmpeg() => {
                    return Err(Error::usage(
                        "--movie: films are made by ffmpeg, which is not installed here; write .apng or .gif, which need nothing",
                    ));
                }
                Some(_) => {}
            }
        }
        match &self.contact_sheet {
            Some(path) if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) => {
                Err(Error::usage(format!("--contact-sheet: \"{}\" does not end in .png", path.display())))
            }
            _ => Ok(()),
        }
    }
}

/// How tone-mapped files of `job` look. An automatic exposure is found anew at each call, always the same.
///
/// # Errors
/// [`Error::Interrupted`] when `cancel` is raised.
pub fn find_look(job: &SequenceJob, cancel: &CancelFlag) -> Result<PreviewLook> {
    Ok(PreviewLook { exposure_ev: exposure_ev(job, cancel)?, tone: job.tone })
}

/// Makes what `job.presentation` asks for of the frames of `plan`, which are all there, in the order of their numbers. Returns the files.
///
/// # Errors
/// Those of reading the frames and writing the files; [`Error::Interrupted`] when `cancel` is raised.
pub fn present(
    job: &SequenceJob,
    plan: &Plan,
    look: PreviewLook,
    cancel: &CancelFlag,
) -> Result<Vec<PathBuf>> {
    let mut frames: Vec<&PlannedFrame> = plan.frames.iter().collect();
    frames.sort_by_key(|planned| planned.frame);
    let Presentation { movie, contact_sheet, .. } = &job.presentation;
    if frames.is_empty() || (movie.is_none() && contact_sheet.is_none()) {
        return Ok(Vec::new());
    }
    let size = (job.render.window.width(), job.render.window.height());
    let count = frames.len() as u32;
    let mut film = match movie {
        Some(path) => {
            let format = MovieFormat::of_path(path).unwrap_or(MovieFormat::AnimatedPng);
            let (numerator, denominator) = job.rate.as_exr_rational();
            let rate = (numerator.unsigned_abs(), denominator);
            Some(MovieWriter::begin(path, format, size, rate, count)?)
        }
        None => None,
    };
    let mut sheet = contact_sheet.as_ref().map(|_| ContactSheet::new(count, size));

    let at_once = frames_at_once(frame_bytes(job), job.max_memory_bytes, rayon::current_num_threads());
    for group in frames.chunks(at_once) {
        cancel.check()?;
        let pictures: Vec<_> =
            group.par_iter().map(|planned| shown(job, planned, look)).collect::<Result<_>>()?;
        for (planned, picture) in group.iter().zip(pictures) {
            if let Some(film) = &mut film {
                film.add(&picture.pixels)?;
            }
            if let Some(sheet) = &mut sheet {
                sheet.add(planned.frame, &picture);
            }
        }
    }

    if let Some(film) = film {
        film.finish()?;
    }
    if let (Some(path), Some(sheet)) = (contact_sheet, sheet) {
        let DisplayImage { size, pixels } = sheet.picture();
        write_atomically(path, &encode_png(*size, pixels, "contact sheet")?)?;
    }
    Ok(job.presentation.files().map(|(path, _)| path.to_owned()).collect())
}

/// As many frames as there are threads, but no more than fit into memory together.
fn frames_at_once(frame_bytes: u64, max_memory_bytes: u64, threads: usize) -> usize {
    let fitting = max_memory_bytes / frame_bytes.max(1);
    usize::try_from(fitting).map_or(threads, |fitting| fitting.min(threads)).max(1)
}

/// What reading a frame needs.
fn frame_bytes(job: &SequenceJob) -> u64 {
    /// A pixel as it is handed on, and as a display shows it.
    const BYTES_A_PIXEL: u64 = 16 + 4;
    let (width, height) = (job.render.window.width(), job.render.window.height());
    // The file, and what is decoded of it.
    let layers = 2 * job.exr.bytes_a_pixel();
    (u64::from(width) * u64::from(height)).saturating_mul(BYTES_A_PIXEL + layers)
}

/// The frame's file as a display shows it.
///
/// # Errors
/// Those of reading it.
pub fn shown(job: &SequenceJob, planned: &PlannedFrame, look: PreviewLook) -> Result<DisplayImage> {
    match job.output.format() {
        OutputFormat::Exr => {
            let (size, pixels) = read_frame(&planned.path, job.max_memory_bytes)?;
            Ok(display_picture(size, &pixels, look))
        }
        OutputFormat::Png => {
            let bytes = std::fs::read(&planned.path).map_err(Error::missing(&planned.path))?;
            decode_png(&planned.path, &bytes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_frames_are_read_at_once_than_fit_into_memory() {
        assert_eq!(frames_at_once(100, 1000, 8), 8);
        assert_eq!(frames_at_once(300, 1000, 8), 3);
        // One is read in any case; reading it checks by itself.
        assert_eq!(frames_at_once(2000, 1000, 8), 1);
        assert_eq!(frames_at_once(0, u64::MAX, 8), 8);
    }
}
