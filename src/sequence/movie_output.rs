//! A movie as the output of a run: frames go to it as they are rendered, and no other file holds them.

use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::image_file::DisplayImage;

use super::joint_files::JointFiles;
use super::{Plan, SequenceEvent, SequenceJob};

/// Movie, and the contact sheet beside it, to which frames are added in their order. The files exist when the last frame is added.
pub(super) struct MovieOutput<'a> {
    job: &'a SequenceJob,
    frames: u32,
    added: u32,
    files: Option<JointFiles<'a>>,
    cancel: &'a CancelFlag,
}

impl<'a> MovieOutput<'a> {
    /// The movie of `plan`; `None` where the output is not a movie.
    pub(super) fn new(job: &'a SequenceJob, plan: &Plan, cancel: &'a CancelFlag) -> Option<Self> {
        let frames = plan.frames.len() as u32;
        job.output.is_movie().then_some(Self { job, frames, added: 0, files: None, cancel })
    }

    /// Adds a frame. The first one creates the file, the last one completes it.
    pub(super) fn add(
        &mut self,
        frame: i64,
        image: &DisplayImage,
        on_event: &dyn Fn(SequenceEvent<'_>),
    ) -> Result<()> {
        if self.job.sequence_outputs.shows_frames {
            on_event(SequenceEvent::FrameImage(image));
        }
        let mut files = if let Some(files) = self.files.take() {
            files
        } else {
            JointFiles::begin(self.job, Some(&self.job.output.path(frame)), self.frames, self.cancel)?
        };
        files.add(frame, image)?;
        self.added += 1;
        if self.added == self.frames {
            for warning in &files.finish()? {
                on_event(SequenceEvent::Warned(warning));
            }
            return Ok(());
        }
        self.files = Some(files);
        Ok(())
    }
}
