//! Renders a shot into a temporary folder, as `rayframe render` does.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::cancel::{CancelFlag, Cancelled};
use crate::error::{Error, Result};
use crate::render::PathSettings;
use crate::sequence::{
    ExistingFiles, OutputPattern, Plan, SequenceJob, SequenceOutputs, Summary, check_whole_frames,
    run as run_sequence,
};

/// The rendered frames of a shot. Dropping it removes the files.
#[derive(Debug)]
pub(super) struct RenderedShot {
    /// All frames in order, each with its file or its error.
    pub(super) frames: Vec<(i64, Result<PathBuf>)>,
    _folder: TempDir,
}

/// Renders all frames of `job`, one EXR file each. Previews, movies and output names of the job are ignored.
///
/// # Errors
/// Errors before the first frame; [`Error::Interrupted`] when cancelled.
pub(super) fn render_shot(job: SequenceJob, cancel: &CancelFlag) -> Result<RenderedShot> {
    check_repeatable(&job)?;
    let folder = tempfile::tempdir().map_err(|source| Error::CannotCreate {
        path: std::env::temp_dir(),
        message: format!("a temporary folder cannot be created: {source}"),
    })?;
    let job = reference_job(job, folder.path())?;
    // Whole images are compared.
    check_whole_frames(&job)?;
    let plan = Plan::new(&job)?;
    plan.prepare()?;
    let summary = run_sequence(&job, &plan, cancel, &|_| {});
    if summary.is_interrupted {
        return Err(Error::Interrupted(Cancelled));
    }
    Ok(RenderedShot { frames: frames(summary), _folder: folder })
}

/// The job that renders references into `folder`: one EXR file a frame, and nothing else.
pub(super) fn reference_job(mut job: SequenceJob, folder: &Path) -> Result<SequenceJob> {
    job.output = pattern_in(folder)?;
    job.preview = false;
    job.sequence_outputs = SequenceOutputs::default();
    job.exr.is_split = false;
    job.checkpoint = false;
    job.exr.is_stamped = false;
    job.exr.lists_content = true;
    job.existing = ExistingFiles::Overwrite;
    job.keep_going = true;
    Ok(job)
}

/// Refuses images that another run would not repeat, or that are not whole.
fn check_repeatable(job: &SequenceJob) -> Result<()> {
    let PathSettings { sample_range, time_limit_seconds, .. } = job.render.path;
    if time_limit_seconds.is_some() {
        return Err(Error::setting(
            "time_limit",
            "makes images depend on the machine's speed; set `samples` or `noise`",
        ));
    }
    if sample_range.is_some() {
        return Err(Error::setting(
            "sample_range",
            "makes parts of images, which are not compared; leave it out",
        ));
    }
    Ok(())
}

fn pattern_in(folder: &Path) -> Result<OutputPattern> {
    let pattern = Path::new(&OutputPattern::escaped(folder)).join("frame.####.exr");
    OutputPattern::parse(pattern.as_os_str()).map_err(|message| Error::Internal { message })
}

fn frames(summary: Summary) -> Vec<(i64, Result<PathBuf>)> {
    let written = summary.written.into_iter().map(|report| {
        // Files do not show these values; only the report counts them.
        let rays = &report.rays;
        let file = match (rays.non_finite_pixels, rays.non_finite_samples) {
            (0, 0) => Ok(report.path),
            (0, count) => {
                Err(Error::Different { message: format!("{count} samples are infinite or not a number") })
            }
            (count, _) => {
                Err(Error::Different { message: format!("{count} pixels are infinite or not a number") })
            }
        };
        (report.frame, file)
    });
    let failed = summary.failed.into_iter().map(|failed| (failed.frame, Err(failed.error)));
    let mut frames: Vec<_> = written.chain(failed).collect();
    frames.sort_by_key(|(frame, _)| *frame);
    frames
}
