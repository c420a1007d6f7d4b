//! Suite files (`suite.toml`): the folders of shots, references and report, and limits.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::coverage::Coverage;
use super::limits::PresetLimits;
use crate::error::Result;
use crate::settings::{TomlEntry, TomlFile, entries, is_setting, read_text};
use crate::shot::is_shot;

/// The name of suite files.
pub const SUITE_FILE: &str = "suite.toml";
/// Default size limit of references, KiB. It admits 320x180 pixels with several layers of data.
const MAX_REFERENCE_KIB: u64 = 1024;

/// A suite: a folder of shots with reference images.
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// The suite file, whose table `[shot]` holds settings of all shots.
    pub file: PathBuf,
    /// The folder in which shots are discovered.
    pub scenes: PathBuf,
    /// Files and folders below it that are skipped.
    pub excluded: Vec<PathBuf>,
    /// Paths of `exclude` that are neither in the suite's folder nor in that of the shots.
    pub missing_excluded: Vec<PathBuf>,
    /// The folder of references, which are named like the shots.
    pub references: PathBuf,
    /// The folder of the report.
    pub report: PathBuf,
    /// The folder of verdicts of earlier runs.
    pub cache: PathBuf,
    /// Size limit of references, bytes.
    pub max_reference_bytes: u64,
    pub(super) limits: PresetLimits,
    pub(super) coverage: Coverage,
}

/// Keys of a suite file.
const KEYS: [&str; 8] =
    ["scenes", "exclude", "references", "report", "cache", "max_reference_kib", "test", "shot"];

/// The suite file as written, without its tables.
#[derive(Debug, Default)]
struct SuiteText {
    scenes: Option<PathBuf>,
    exclude: Vec<PathBuf>,
    references: Option<PathBuf>,
    report: Option<PathBuf>,
    cache: Option<PathBuf>,
    max_reference_kib: Option<u64>,
}

impl SuiteText {
    fn of(file: &TomlFile<'_>, table: &DeTable<'_>) -> Result<Self> {
        let mut suite = Self::default();
        for entry in entries(table) {
            match entry.key {
                "scenes" => suite.scenes = Some(path(file, entry)?),
                "exclude" => suite.exclude = excluded(file, entry)?,
                "references" => suite.references = Some(path(file, entry)?),
                "report" => suite.report = Some(path(file, entry)?),
                "cache" => suite.cache = Some(path(file, entry)?),
                "max_reference_kib" => suite.max_reference_kib = Some(kib(file, entry)?),
                "test" | "shot" => {}
                _ => return Err(file.unknown_key(entry, "a key of a suite", &KEYS)),
            }
        }
        Ok(suite)
    }
}

fn path(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<PathBuf> {
    match entry.value {
        DeValue::String(path) => Ok(PathBuf::from(path.as_ref())),
        _ => Err(file.wrong_kind(entry, "a text in quotes")),
    }
}

fn excluded(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<Vec<PathBuf>> {
    let expected = "an array of texts, such as [\"node_modules\"]";
    let DeValue::Array(paths) = entry.value else { return Err(file.wrong_kind(entry, expected)) };
    let paths: Option<Vec<&str>> = paths.iter().map(|path| path.get_ref().as_str()).collect();
    let paths = paths.ok_or_else(|| file.wrong_value(entry, format!("expected {expected}")))?;
    // A missing path may be created later. Patterns are not supported.
    if let Some(pattern) = paths.iter().find(|path| path.contains(['*', '?'])) {
        let why =
            format!("\"{}\" is a pattern; write whole names of files and folders", pattern.escape_debug());
        return Err(file.wrong_value(entry, why));
    }
    Ok(paths.into_iter().map(PathBuf::from).collect())
}

fn kib(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<u64> {
    let number = file.number(entry, |number| {
        let is_whole = number >= 0.0 && number.fract() == 0.0 && number.is_finite();
        if is_whole { Ok(()) } else { Err("write a whole number of KiB from 0") }
    })?;
    Ok(number as u64)
}

impl Suite {
    /// Reads a suite from its file, or from the suite file of a folder.
    ///
    /// # Errors
    /// [`Error::Missing`](crate::Error::Missing) when the file does not exist, [`Error::Setting`](crate::Error::Setting) with line
    /// and column of a wrong key or value.
    pub fn read(path: &Path) -> Result<Self> {
        let file = if path.is_dir() { path.join(SUITE_FILE) } else { path.to_owned() };
        let text = read_text(&file)?;
        let toml = TomlFile { path: &file, text: &text };
        let table = toml.table()?;
        let text = SuiteText::of(&toml, &table)?;
        let limits = PresetLimits::default().with(&toml, &table)?;
        let coverage = Coverage::default().with(&toml, &table)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let below = |path: Option<PathBuf>, default: &str| joined(folder, &path.unwrap_or(default.into()));
        let scenes = below(text.scenes.filter(|path| path != Path::new(".")), "");
        let (mut excluded, mut missing_excluded) = (Vec::new(), Vec::new());
        for path in text.exclude {
            // Relative to the scenes, too, as all were in earlier versions.
            let found = [folder, &scenes].map(|folder| joined(folder, &path));
            let found: Vec<_> = found.into_iter().filter(|path| path.exists()).collect();
            if found.is_empty() {
                missing_excluded.push(path);
            }
            excluded.extend(found);
        }
        excluded.dedup();
        Ok(Self {
            excluded,
            missing_excluded,
            scenes,
            references: below(text.references, "references"),
            report: below(text.report, "report"),
            cache: below(text.cache, ".rayframe-cache"),
            max_reference_bytes: text.max_reference_kib.unwrap_or(MAX_REFERENCE_KIB).saturating_mul(1024),
            limits,
            coverage,
            file,
        })
    }

    /// The suite file of `folder`, or of its nearest ancestor that has one.
    pub fn find(folder: &Path) -> Option<PathBuf> {
        folder.ancestors().map(|folder| folder.join(SUITE_FILE)).find(|file| file.is_file())
    }

    /// All suites in `folder`, and not below it, that can be read.
    pub fn of_folder(folder: &Path) -> Vec<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_suite = |file: &PathBuf| {
            file.extension().is_some_and(|extension| extension == "toml")
                && SuiteToml::of(file) == SuiteToml::Suite
        };
        files.filter(is_suite).filter_map(|file| Self::read(&file).ok()).collect()
    }

    /// A message for a file of `bytes` bytes that exceeds the size limit of references; `None` within the limit.
    pub(super) fn too_large(&self, bytes: u64) -> Option<String> {
        (bytes > self.max_reference_bytes).then(|| {
            format!(
                "the file has {} KiB and a reference at most {}; use fewer pixels or AOVs, or raise max_reference_kib",
                bytes.div_ceil(1024),
                self.max_reference_bytes / 1024
            )
        })
    }

    /// The limits of the shot at `path`: those of the suite, changed by the shot file.
    pub(super) fn limits_of(&self, path: &Path) -> Result<PresetLimits> {
        if !is_shot(path) {
            return Ok(self.limits);
        }
        let text = read_text(path)?;
        let file = TomlFile { path, text: &text };
        self.limits.with(&file, &file.table()?)
    }

    /// What is tested of the shot at `path`: what the suite says, changed by the shot file.
    pub(super) fn coverage_of(&self, path: &Path) -> Result<Coverage> {
        if !is_shot(path) {
            return Ok(self.coverage.clone());
        }
        let text = read_text(path)?;
        let file = TomlFile { path, text: &text };
        self.coverage.clone().with(&file, &file.table()?)
    }
}

/// What a `.toml` file in the folder of a suite is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SuiteToml {
    /// A suite file, by its name, or by a table `[shot]` without a scene.
    Suite,
    /// It has a key of a shot, or cannot be read.
    Shot,
    /// It has keys of a camera path.
    CameraPath,
    /// A file of another program.
    Stray,
}

impl SuiteToml {
    /// Reads the file.
    pub(super) fn of(path: &Path) -> Self {
        if path.file_name().is_some_and(|name| name == SUITE_FILE) {
            return Self::Suite;
        }
        let Ok(text) = read_text(path) else { return Self::Shot };
        let Ok(table) = (TomlFile { path, text: &text }).table() else { return Self::Shot };
        let has_key = || entries(&table).iter().any(|entry| entry.key == "test" || is_setting(entry.key));
        if table.contains_key("shot") && !table.contains_key("scene") {
            Self::Suite
        } else if has_key() {
            Self::Shot
        } else if table.get("key").is_some_and(|keys| keys.get_ref().is_array()) {
            Self::CameraPath
        } else {
            Self::Stray
        }
    }
}

/// Joins `path` to `folder`, resolving leading `..` by name.
fn joined(folder: &Path, path: &Path) -> PathBuf {
    let name = folder.file_name().is_some() && !folder.is_symlink();
    match (path.strip_prefix(".."), folder.parent()) {
        (Ok(rest), Some(parent)) if name => joined(parent, rest),
        _ => folder.join(path),
    }
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
    fn paths_are_relative_to_the_suite_file() {
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
    fn excluded_paths_are_relative_to_the_suite_or_its_scenes() {
        let folder = tempfile::tempdir().unwrap();
        for below in ["models/wip", "models/old"] {
            std::fs::create_dir_all(folder.path().join(below)).unwrap();
        }
        let text = "scenes = 'models'\nexclude = ['models/wip', 'old', 'models', 'gone']";
        std::fs::write(folder.path().join(SUITE_FILE), text).unwrap();
        let suite = Suite::read(folder.path()).unwrap();
        assert_eq!(
            suite.excluded,
            ["models/wip", "models/old", "models"].map(|path| folder.path().join(path))
        );
        assert_eq!(suite.missing_excluded, [Path::new("gone")]);
        std::fs::write(folder.path().join(SUITE_FILE), "exclude = ['models/wip']").unwrap();
        let suite = Suite::read(folder.path()).unwrap();
        assert_eq!((suite.excluded.len(), suite.missing_excluded.len()), (1, 0));
    }

    #[test]
    fn shots_have_limits_of_their_own() {
        let (folder, read) = suite("[test]\npreset = 'exact'");
        let shot = folder.path().join("a.toml");
        std::fs::write(&shot, "scene = 'a.glb'\n[test]\ntile_flip = 0.5").unwrap();
        let limits = read.as_ref().unwrap().limits_of(&shot).unwrap();
        assert_eq!((limits.limits.tile_flip, limits.limits.mean_flip), (0.5, 0.0));
        std::fs::write(&shot, "scene = 'a.glb'\n[test]\ntile = 0.5").unwrap();
        let error = read.as_ref().unwrap().limits_of(&shot).unwrap_err().to_string();
        assert!(error.contains(":3:1: \"tile\" is not a key of [test]"), "{error}");
        assert_eq!(read.as_ref().unwrap().limits_of(Path::new("a.glb")).unwrap(), read.unwrap().limits);
    }

    #[test]
    fn errors_name_their_line() {
        for (text, words) in [
            (
                "scenes = '.'\nrefrences = 'r'",
                "suite.toml:2:1: \"refrences\" is not a key of a suite; did you mean \"references\"?",
            ),
            ("scenes = 4", "suite.toml:1:1: scenes: expected a text in quotes, found a number"),
            ("exclude = ['*.glb']", "suite.toml:1:1: exclude: \"*.glb\" is a pattern"),
            ("exclude = 'a'", "suite.toml:1:1: exclude: expected an array of texts"),
            ("[test]\npreset = 'lose'", "suite.toml:2:1: preset: there is no \"lose\""),
            ("test = 1", "suite.toml:1:1: test: expected [test]"),
            ("max_reference_kib = -1", "suite.toml:1:1: max_reference_kib: write a whole number"),
            ("[test", "suite.toml:1:6: not valid TOML: "),
            ("scenes = \"C:\\x\"", "write the text in single quotes, such as 'C:\\robot.glb'"),
            ("scenes = \"C:\\users\"", "write the text in single quotes"),
            ("scenes = \"a\\q\"", "write the text in single quotes"),
            (
                "[test]\ntile_flip = \"0.1\"",
                "tile_flip: expected a number, found a text; write 0.1 without quotes",
            ),
            (
                "max_reference_kib = \"0.5\"",
                "expected a number without quotes, found a text; write a whole number of KiB from 0",
            ),
            ("max_reference_kib = \"many\"", "max_reference_kib: expected a number, found a text"),
        ] {
            let error = suite(text).1.unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(error.exit_code(), 65);
        }
        assert_eq!(Suite::read(Path::new("gone/suite.toml")).unwrap_err().exit_code(), 66);
    }
}
