//! Jobs of shots of a suite.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Result, Warning};
use crate::gltf::ImageLoading;
use crate::scene::Scene;
use crate::sequence::SequenceJob;
use crate::settings::{DEFINITIONS, Settings};

use super::environment::LoadedEnvironments;
use super::memory_limit::max_memory_bytes;
use super::outline::ShotOutline;
use super::resolve::{RenderJob, each_setting, load_scene, prepared, resolve, resolve_scene_with};
use super::shot_settings::{ShotSettings, check_program, check_warnings, is_shot, no_scene};

/// A shot of a suite.
#[derive(Clone, Copy, Debug)]
pub struct ShotRequest<'a> {
    /// A shot file `.toml`, or a scene.
    pub path: &'a Path,
    /// The suite file. Settings of the shot override its table `[shot]`.
    pub suite: Option<&'a Path>,
    /// Definitions `KEY=VALUE` that override the shot.
    pub overrides: &'a [String],
}

/// The job of a shot with its warnings.
#[derive(Debug)]
pub struct ShotJob {
    /// The job, as for `rayframe render`.
    pub sequence: SequenceJob,
    /// Unsupported features. Under `strict` these are errors.
    pub warnings: Vec<Warning>,
    /// Input files: the scene, its files, environments, plates, camera paths and the shot file.
    pub inputs: Vec<PathBuf>,
}

/// What is set for a view of a shot.
#[derive(Clone, Debug, Default)]
pub struct ViewSettings {
    /// Settings over those of the shot.
    pub settings: Settings,
    /// Names of settings that the view does not take from the shot.
    pub without: &'static [&'static str],
}

impl ViewSettings {
    /// The view of a shot.
    ///
    /// # Errors
    /// Those of [`ShotSettings::merge`].
    fn over(self, shot: &ShotSettings) -> Result<ShotSettings> {
        let mut of_shot = shot.settings.clone();
        self.without.iter().for_each(|name| of_shot.clear(name));
        ShotSettings::merge([self.settings, of_shot], shot.shot_file.clone())
    }
}

/// Reads a shot file or a scene with its settings, and resolves them as `rayframe render` does.
///
/// # Errors
/// Those of a command line, of a shot file, and of loading the scene; under `strict` the first warning.
pub fn shot_job(request: &ShotRequest<'_>) -> Result<ShotJob> {
    let shot = shot_settings(request)?;
    let RenderJob { sequence, warnings, inputs, .. } = resolve(&shot, ImageLoading::Texels)?;
    check_warnings(&sequence, &warnings)?;
    Ok(ShotJob { sequence, warnings, inputs })
}

/// The jobs of a shot whose scene is loaded once: one for each level of settings that `views` makes of the shot and its scene. The levels
/// override the shot's settings. A level that cannot be resolved has an error of its own. The memory limit, of loading as of rendering, is
/// an equal share for each of `shots_at_once`.
///
/// # Errors
/// Those of reading the shot and loading the scene, and of `views`.
pub fn shot_jobs(
    request: &ShotRequest<'_>,
    (images, shots_at_once): (ImageLoading, usize),
    views: impl FnOnce(&ShotSettings, &Scene) -> Result<Vec<ViewSettings>>,
) -> Result<Vec<Result<ShotJob>>> {
    let mut shot = shot_settings(request)?;
    if shots_at_once > 1 {
        let share = max_memory_bytes(&shot.values) / shots_at_once as u64;
        shot.settings.max_memory = Some(share.into());
        shot.values.max_memory = Some(share);
    }
    let scene = Arc::new(load_scene(&shot, images)?);
    let mut environments = LoadedEnvironments::default();
    let mut job = |view: ViewSettings| {
        let shot = view.over(&shot)?;
        refuse_each(&shot)?;
        let RenderJob { sequence, warnings, inputs, .. } =
            resolve_scene_with(&shot, Arc::clone(&scene), &mut environments)?;
        check_warnings(&sequence, &warnings)?;
        Ok(ShotJob { sequence, warnings, inputs })
    };
    Ok(views(&shot, &scene)?.into_iter().map(&mut job).collect())
}

/// Refuses settings that make several sequences, which shots of a suite have as lists.
fn refuse_each(shot: &ShotSettings) -> Result<()> {
    let Some((setting, what)) = each_setting(&shot.values) else { return Ok(()) };
    let why = format!(
        "each makes several sequences, which only rayframe render takes; name one {what}, or write {what}s = \"each\" in the table [test]"
    );
    Err(shot.settings.error(setting, why))
}

/// The outlines of a shot, one for each level of settings that `views` makes of the shot and its scene. Texels are not loaded.
///
/// # Errors
/// Those of [`shot_job`], of each level, and of `views`.
pub fn shot_outlines(
    request: &ShotRequest<'_>,
    views: impl FnOnce(&ShotSettings, &Scene) -> Result<Vec<ViewSettings>>,
) -> Result<Vec<ShotOutline>> {
    let shot = shot_settings(request)?;
    let scene = prepared(&shot, Arc::new(load_scene(&shot, ImageLoading::Budget)?))?;
    let outline = |view: ViewSettings| {
        let shot = view.over(&shot)?;
        ShotOutline::new(&shot, &scene)
    };
    views(&shot, &scene)?.into_iter().map(outline).collect()
}

/// The scene of the shot file `path`. Neither the scene nor other settings are read.
///
/// # Errors
/// Those of reading the file, and [`Error::Invalid`] where it names none.
///
/// [`Error::Invalid`]: crate::error::Error::Invalid
pub fn scene_of_shot(path: &Path) -> Result<PathBuf> {
    Settings::read_shot_scene(path)?.ok_or_else(|| no_scene(Some(path)))
}

/// Checks the settings that a suite file has for all its shots.
///
/// # Errors
/// Those of reading the file, [`Error::Invalid`] with the line for a setting that is wrong or has no effect, and [`Error::Refused`] for a
/// program.
///
/// [`Error::Refused`]: crate::error::Error::Refused
/// [`Error::Invalid`]: crate::error::Error::Invalid
pub fn check_suite_settings(path: &Path) -> Result<()> {
    let settings = Settings::read_suite(path)?;
    check_program(&settings)?;
    let without_effect = DEFINITIONS
        .iter()
        .find(|definition| definition.is_for_runs && definition.origin(&settings).is_some());
    match without_effect {
        Some(definition) => {
            Err(settings.error(definition.name, "has no effect on what is compared; leave it out"))
        }
        None => Ok(()),
    }
}

/// The settings of a shot: overrides over the shot's own over the suite's. An asset cache is a folder of `render`: what compares shots writes
/// nothing where their files say.
pub(super) fn shot_settings(request: &ShotRequest<'_>) -> Result<ShotSettings> {
    let mut shot = given_settings(request)?;
    shot.values.asset_cache = None;
    Ok(shot)
}

fn given_settings(request: &ShotRequest<'_>) -> Result<ShotSettings> {
    let overrides = Settings::read_definitions(request.overrides)?;
    let suite = request.suite.map(Settings::read_suite).transpose()?.unwrap_or_default();
    if is_shot(request.path) {
        let own = Settings::read_shot(request.path)?;
        return ShotSettings::merge([overrides, own, suite], Some(request.path.to_owned()));
    }
    let scene = Settings { scene: Some(request.path.to_owned().into()), ..Settings::default() };
    ShotSettings::merge([scene, overrides, suite], None)
}

#[cfg(test)]
mod tests;
