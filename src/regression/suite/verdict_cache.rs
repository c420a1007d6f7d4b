//! Verdicts of earlier runs: a shot that was identical is not rendered again while nothing changed that its images depend on.
//!
//! The folder holds one file a shot, named like it, in a folder named like the suite file: suites may share scenes. A file states the
//! SHA-256 of the program, of every input of the shot and of every reference, and where links of inputs lead, so that it is safe to share
//! between machines and branches, and to delete. Only shots whose images are all identical are kept: what changed or failed is rendered
//! again, since the report shows its images.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::names::reference_path;
use super::unchanged::is_unchanged_since;
use super::{Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::{probe_folder, remove_stale_temporaries, write_atomically};
use crate::regression::Verdict;
use crate::regression::result::FrameResult;
use crate::sequence::sha256_of_file;

/// Marks the folder for backup programs, <https://bford.info/cachedir/>.
const TAG: &str =
    "Signature: 8a477f597d28d172789f06886806bc55\n# Verdicts of rayframe test. The folder may be deleted.\n";

/// Files beside the verdicts.
const MARKS: [(&str, &str); 2] = [("CACHEDIR.TAG", TAG), (".gitignore", "*\n")];

/// Verdicts of earlier runs of a suite.
#[derive(Debug)]
pub(super) struct VerdictCache<'a> {
    suite: &'a Suite,
    folder: &'a Path,
    /// Canonical path of the suite's folder.
    suite_folder: PathBuf,
    /// SHA-256 of the running program.
    program: String,
    start: SystemTime,
    /// SHA-256 of files of this run; `None` for those that cannot be read.
    hashes: Mutex<BTreeMap<PathBuf, Option<String>>>,
    /// The first error of writing.
    error: Mutex<Option<Error>>,
}

/// The file of a shot.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CachedShot {
    /// SHA-256 of the program, which also tells versions of this file apart.
    program: String,
    /// The suite file, which is one of the inputs. Another one gives the shot other settings and limits.
    suite: String,
    /// The shot file or scene. A new shot file may take the name of a scene.
    shot: String,
    /// By path: the suite file, the shot file, the scene and the files that they name. Paths are relative to the suite's folder.
    inputs: BTreeMap<String, CachedInput>,
    /// The images, all identical to their references.
    pub(super) images: Vec<CachedImage>,
    /// Features of the scene that are not honoured.
    pub(super) warnings: Vec<String>,
}

/// A file that the images depend on.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CachedInput {
    /// SHA-256 of the file.
    hash: String,
    /// The path without links, relative to that of the suite's folder. A link that leads out of it may be refused.
    target: String,
}

/// An image that was identical to its reference.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CachedImage {
    pub(super) name: String,
    pub(super) frame: Option<i64>,
    /// SHA-256 of the file of the reference.
    pub(super) reference: String,
}

/// What a tested shot was made from, and its result.
#[derive(Clone, Copy, Debug)]
pub(super) struct TestedInputs<'a> {
    pub(super) files: &'a [PathBuf],
    pub(super) frames: &'a [FrameResult],
    pub(super) warnings: &'a [String],
}

fn verdict_file(folder: &Path, suite: &Suite, shot: &SuiteShot) -> PathBuf {
    let of_suite = folder.join(suite.file.file_name().unwrap_or_default());
    of_suite.join(format!("{}.json", shot.name))
}

impl<'a> VerdictCache<'a> {
    /// The verdicts of `shots` in `folder`, where what killed runs left is removed. `None` where the running program, which tells versions
    /// apart, or the suite's folder cannot be read.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] for a folder with files of others.
    pub(super) fn open(suite: &'a Suite, folder: &'a Path, shots: &[SuiteShot]) -> Result<Option<Self>> {
        let verdicts = shots.iter().map(|shot| verdict_file(folder, suite, shot));
        let paths: Vec<_> = verdicts.chain(MARKS.map(|(name, _)| folder.join(name))).collect();
        remove_stale_temporaries(&paths);
        let mut files = std::fs::read_dir(folder).into_iter().flatten();
        if files.next().is_some() && !folder.join("CACHEDIR.TAG").is_file() {
            let message = "holds other files than verdicts; name another folder in `cache`".to_owned();
            return Err(Error::CannotCreate { path: folder.to_owned(), message });
        }
        let program = std::env::current_exe().ok().and_then(|program| sha256_of_file(&program).ok());
        let suite_folder = Path::new(".").join(folder_of(&suite.file)).canonicalize().ok();
        let (hashes, error) = (Mutex::default(), Mutex::default());
        Ok(program.zip(suite_folder).map(|(program, suite_folder)| {
            let start = SystemTime::now();
            Self { suite, folder, suite_folder, program, start, hashes, error }
        }))
    }

    /// The images of the shot, if it was identical and nothing changed since.
    pub(super) fn find(&self, shot: &SuiteShot) -> Option<CachedShot> {
        let text = std::fs::read(self.file(shot)).ok()?;
        let cached: CachedShot = serde_json::from_slice(&text).ok()?;
        let suite_folder = folder_of(&self.suite.file);
        let is_named = |name: &str, file: &Path| relative(suite_folder, file).as_deref() == Some(name);
        let is_valid = cached.program == self.program
            && is_named(&cached.suite, &self.suite.file)
            && is_named(&cached.shot, &shot.path)
            && cached
                .inputs
                .iter()
                .all(|(path, input)| self.input(&suite_folder.join(path)).as_ref() == Some(input))
            && cached.images.iter().all(|image| {
                self.hash(&reference_path(&self.suite.references, &image.name)).as_ref()
                    == Some(&image.reference)
            });
        is_valid.then_some(cached)
    }

    /// Keeps the verdict of a shot if all of its images are identical, and otherwise forgets an earlier one.
    pub(super) fn store(&self, shot: &SuiteShot, tested: TestedInputs<'_>) {
        let Some(cached) = self.cached(shot, tested) else {
            let _ = std::fs::remove_file(self.file(shot));
            return;
        };
        if let Err(error) = self.write(&self.file(shot), &cached) {
            self.error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }

    /// The first error of writing.
    pub(super) fn into_error(self) -> Option<Error> {
        self.error.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self, file: &Path, cached: &CachedShot) -> Result<()> {
        for (name, text) in MARKS {
            let path = self.folder.join(name);
            if !path.exists() {
                probe_folder(&path)?;
                write_atomically(&path, text.as_bytes())?;
            }
        }
        probe_folder(file)?;
        write_atomically(file, &serde_json::to_vec(cached).unwrap_or_default())
    }

    /// `None` where an image is not identical, and where a file changed during the run.
    fn cached(&self, shot: &SuiteShot, tested: TestedInputs<'_>) -> Option<CachedShot> {
        let suite_folder = folder_of(&self.suite.file);
        let input = |path: &Path| {
            let name = relative(suite_folder, path)?;
            let input = self.input(path).filter(|_| is_unchanged_since(path, self.start))?;
            // Where links change what `..` is, the name may be that of another file.
            let is_same = self.target(&suite_folder.join(&name)).as_ref() == Some(&input.target);
            Some((name, input)).filter(|_| is_same)
        };
        let of_suite = [self.suite.file.as_path(), &shot.path].into_iter();
        let image = |frame: &FrameResult| {
            // That of the bytes that were compared.
            let reference = frame.reference_hash.clone()?;
            let image = CachedImage { name: frame.name.clone(), frame: frame.frame, reference };
            (frame.verdict() == Verdict::Identical).then_some(image)
        };
        Some(CachedShot {
            program: self.program.clone(),
            suite: relative(suite_folder, &self.suite.file)?,
            shot: relative(suite_folder, &shot.path)?,
            inputs: of_suite
                .chain(tested.files.iter().map(PathBuf::as_path))
                .map(input)
                .collect::<Option<_>>()?,
            images: tested.frames.iter().map(image).collect::<Option<_>>()?,
            warnings: tested.warnings.to_vec(),
        })
    }

    fn file(&self, shot: &SuiteShot) -> PathBuf {
        verdict_file(self.folder, self.suite, shot)
    }

    fn input(&self, path: &Path) -> Option<CachedInput> {
        Some(CachedInput { hash: self.hash(path)?, target: self.target(path)? })
    }

    /// The path without links, relative to that of the suite's folder.
    fn target(&self, path: &Path) -> Option<String> {
        relative(&self.suite_folder, &path.canonicalize().ok()?)
    }

    /// The hash of a file; read once a run.
    fn hash(&self, path: &Path) -> Option<String> {
        let hashes = || self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        let known = hashes().get(path).cloned();
        known.unwrap_or_else(|| {
            let hash = sha256_of_file(path).ok();
            hashes().insert(path.to_owned(), hash.clone());
            hash
        })
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// The path from `folder` to `file`, with `/` on every system. `None` for paths that are not Unicode.
fn relative(folder: &Path, file: &Path) -> Option<String> {
    let [folder, file] = [folder, file].map(|path| std::path::absolute(Path::new(".").join(path)).ok());
    let (folder, file) = (folder?, file?);
    let (folder, file) = (normal(&folder), normal(&file));
    let shared = folder.iter().zip(&file).take_while(|(a, b)| a == b).count();
    let up = folder[shared..].iter().map(|_| Some(".."));
    let down = file[shared..].iter().map(|part| part.as_os_str().to_str());
    Some(up.chain(down).collect::<Option<Vec<_>>>()?.join("/"))
}

/// The components of an absolute path, with `..` resolved by name.
fn normal(path: &Path) -> Vec<Component<'_>> {
    let mut components = Vec::new();
    for component in path.components() {
        match component {
            Component::ParentDir => drop(components.pop()),
            other => components.push(other),
        }
    }
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_folder() {
        for (folder, file, expected) in [
            ("", "a.glb", "a.glb"),
            ("renders", "renders/a/b.glb", "a/b.glb"),
            ("renders", "renders/../light.hdr", "../light.hdr"),
            ("a/b", "c/d.glb", "../../c/d.glb"),
            ("/x/y", "/x/z/a.glb", "../z/a.glb"),
        ] {
            assert_eq!(relative(Path::new(folder), Path::new(file)).as_deref(), Some(expected));
        }
    }
}
