//! A shot as it is rendered for a suite: its file's settings over the suite's.

use std::path::{Path, PathBuf};

use crate::error::{Result, Warning};
use crate::regression::suite::{ShotReader, Suite};
use crate::sequence::SequenceJob;

use super::render_job::{RenderJob, render_job};
use super::setting::{Origin, Setting, Value};
use super::{MeantOptions, check_alone, defined_by, file, is_shot, no_scene, options, put_together, refusal};

/// Which shot is meant, and what is said about it elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct ShotRequest<'a> {
    /// A shot file `.toml`, or a scene.
    pub path: &'a Path,
    /// A suite file, whose table `[shot]` holds settings that count where the shot says nothing.
    pub suite: Option<&'a Path>,
    /// `KEY=VALUE`, which count before the shot's own.
    pub overrides: &'a [String],
}

/// What is to be rendered, and what is to be said about it.
#[derive(Debug)]
pub struct ShotJob {
    /// What `rayframe render` would do.
    pub sequence: SequenceJob,
    /// What is not honoured. Under `strict` these are errors.
    pub warnings: Vec<Warning>,
}

/// Reads a shot file or a scene, and understands all settings as `rayframe render` does.
///
/// # Errors
/// Those of a command line, of a shot file, and of loading the scene; under `strict` the first warning.
pub fn shot_job(request: &ShotRequest<'_>) -> Result<ShotJob> {
    let meant = meant(request)?;
    let RenderJob { sequence, warnings, .. } =
        render_job(&meant.args).map_err(|error| meant.explained(error))?;
    match refusal(&sequence.scene.path, &warnings) {
        Some(error) if sequence.strict => Err(error),
        _ => Ok(ShotJob { sequence, warnings }),
    }
}

/// The scene that the shot file `path` names. Neither the scene nor other settings are looked at.
///
/// # Errors
/// Those of reading the file, and [`Error::Invalid`] where it names none.
///
/// [`Error::Invalid`]: crate::error::Error::Invalid
pub fn scene_of_shot(path: &Path) -> Result<PathBuf> {
    let scene = file::read_scene(path, &options())?;
    match scene.map(|scene| scene.value) {
        Some(Value::Texts(texts)) => Ok(texts.into_iter().collect()),
        Some(Value::Flag(_)) | None => Err(no_scene(Some(path))),
    }
}

/// Settings that say what becomes of files and of the terminal, of which a suite has ways of its own.
const NOT_FOR_SUITES: [&str; 16] = [
    "all",
    "contact_sheet",
    "keep_going",
    "manifest",
    "movie",
    "output",
    "overwrite",
    "preview",
    "progress",
    "quiet",
    "resume",
    "show",
    "split_aovs",
    "stamp",
    "stats",
    "threads",
];

/// Finds what is wrong with the settings that a suite file has for all its shots.
///
/// # Errors
/// Those of reading the file, and [`Error::Invalid`] with the line for a setting that is wrong or has no effect.
///
/// [`Error::Invalid`]: crate::error::Error::Invalid
pub fn check_suite_settings(path: &Path) -> Result<()> {
    let command = options();
    for setting in file::read_suite(path, &command)? {
        check_alone(&command, &setting)?;
        if NOT_FOR_SUITES.contains(&setting.key.as_str()) {
            return Err(setting.error("has no effect on what is compared; leave it out"));
        }
    }
    Ok(())
}

/// The settings by their precedence: overrides, the shot's own, the suite's.
fn meant(request: &ShotRequest<'_>) -> Result<MeantOptions> {
    let command = options();
    let overrides = defined_by(&command, request.overrides)?;
    let suite = request.suite.map(|suite| file::read_suite(suite, &command)).transpose()?;
    let suite = suite.unwrap_or_default();
    if is_shot(request.path) {
        let own = file::read_shot(request.path, &command)?;
        return put_together(&command, Some(request.path.to_owned()), [overrides, own, suite]);
    }
    let scene = Setting {
        key: "scene".to_owned(),
        value: Value::Texts(vec![request.path.as_os_str().to_owned()]),
        origin: Origin::Typed,
    };
    put_together(&command, None, [vec![scene], overrides, suite])
}

/// Shots as the command line understands them: shot files and scenes, with the settings of `rayframe render`.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShotFiles;

impl ShotReader for ShotFiles {
    fn scene(&self, shot: &Path) -> Result<PathBuf> {
        scene_of_shot(shot)
    }

    fn job(&self, suite: &Suite, shot: &Path) -> Result<(SequenceJob, Vec<Warning>)> {
        let job = shot_job(&ShotRequest { path: shot, suite: Some(&suite.file), overrides: &[] })?;
        Ok((job.sequence, job.warnings))
    }
}

#[cfg(test)]
mod tests;
