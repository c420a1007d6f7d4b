//! A folder of scenes against a folder of references.

use std::path::PathBuf;

use super::{Picture, SceneRenderer, Shot, Tolerance, compare, discover, report, shots};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// What is rendered and compared.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Folder of `.gltf` files.
    pub scenes: PathBuf,
    /// Folder of references, with the scenes' paths.
    pub references: PathBuf,
    /// Where pictures that differ are written.
    pub report: PathBuf,
    /// Only shots whose name contains this; empty for all.
    pub filter: String,
    /// Pixels.
    pub resolution: (u32, u32),
    /// Samples a pixel.
    pub samples: u32,
    /// What passes.
    pub tolerance: Tolerance,
}

/// What is done about a reference that is missing, different or dangling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// It is told.
    Check,
    /// It is written or removed, and told.
    Accept,
}

/// Something that is not as it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The shot's name, or the path of a reference without a shot.
    pub name: String,
    /// What is wrong, or what was written.
    pub message: String,
}

/// What a run found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Names of shots that are as their references.
    pub passed: Vec<String>,
    /// All else. A run passes when this is empty.
    pub failures: Vec<Failure>,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: {}", self.name, self.message)
    }
}

/// Renders and compares all shots of a suite.
///
/// # Errors
/// When the suite itself cannot be read, or on cancellation; what goes wrong with one shot is one of the failures.
pub fn run(suite: &Suite, mode: Mode, cancel: &CancelFlag) -> Result<Outcome> {
    let shots = discover(&suite.scenes)?;
    let mut outcome = Outcome::default();
    let mut open: Option<(PathBuf, SceneRenderer)> = None;
    for shot in shots.iter().filter(|shot| shot.name.contains(&suite.filter)) {
        cancel.check()?;
        let result =
            rendered(&mut open, suite, shot, cancel).and_then(|picture| settle(suite, mode, shot, &picture));
        match result {
            Ok(None) => outcome.passed.push(shot.name.clone()),
            Ok(Some(message)) => outcome.failures.push(Failure { name: shot.name.clone(), message }),
            Err(error @ Error::Interrupted(_)) => return Err(error),
            Err(error) => {
                outcome.failures.push(Failure { name: shot.name.clone(), message: error.to_string() });
            }
        }
    }
    if suite.filter.is_empty() {
        outcome.failures.extend(dangling(suite, mode, &shots)?);
    }
    Ok(outcome)
}

/// The shot's picture. A scene stays open as long as its shots follow each other.
fn rendered(
    open: &mut Option<(PathBuf, SceneRenderer)>,
    suite: &Suite,
    shot: &Shot,
    cancel: &CancelFlag,
) -> Result<Picture> {
    let scene = match open.take() {
        Some((path, scene)) if path == shot.scene => scene,
        _ => SceneRenderer::open(&shot.scene)?,
    };
    let time_seconds = f64::from(shot.frame) / f64::from(super::FRAMES_PER_SECOND);
    let result = scene.render(time_seconds, suite.resolution, suite.samples, cancel);
    // Scenes of a suite ask for nothing that is not honoured.
    let warnings: Vec<String> = scene.warnings().collect();
    *open = Some((shot.scene.clone(), scene));
    let (picture, non_finite_pixels) = result?;
    if !warnings.is_empty() {
        return Err(Error::Different { message: warnings.join("; ") });
    }
    // What is not finite is a failure of its own and never accepted.
    let broken = non_finite_pixels + picture.non_finite_pixels() as u64;
    if broken > 0 {
        return Err(Error::Different {
            message: format!("{broken} pixels came out infinite or not a number"),
        });
    }
    Ok(picture.as_stored())
}

/// Compares a picture with its reference; gives what is wrong, or what was accepted.
fn settle(suite: &Suite, mode: Mode, shot: &Shot, picture: &Picture) -> Result<Option<String>> {
    let path = shot.file_in(&suite.references);
    let time_seconds = f64::from(shot.frame) / f64::from(super::FRAMES_PER_SECOND);
    let found = if path.exists() {
        let reference = Picture::read(&path)?;
        let verdict = compare(picture, &reference, &suite.tolerance);
        if verdict.is_pass() {
            return Ok(None);
        }
        Some((reference, verdict))
    } else {
        None
    };
    match (mode, found) {
        (Mode::Accept, found) => {
            picture.write(&path, shot.frame, time_seconds)?;
            let reason = found.map_or_else(|| "new".to_owned(), |(_, verdict)| verdict.to_string());
            Ok(Some(format!("accepted, written to {} ({reason})", path.display())))
        }
        (Mode::Check, Some((reference, verdict))) => {
            let files = report::write_difference(&suite.report, shot, picture, &reference, time_seconds)?;
            let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
            Ok(Some(format!("{verdict}; see {}", files.join(" and "))))
        }
        (Mode::Check, None) => {
            let actual = suite.report.join(format!("{}.actual.exr", shot.name));
            picture.write(&actual, shot.frame, time_seconds)?;
            Ok(Some(format!("no reference at {}; see {}", path.display(), actual.display())))
        }
    }
}

/// References that no shot asks for.
fn dangling(suite: &Suite, mode: Mode, shots: &[Shot]) -> Result<Vec<Failure>> {
    if !suite.references.is_dir() {
        return Ok(Vec::new());
    }
    let mut failures = Vec::new();
    for path in shots::files_below(&suite.references, "exr")? {
        if shots.iter().any(|shot| shot.file_in(&suite.references) == path) {
            continue;
        }
        let message = match mode {
            Mode::Check => "no scene asks for this reference".to_owned(),
            Mode::Accept => {
                std::fs::remove_file(&path)
                    .map_err(|source| Error::WriteFailed { path: path.clone(), source })?;
                "accepted, removed: no scene asks for this reference".to_owned()
            }
        };
        failures.push(Failure { name: path.display().to_string(), message });
    }
    Ok(failures)
}
