//! A movie as the output of a run: frames go to it as they are rendered, and no other file holds them.

use crate::error::{Error, Result};
use crate::image_file::DisplayImage;
use crate::output::ExrOutput;

use super::joint_files::JointFiles;
use super::{ExistingFiles, OutputFormat, Plan, SequenceEvent, SequenceJob};

/// Movie, and the contact sheet beside it, to which frames are added in their order. The files exist when the last frame is added.
pub(super) struct MovieOutput<'a> {
    job: &'a SequenceJob,
    frames: u32,
    added: u32,
    files: Option<JointFiles<'a>>,
}

impl<'a> MovieOutput<'a> {
    /// The movie of `plan`; `None` where the output is not a movie.
    pub(super) fn new(job: &'a SequenceJob, plan: &Plan) -> Option<Self> {
        let frames = plan.frames.len() as u32;
        job.output.is_movie().then_some(Self { job, frames, added: 0, files: None })
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
        let mut files = match self.files.take() {
            Some(files) => files,
            None => {
                let path = self.job.output.path(frame);
                JointFiles::begin(self.job, Some(&path), self.frames)?
            }
        };
        files.add(frame, image)?;
        self.added += 1;
        if self.added == self.frames {
            return files.finish();
        }
        self.files = Some(files);
        Ok(())
    }
}

/// Refuses settings that a movie as the output has no place for.
pub(super) fn check_movie(job: &SequenceJob) -> Result<()> {
    let OutputFormat::Movie(format) = job.output.format() else {
        return Ok(());
    };
    let refused = |setting, why: &str| Err(Error::setting(setting, why));
    if job.sequence_outputs.movie.is_some() {
        return refused("movie", "`output` names a movie already; leave one of the two out");
    }
    if job.preview {
        return refused("preview", "adds previews to EXR files, but `output` names a movie; leave it out");
    }
    if job.exr != ExrOutput::default() {
        return refused(
            "output",
            "`aovs`, `exr`, `split_aovs` and `stamp` apply to EXR files, but this names a movie; name frames such as \
             shot.####.exr here, and the movie with `movie`",
        );
    }
    if job.output.has_layer_place() {
        return refused("output", "{layer} is the name of an AOV, which a movie does not hold; leave it out");
    }
    if job.existing == ExistingFiles::Resume {
        return refused(
            "resume",
            "keeps finished frames, but a movie is made as a whole; name frames such as shot.####.exr with `output`, and \
             the movie with `movie`",
        );
    }
    if job.keep_going {
        return refused("keep_going", "a movie needs all frames; leave it out, or name frames with `output`");
    }
    format.check(job.render.window.size()).map_err(|why| Error::setting("output", why))
}
