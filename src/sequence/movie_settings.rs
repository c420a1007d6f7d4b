//! Settings that go with a movie as the output.

use crate::error::{Error, Result};
use crate::output::ExrOutput;

use super::{ExistingFiles, OutputFormat, SequenceJob};

/// Refuses settings that a movie as the output has no place for.
pub(super) fn check_movie(job: &SequenceJob) -> Result<()> {
    let OutputFormat::Movie(format) = job.output.format() else {
        return Ok(());
    };
    let refused = |setting, why: &str| Err(Error::setting(setting, why));
    if job.sequence_outputs.movie.is_some() {
        return refused("movie", "`output` names a movie already; leave one of the two out");
    }
    if job.checkpoint {
        return refused(
            "checkpoint",
            "keeps passes of frames, but `output` names a movie, which is made as a whole",
        );
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
    format.check(job.render.window.size()).map_err(|why| Error::setting("output", why))
}
