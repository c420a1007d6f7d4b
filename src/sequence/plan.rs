//! The plan of a run: frames, file names and existing files, with all checks that need no rendering.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::film::AovFlags;
use crate::image_file::{
    OutputKind, check_name, check_new_names, check_output, probe_folder, remove_stale_temporaries,
};
use crate::output::ExrOutput;
use crate::settings::PlatePattern;

use super::file_stamp::FileStamp;
use super::movie_settings::check_movie;
use super::resume::{Decision, ReplacedFile, decide, preview_in_the_way};
use super::{ExistingFiles, OutputFormat, RenderHashes, SequenceJob, memory};

/// A frame to render, and its files.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFrame {
    /// Frame number.
    pub frame: i64,
    /// Scene time, seconds.
    pub time_seconds: f64,
    /// The frame's main file, or the movie of all frames.
    pub path: PathBuf,
    /// Files of split AOVs, in the order of [`crate::output::ExrOutput::split_aovs`].
    pub aov_paths: Vec<PathBuf>,
    /// Tone-mapped PNG preview.
    pub preview_path: Option<PathBuf>,
    /// Hash of the scene, the settings and the version.
    pub render_hash: String,
    /// Whether all files but the preview exist and are complete.
    pub is_done: bool,
}

impl PlannedFrame {
    /// Paths of all files of the frame. All frames of a movie have the same.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let others = self.aov_paths.iter().chain(&self.preview_path);
        std::iter::once(&self.path).chain(others).map(PathBuf::as_path)
    }

    /// Path of the frame's checkpoint.
    pub(super) fn checkpoint_path(&self) -> PathBuf {
        let mut name = self.path.file_name().unwrap_or_default().to_owned();
        name.push(".checkpoint");
        self.path.with_file_name(name)
    }
}

/// Frames of a run in the order of rendering.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The frames.
    pub frames: Vec<PlannedFrame>,
    /// Existing files with other content that frames and previews replace.
    pub replaced: Vec<ReplacedFile>,
    /// Whether frames have checkpoints beside them.
    pub keeps_checkpoints: bool,
    /// Rows of the bands that frames are rendered in, where a whole frame needs more memory than the limit. A multiple of 256 fits every
    /// compression.
    pub band_rows: Option<u32>,
    is_movie: bool,
    /// The names of plates, of other frames, too.
    pub(super) plates: Option<PlatePattern>,
    /// The file of each frame as it was before it was looked at.
    stamps: Vec<Option<FileStamp>>,
}

impl Plan {
    /// Checks names, memory and existing files; creates nothing.
    ///
    /// # Errors
    /// [`Error::Setting`] when frames would share a name or a file has an unknown ending, [`Error::Refused`] when memory does not suffice, and
    /// [`Error::CannotCreate`] when a file with other content has a frame's name, or a file of another program that of the movie or of a checkpoint.
    pub fn new(job: &SequenceJob) -> Result<Self> {
        let band_rows = Self::check(job)?;
        let is_movie = job.output.is_movie();
        let hashes = RenderHashes::new(job);
        let inspect = |&frame: &i64| inspect_frame(job, frame, hashes.of(frame));
        let mut inspected: Vec<_> = job.frames.par_iter().map(inspect).collect();
        if is_movie {
            // A movie shows its frames in the order of time.
            inspected.sort_by_key(|inspected| inspected.planned.frame);
        }
        let (mut frames, mut stamps, mut replaced) = (Vec::new(), Vec::new(), Vec::new());
        for InspectedFrame { planned, stamp, in_the_way } in inspected {
            frames.push(planned);
            stamps.push(stamp);
            replaced.extend(in_the_way);
        }
        let overwrites = job.existing == ExistingFiles::Overwrite;
        if job.checkpoint {
            for frame in &frames {
                check_output(&frame.checkpoint_path(), OutputKind::Checkpoint, overwrites)?;
            }
        }
        match frames.first() {
            Some(first) if is_movie => {
                check_output(&first.path, OutputKind::Movie, overwrites)?;
            }
            _ => refuse_shared_names(&frames)?,
        }
        refuse_to_replace(&replaced, job.existing)?;
        Ok(Self {
            frames,
            replaced,
            keeps_checkpoints: job.checkpoint,
            band_rows,
            is_movie,
            plates: job.plates.as_ref().map(|plates| plates.pattern().clone()),
            stamps,
        })
    }

    /// The checks of [`Plan::new`] that need neither the camera nor the environment nor existing files. Returns the rows of bands, where the
    /// memory does not suffice for whole frames.
    ///
    /// # Errors
    /// Those of [`Plan::new`] but the last.
    pub fn check(job: &SequenceJob) -> Result<Option<u32>> {
        job.sequence_outputs.check(job.render.window.size())?;
        let band_rows = memory::check(job)?;
        check_names(job)?;
        Ok(band_rows)
    }

    /// Checks that the system accepts the names of files and of missing folders. Of several sequences, those of all are checked before
    /// [`Self::prepare`] creates the folders of one.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] with the file and the reason.
    pub fn check_new_names(&self) -> Result<()> {
        self.written_paths().iter().try_for_each(|path| check_new_names(path))
    }

    /// The frames, their parts and their checkpoints.
    fn written_paths(&self) -> Vec<PathBuf> {
        let mut paths = Vec::new();
        for frame in &self.frames {
            paths.extend(frame.paths().map(Path::to_owned));
            if self.keeps_checkpoints {
                paths.push(frame.checkpoint_path());
            }
        }
        paths
    }

    /// Creates the folders, checks that files can be written there, and removes temporary files of ended runs.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] with the folder and the reason.
    pub fn prepare(&self) -> Result<()> {
        let mut folders = BTreeSet::new();
        let paths = self.written_paths();
        for path in &paths {
            // One file probes its whole folder.
            check_name(path)?;
            if folders.insert(path.parent().map(Path::to_owned)) {
                probe_folder(path)?;
            }
        }
        remove_stale_temporaries(&paths);
        Ok(())
    }

    /// Whether no other run has made or replaced a file that the plan counts on. Of frames that are to be rendered, each is looked at again
    /// before it is.
    pub(super) fn is_current(&self) -> bool {
        let is_same =
            |(frame, stamp): (&PlannedFrame, &Option<FileStamp>)| FileStamp::of(&frame.path) == *stamp;
        let mut stamps = self.frames.iter().zip(&self.stamps);
        stamps.all(|(frame, stamp)| !(frame.is_done || self.is_movie) || is_same((frame, stamp)))
    }

    /// Number of frames to render.
    pub fn remaining(&self) -> usize {
        self.frames.iter().filter(|frame| !frame.is_done).count()
    }
}

fn check_names(job: &SequenceJob) -> Result<()> {
    if job.output.is_movie() {
        return check_movie(job);
    }
    if job.frames.len() > 1 && !job.output.is_numbered() {
        let path = job.output.path(0);
        let numbered =
            path.with_extension(format!("####.{}", path.extension().unwrap_or_default().display()));
        let why = format!(
            "{} frames would all be written to \"{}\"; put #### where the frame number belongs, such as {}, or choose one with `frames`",
            job.frames.len(),
            path.display(),
            numbered.display(),
        );
        return Err(Error::setting("output", why));
    }
    if job.preview && job.output.format() == OutputFormat::Png {
        return Err(Error::setting(
            "preview",
            "adds previews to EXR files, but `output` names PNG files already; leave it out",
        ));
    }
    check_aovs(job)
}

fn check_aovs(job: &SequenceJob) -> Result<()> {
    if job.output.format() == OutputFormat::Png && job.exr != ExrOutput::default() {
        return Err(Error::setting(
            "output",
            "`aovs`, `exr`, `split_aovs` and `stamp` apply to EXR files, but this names PNG files; end it with .exr",
        ));
    }
    if job.output.has_layer_place() && !job.exr.is_split {
        return Err(Error::setting(
            "output",
            "{layer} is the name of an AOV with a file of its own; add `split_aovs` or leave {layer} out",
        ));
    }
    // Guides may be recorded for the denoiser alone.
    let written = job.exr.aov_flags();
    let guides = written.guides || job.denoiser.is_some();
    if (AovFlags { guides, ..job.render.aovs }) != (AovFlags { guides, ..written }) {
        return Err(Error::Internal { message: "other AOVs are rendered than are written".to_owned() });
    }
    job.exr.contradiction().map_or(Ok(()), |why| Err(Error::setting("exr", why)))
}

/// Refuses two files of one name.
fn refuse_shared_names(frames: &[PlannedFrame]) -> Result<()> {
    let mut names = BTreeSet::new();
    match frames.iter().flat_map(PlannedFrame::paths).find(|path| !names.insert(*path)) {
        None => Ok(()),
        Some(path) => Err(Error::setting(
            "output",
            format!("two files of this run would be called \"{}\"; choose another name", path.display()),
        )),
    }
}

/// A planned frame with what is there of it.
struct InspectedFrame {
    planned: PlannedFrame,
    /// Its file before it was looked at.
    stamp: Option<FileStamp>,
    /// An existing file with other content under one of its names.
    in_the_way: Option<ReplacedFile>,
}

fn inspect_frame(job: &SequenceJob, frame: i64, render_hash: String) -> InspectedFrame {
    let path = job.output.path(frame);
    let stamp = FileStamp::of(&path);
    let aovs = job.exr.split_aovs().iter();
    let aov_paths: Vec<_> = aovs.map(|aov| job.output.layer_path(frame, aov.name())).collect();
    let preview_path = job.preview.then(|| path.with_extension("png"));
    let time_seconds = job.rate.time_seconds(frame);
    let planned =
        PlannedFrame { frame, time_seconds, path, aov_paths, preview_path, render_hash, is_done: false };
    let FilesOfFrame { is_done, in_the_way } = existing_files(job, &planned);
    InspectedFrame { planned: PlannedFrame { is_done, ..planned }, stamp, in_the_way }
}

/// The existing files of a frame.
pub(super) struct FilesOfFrame {
    /// Whether all files but the preview are there.
    pub(super) is_done: bool,
    /// A file with other content under one of its names, a foreign one if there is one.
    pub(super) in_the_way: Option<ReplacedFile>,
}

/// Looks at the files under the names of a frame.
pub(super) fn existing_files(job: &SequenceJob, planned: &PlannedFrame) -> FilesOfFrame {
    let PlannedFrame { path, aov_paths, preview_path, render_hash, .. } = planned;
    let files = std::iter::once(path).chain(aov_paths);
    let decisions: Vec<_> = files.map(|path| (path, decide(job, path, render_hash))).collect();
    let is_done = decisions.iter().all(|(_, decision)| *decision == Decision::Keep);
    let frames = decisions.into_iter().filter_map(|(path, decision)| match decision {
        Decision::InTheWay(obstacle) => Some(obstacle.at(path)),
        Decision::Render | Decision::Keep => None,
    });
    let preview =
        preview_path.iter().filter_map(|path| Some(preview_in_the_way(job, path, render_hash)?.at(path)));
    FilesOfFrame { is_done, in_the_way: frames.chain(preview).min_by_key(|file| !file.is_foreign) }
}

/// Refuses files that `existing` does not permit to replace; those first that only [`ExistingFiles::Overwrite`] does.
pub(super) fn refuse_to_replace(in_the_way: &[ReplacedFile], existing: ExistingFiles) -> Result<()> {
    if existing == ExistingFiles::Overwrite {
        return Ok(());
    }
    let refused = || in_the_way.iter().filter(|file| file.is_foreign || existing == ExistingFiles::Protect);
    let first = refused().min_by_key(|file| !file.is_foreign);
    first.map_or(Ok(()), |first| Err(replacement_refused(first, refused().count() - 1)))
}

/// Error about an existing file, and `others` that are in the way, too.
fn replacement_refused(file: &ReplacedFile, others: usize) -> Error {
    let ReplacedFile { path, why, is_foreign } = file;
    let others = match others {
        0 => String::new(),
        count => format!(" (and {count} more)"),
    };
    let permits = if *is_foreign {
        "only `overwrite` replaces it"
    } else {
        "`resume` replaces only such frames, `overwrite` replaces all"
    };
    Error::CannotCreate {
        path: path.clone(),
        message: format!("the file exists{others} and is {why}; {permits}"),
    }
}
