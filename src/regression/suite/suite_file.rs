//! `suite.toml`: where a suite's shots, references and report are, and what passes.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::limits::{LimitTable, PresetLimits};
use crate::error::{Error, Result};
use crate::settings_file::{not_toml, read_text};

/// The name of a suite's file.
pub const SUITE_FILE: &str = "suite.toml";
/// Largest reference unless the suite says otherwise, KiB: room for 320x180 pixels with several layers of data.
const MAX_REFERENCE_KIB: u64 = 1024;

/// A suite.
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// Its file, whose table `[shot]` holds settings of all shots.
    pub file: PathBuf,
    /// Where shots are looked for.
    pub scenes: PathBuf,
    /// Files and folders below it in which none are looked for.
    pub excluded: Vec<PathBuf>,
    /// References, at the paths of the shots.
    pub references: PathBuf,
    /// Where the report goes.
    pub report: PathBuf,
    /// Largest file that becomes a reference, bytes.
    pub max_reference_bytes: u64,
    pub(super) limits: PresetLimits,
}

/// The file as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct SuiteText {
    scenes: Option<PathBuf>,
    exclude: Vec<PathBuf>,
    references: Option<PathBuf>,
    report: Option<PathBuf>,
    max_reference_kib: Option<u64>,
    test: LimitTable,
    #[serde(rename = "shot")]
    _shot: IgnoredAny,
}

/// What tells a suite file from a shot file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct SuiteMark {
    shot: Option<IgnoredAny>,
    scene: Option<IgnoredAny>,
}

/// What a suite wants to know of a shot file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct ShotText {
    test: LimitTable,
}

impl Suite {
    /// Reads the suite of a folder, or of a file.
    ///
    /// # Errors
    /// [`Error::Missing`] when the file is not there, [`Error::Invalid`] with the line when it is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let file = if path.is_dir() { path.join(SUITE_FILE) } else { path.to_owned() };
        let text: SuiteText = parse(&file)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let below = |path: Option<PathBuf>, default: &str| joined(folder, &path.unwrap_or(default.into()));
        let limits = PresetLimits::default().with(&text.test);
        let limits = limits.map_err(|why| Error::invalid(&file, "", format!("[test] {why}")))?;
        let scenes = below(text.scenes.filter(|path| path != Path::new(".")), "");
        let excluded: Vec<_> = text.exclude.iter().map(|path| scenes.join(path)).collect();
        // What is not there may be made later; what looks like a pattern is meant as one.
        if let Some(pattern) = text.exclude.iter().find(|path| path.to_string_lossy().contains(['*', '?'])) {
            let pattern = pattern.display();
            let message =
                format!("exclude: \"{pattern}\" is taken for a name; write whole names of files and folders");
            return Err(Error::invalid(&file, "", message));
        }
        Ok(Self {
            excluded,
            scenes,
            references: below(text.references, "references"),
            report: below(text.report, "report"),
            max_reference_bytes: text.max_reference_kib.unwrap_or(MAX_REFERENCE_KIB).saturating_mul(1024),
            limits,
            file,
        })
    }

    /// The suite file of `folder` or of the nearest folder around it that has one.
    pub fn find(folder: &Path) -> Option<PathBuf> {
        folder.ancestors().map(|folder| folder.join(SUITE_FILE)).find(|file| file.is_file())
    }

    /// Why a file of so many bytes is too large for a reference; `None` when it is not.
    pub(super) fn too_large(&self, bytes: u64) -> Option<String> {
        (bytes > self.max_reference_bytes).then(|| {
            format!(
                "the file has {} KiB and a reference at most {}; ask for fewer pixels or layers, or raise max_reference_kib",
                bytes.div_ceil(1024),
                self.max_reference_bytes / 1024
            )
        })
    }

    /// What passes for the shot at `path`: what the suite says, and what the shot file says of itself.
    pub(super) fn limits_of(&self, path: &Path) -> Result<PresetLimits> {
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
            return Ok(self.limits);
        }
        let text: ShotText = parse(path)?;
        self.limits.with(&text.test).map_err(|why| Error::invalid(path, "", format!("[test] {why}")))
    }
}

/// Whether a `.toml` file is a suite's and no shot's: by its name, or because it has a table `[shot]` and names no scene.
pub(super) fn is_suite_file(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == SUITE_FILE)
        || parse(path).is_ok_and(|mark: SuiteMark| mark.shot.is_some() && mark.scene.is_none())
}

/// `path` from `folder`, without a way down and up again that would only be hard to read.
fn joined(folder: &Path, path: &Path) -> PathBuf {
    let name = folder.file_name().is_some() && !folder.is_symlink();
    match (path.strip_prefix(".."), folder.parent()) {
        (Ok(rest), Some(parent)) if name => joined(parent, rest),
        _ => folder.join(path),
    }
}

fn parse<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T> {
    let text = read_text(path)?;
    toml::from_str(&text).map_err(|error| not_toml(path, &text, &error))
}

#[cfg(test)]
mod tests {
    use super::super::super::Preset;
    use super::*;

    fn suite(text: &str) -> (tempfile::TempDir, Result<Suite>) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(SUITE_FILE), text).unwrap();
        let suite = Suite::read(folder.path());
        (folder, suite)
    }

    #[test]
    fn paths_are_meant_from_the_suites_folder() {
        let (folder, read) = suite("references = '../refs'\n[shot]\nsamples = 4\n[test]\npreset = 'exact'");
        let read = read.unwrap();
        assert_eq!(read.scenes, folder.path().join(""));
        assert_eq!(read.references, folder.path().with_file_name("refs"));
        assert_eq!(joined(Path::new("scenes"), Path::new("../a/b")), Path::new("a/b"));
        assert_eq!(joined(Path::new(""), Path::new("../a")), Path::new("../a"));
        assert_eq!(joined(Path::new(".."), Path::new("../a")), Path::new("../../a"));
        assert_eq!(read.report, folder.path().join("report"));
        assert_eq!(read.limits.preset, Preset::Exact);
        assert_eq!(read.max_reference_bytes, 1024 << 10);
        std::fs::create_dir_all(folder.path().join("a/b")).unwrap();
        assert_eq!(Suite::find(&folder.path().join("a/b")), Some(folder.path().join(SUITE_FILE)));
    }

    #[test]
    fn shots_have_limits_of_their_own() {
        let (folder, read) = suite("[test]\npreset = 'exact'");
        let shot = folder.path().join("a.toml");
        std::fs::write(&shot, "scene = 'a.glb'\n[test]\ntile_flip = 0.5").unwrap();
        let limits = read.as_ref().unwrap().limits_of(&shot).unwrap();
        assert_eq!((limits.limits.tile_flip, limits.limits.mean_flip), (0.5, 0.0));
        std::fs::write(&shot, "scene = 'a.glb'\n[test]\ntile = 0.5").unwrap();
        let told = read.as_ref().unwrap().limits_of(&shot).unwrap_err().to_string();
        assert!(told.contains("line 3") && told.contains("tile"), "{told}");
        assert_eq!(read.as_ref().unwrap().limits_of(Path::new("a.glb")).unwrap(), read.unwrap().limits);
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        for (text, words) in [
            ("scenes = '.'\nrefs = 'r'", "line 2: unknown field `refs`"),
            ("scenes = 4", "line 1"),
            ("exclude = ['*.glb']", "exclude: \"*.glb\" is taken for a name"),
            ("[test]\npreset = 'lose'", "[test] preset"),
            ("max_reference_kib = -1", "line 1"),
        ] {
            let told = suite(text).1.unwrap_err();
            assert!(told.to_string().contains(words), "{told}");
            assert_eq!(told.exit_code(), 65);
        }
        assert_eq!(Suite::read(Path::new("gone/suite.toml")).unwrap_err().exit_code(), 66);
    }
}
