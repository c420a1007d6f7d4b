//! The settings of one shot, merged from all levels.

use std::path::{Path, PathBuf};

use crate::error::{Error, Provenance, Result, Warning};
use crate::sequence::SequenceJob;
use crate::settings::{SettingValues, Settings};

/// The settings of one shot.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ShotSettings {
    /// What is given.
    pub settings: Settings,
    /// The same with defaults applied.
    pub values: SettingValues,
    /// The scene file.
    pub scene: PathBuf,
    /// The shot file that was read.
    pub shot_file: Option<PathBuf>,
}

impl ShotSettings {
    /// Merges levels of settings, the strongest first.
    ///
    /// # Errors
    /// [`Error::Setting`] for values of code that make no sense and for settings that cannot be combined, [`Error::Refused`] for a program that a file names, [`Error::Usage`] and
    /// [`Error::Invalid`] where no scene is named.
    pub fn merge(levels: impl IntoIterator<Item = Settings>, shot_file: Option<PathBuf>) -> Result<Self> {
        let mut settings = Settings::default();
        for level in levels {
            settings.fill_from(&level);
        }
        settings.check_values()?;
        settings.check_requirements()?;
        check_program(&settings)?;
        let Some(scene) = settings.scene.as_ref().map(|scene| scene.value.clone()) else {
            return Err(no_scene(shot_file.as_deref()));
        };
        Ok(Self { values: settings.values(), settings, scene, shot_file })
    }

    /// Reads a shot file, or the scene `path` with no settings.
    ///
    /// # Errors
    /// Those of [`Settings::read_shot`] and [`ShotSettings::merge`].
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(path, Settings::default())
    }

    /// Reads a shot file, over whose settings `settings` stand, or the scene `path` with these settings.
    ///
    /// # Errors
    /// Those of [`ShotSettings::read`].
    pub fn read_with(path: &Path, settings: Settings) -> Result<Self> {
        if is_shot(path) {
            return Self::merge([settings, Settings::read_shot(path)?], Some(path.to_owned()));
        }
        Self::merge([Settings { scene: Some(path.to_owned().into()), ..settings }], None)
    }

    /// Changes settings and applies the defaults again.
    pub fn change(&mut self, change: impl FnOnce(&mut Settings)) {
        change(&mut self.settings);
        self.values = self.settings.values();
    }
}

/// Whether a path names a shot file.
pub fn is_shot(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

pub(super) fn no_scene(shot: Option<&Path>) -> Error {
    let example = "scene = \"robot.glb\"";
    match shot {
        Some(shot) => Error::invalid(shot, "", format!("names no scene; write {example}")),
        None => Error::usage("no scene is named; write its file, or -D scene=FILE"),
    }
}

/// Refuses a program that a file names: it would be started, and shot and suite files may come from strangers.
///
/// # Errors
/// [`Error::Refused`] with the file.
pub(super) fn check_program(settings: &Settings) -> Result<()> {
    let Some(Provenance::File { path, .. }) = settings.origin_of("oidn") else { return Ok(()) };
    let message = "oidn: files may not name programs, which would be started; \
        leave it out, and type --oidn or put oidnDenoise into the search path";
    Err(Error::refused(path, "", message))
}

/// Refuses warnings under `strict`.
///
/// # Errors
/// That of [`refusal`].
pub(crate) fn check_warnings(job: &SequenceJob, warnings: &[Warning]) -> Result<()> {
    match refusal(&job.scene.path, warnings) {
        Some(error) if job.strict => Err(error),
        _ => Ok(()),
    }
}

/// The error that strict mode makes of warnings: the first one, and their number.
pub fn refusal(path: &Path, warnings: &[Warning]) -> Option<Error> {
    let unique: std::collections::BTreeSet<_> = warnings.iter().collect();
    let first = unique.first()?;
    let count = match unique.len() {
        1 => "1 warning".to_owned(),
        count => format!("{count} warnings"),
    };
    let message = format!("{} (`strict` refuses {count})", first.message);
    Some(Error::unsupported(path, first.pointer.clone(), message))
}
