//! Everything that can be known, and go wrong, before the first frame.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image_file::{check_name, probe_folder, remove_stale_temporaries};
use crate::output::ExrOutput;

use super::existing::{Decision, decide, preview_in_the_way};
use super::{ExistingFiles, OutputFormat, SequenceJob, memory, render_hash};

/// One frame and its files.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFrame {
    /// Frame number.
    pub frame: i64,
    /// What it shows, seconds.
    pub time_seconds: f64,
    /// The file.
    pub path: PathBuf,
    /// The files of the layers that are not in it, in the order of [`crate::output::ExrOutput::split_aovs`].
    pub aov_paths: Vec<PathBuf>,
    /// The tone-mapped PNG beside it.
    pub preview_path: Option<PathBuf>,
    /// What it is made from.
    pub render_hash: String,
    /// Whether all files but the preview are there already and whole.
    pub is_done: bool,
}

impl PlannedFrame {
    /// All files of the frame.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let others = self.aov_paths.iter().chain(&self.preview_path);
        std::iter::once(&self.path).chain(others).map(PathBuf::as_path)
    }
}

/// All frames in the order of rendering.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The frames.
    pub frames: Vec<PlannedFrame>,
    /// Files made from something else that frames and previews will replace, as resuming allows.
    pub replaced: Vec<ReplacedFile>,
}

/// A file that is there before the run and is not what its name will hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplacedFile {
    /// The file.
    pub path: PathBuf,
    /// What it is instead, to be read after "is".
    pub why: String,
}

impl Plan {
    /// Checks names, memory and existing files; creates nothing.
    ///
    /// # Errors
    /// [`Error::Usage`] when frames would share a name, [`Error::Refused`] when memory does not suffice, and
    /// [`Error::CannotCreate`] when a file made from something else has a frame's name.
    pub fn new(job: &SequenceJob) -> Result<Self> {
        memory::check(job)?;
        check_names(job)?;
        let planned: Vec<_> = job.frames.par_iter().map(|&frame| plan_frame(job, frame)).collect();
        let (frames, in_the_way): (Vec<_>, Vec<_>) = planned.into_iter().unzip();
        refuse_to_share(&frames)?;
        let replaced: Vec<_> = in_the_way.into_iter().flatten().collect();
        if job.existing == ExistingFiles::Protect {
            refuse_to_replace(&replaced)?;
        }
        Ok(Self { frames, replaced })
    }

    /// Creates the folders, makes sure that files can be written there, and removes what dead runs left half written.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] with the folder and the reason.
    pub fn prepare(&self) -> Result<()> {
        let mut folders = BTreeSet::new();
        let mut paths = Vec::new();
        for frame in &self.frames {
            paths.extend(frame.paths().map(Path::to_owned));
        }
        for path in &paths {
            // One file a folder tells about the folder.
            check_name(path)?;
            if folders.insert(path.parent().map(Path::to_owned)) {
                probe_folder(path)?;
            }
        }
        remove_stale_temporaries(&paths);
        Ok(())
    }

    /// Frames that are still to be rendered.
    pub fn remaining(&self) -> usize {
        self.frames.iter().filter(|frame| !frame.is_done).count()
    }
}

fn check_names(job: &SequenceJob) -> Result<()> {
    if job.frames.len() > 1 && !job.output.is_numbered() {
        let path = job.output.path(0);
        return Err(Error::usage(format!(
            "{} frames would all be written to \"{}\"; put #### where the frame number belongs, such as {}",
            job.frames.len(),
            path.display(),
            path.with_extension(format!("####.{}", path.extension().unwrap_or_default().display())).display(),
        )));
    }
    if job.preview && job.output.format() == OutputFormat::Png {
        return Err(Error::usage(
            "--preview png lies beside EXR files, but -o asks for PNG files already; leave --preview out",
        ));
    }
    check_layers(job)
}

fn check_layers(job: &SequenceJob) -> Result<()> {
    if job.output.format() == OutputFormat::Png && job.exr != ExrOutput::default() {
        return Err(Error::usage(
            "--layers, --exr, --split-aovs and --stamp are about EXR files, but -o asks for PNG files; end it with .exr",
        ));
    }
    if job.output.has_layer_place() && !job.exr.is_split {
        return Err(Error::usage(
            "--output: {layer} stands for the names of layers with files of their own; add --split-aovs or leave {layer} out",
        ));
    }
    if job.render.aovs != job.exr.aov_flags() {
        return Err(Error::Internal { message: "other AOVs are rendered than are written".to_owned() });
    }
    job.exr.contradiction().map_or(Ok(()), |why| Err(Error::usage(format!("--exr: {why}"))))
}

/// No two files of a run may have one name.
fn refuse_to_share(frames: &[PlannedFrame]) -> Result<()> {
    let mut names = BTreeSet::new();
    match frames.iter().flat_map(PlannedFrame::paths).find(|path| !names.insert(*path)) {
        None => Ok(()),
        Some(path) => Err(Error::usage(format!(
            "--output: two files of this run would be called \"{}\"; choose another name",
            path.display()
        ))),
    }
}

/// The frame, and the file that is in its way and why.
fn plan_frame(job: &SequenceJob, frame: i64) -> (PlannedFrame, Option<ReplacedFile>) {
    let path = job.output.path(frame);
    let layers = job.exr.split_aovs().iter();
    let aov_paths: Vec<_> = layers.map(|layer| job.output.layer_path(frame, layer.name())).collect();
    let preview_path = job.preview.then(|| path.with_extension("png"));
    let render_hash = render_hash(job, frame);

    // The frame is there when all its files are.
    let files = std::iter::once(&path).chain(&aov_paths);
    let decisions: Vec<_> = files.map(|path| (path, decide(job, path, &render_hash))).collect();
    let is_done = decisions.iter().all(|(_, decision)| *decision == Decision::Keep);
    let in_the_way = decisions.into_iter().find_map(|(path, decision)| match decision {
        Decision::InTheWay(why) => Some(ReplacedFile { path: path.clone(), why }),
        Decision::Render | Decision::Keep => None,
    });
    let in_the_way = in_the_way.or_else(|| {
        let preview = preview_path.as_ref()?;
        let why = preview_in_the_way(job, preview, &render_hash)?;
        Some(ReplacedFile { path: preview.clone(), why })
    });
    let time_seconds = job.rate.time_seconds(frame);
    (PlannedFrame { frame, time_seconds, path, aov_paths, preview_path, render_hash, is_done }, in_the_way)
}

fn refuse_to_replace(in_the_way: &[ReplacedFile]) -> Result<()> {
    let [ReplacedFile { path, why }, others @ ..] = in_the_way else {
        return Ok(());
    };
    let others = match others.len() {
        0 => String::new(),
        count => format!(" (and {count} more)"),
    };
    Err(Error::CannotCreate {
        path: path.clone(),
        message: format!(
            "the file is there{others} and is {why}; --resume replaces only such frames, --overwrite replaces all"
        ),
    })
}
