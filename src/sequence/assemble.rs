//! Movie and contact sheet of a finished sequence.
//!
//! Both are made from the frames' files, so that they include frames of earlier runs.

use std::path::PathBuf;

use rayon::prelude::*;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result, Warning};
use crate::image_file::{DisplayImage, decode_png};
use crate::output::PreviewLook;

use super::joint_files::JointFiles;
use super::stored_frame::display_exr;
use super::{OutputFormat, Plan, PlannedFrame, SequenceJob, SequenceOutputs};

/// Writes the movie and the contact sheet of `job` from the frames of `plan`, in the order of their numbers. All frames must
/// exist. Returns the paths, and what the movie does not keep of its frames.
///
/// # Errors
/// Those of reading the frames and writing the files; [`Error::Interrupted`] when `cancel` is raised.
pub fn write_sequence_outputs(
    job: &SequenceJob,
    plan: &Plan,
    look: PreviewLook,
    cancel: &CancelFlag,
) -> Result<(Vec<PathBuf>, Vec<Warning>)> {
    let mut frames: Vec<&PlannedFrame> = plan.frames.iter().collect();
    frames.sort_by_key(|planned| planned.frame);
    let SequenceOutputs { movie, contact_sheet, .. } = &job.sequence_outputs;
    let paths: Vec<_> = job.sequence_outputs.files().map(|(path, _)| path.to_owned()).collect();
    if job.output.is_movie() {
        // The frames went to these files as they were rendered.
        return Ok((paths, Vec::new()));
    }
    if frames.is_empty() || (movie.is_none() && contact_sheet.is_none()) {
        return Ok((Vec::new(), Vec::new()));
    }
    let mut files = JointFiles::begin(job, movie.as_deref(), frames.len() as u32, cancel)?;

    let at_once = frames_at_once(frame_bytes(job), job.max_memory_bytes, rayon::current_num_threads());
    for group in frames.chunks(at_once) {
        cancel.check()?;
        let images: Vec<_> =
            group.par_iter().map(|planned| display_frame(job, planned, look)).collect::<Result<_>>()?;
        for (planned, image) in group.iter().zip(images) {
            files.add(planned.frame, &image)?;
        }
    }
    Ok((paths, files.finish()?))
}

/// Number of frames read at a time: one a thread, but no more than fit into memory together.
fn frames_at_once(frame_bytes: u64, max_memory_bytes: u64, threads: usize) -> usize {
    let fitting = max_memory_bytes / frame_bytes.max(1);
    usize::try_from(fitting).map_or(threads, |fitting| fitting.min(threads)).max(1)
}

/// Bytes that reading a frame needs.
fn frame_bytes(job: &SequenceJob) -> u64 {
    /// Linear pixel, and display pixel.
    const BYTES_A_PIXEL: u64 = 16 + 4;
    let (width, height) = job.render.window.size();
    // The file and its decoded channels.
    let channels = 2 * job.exr.bytes_a_pixel();
    let plate = job.plates.as_ref().map_or(0, |plates| plates.working_bytes(job.render.window));
    let plate = u64::try_from(plate).unwrap_or(u64::MAX);
    (u64::from(width) * u64::from(height)).saturating_mul(BYTES_A_PIXEL + channels).saturating_add(plate)
}

/// Reads the frame's file as a display image.
///
/// # Errors
/// Those of reading the file.
pub fn display_frame(job: &SequenceJob, planned: &PlannedFrame, look: PreviewLook) -> Result<DisplayImage> {
    match job.output.format() {
        OutputFormat::Exr => display_exr(job, planned, look),
        OutputFormat::Png | OutputFormat::Movie(_) => {
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
        // One is read in any case. Reading it checks memory by itself.
        assert_eq!(frames_at_once(2000, 1000, 8), 1);
        assert_eq!(frames_at_once(0, u64::MAX, 8), 8);
    }
}
