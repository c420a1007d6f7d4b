//! Which shots a suite has.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::names::{files_below, name_below};
use super::{SUITE_FILE, Suite};
use crate::error::{Error, Result, Warning};
use crate::sequence::SequenceJob;

/// One picture or sequence of a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SuiteShot {
    /// The path below the suite's scenes without extension, with `/` on every system.
    pub name: String,
    /// The shot file, or a scene that none names.
    pub path: PathBuf,
}

/// Understands shots.
pub trait ShotReader: Sync {
    /// The scene that a shot file names.
    ///
    /// # Errors
    /// Those of reading the shot file.
    fn scene(&self, shot: &Path) -> Result<PathBuf>;

    /// What is to be rendered for a shot file or a scene, with the settings that the suite has for all; and what is not honoured.
    ///
    /// # Errors
    /// Those of reading the shot file and loading the scene.
    fn job(&self, suite: &Suite, shot: &Path) -> Result<(SequenceJob, Vec<Warning>)>;
}

/// All shots of a suite in the order of their names: its shot files, and the scenes that none of them names.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read, [`Error::Invalid`] when two shots have one name or there is none.
pub fn discover(suite: &Suite, reader: &dyn ShotReader) -> Result<Vec<SuiteShot>> {
    let files = own_files(suite)?;
    let (shot_files, scenes): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|file| has_extension(file, &["toml"]));
    // What is wrong with a shot file is said when the shot is rendered.
    let named: BTreeSet<PathBuf> =
        shot_files.iter().filter_map(|shot| Some(same_file(&reader.scene(shot).ok()?))).collect();
    let bare = scenes.into_iter().filter(|scene| !named.contains(&same_file(scene)));
    let mut shots = BTreeMap::new();
    for path in shot_files.into_iter().chain(bare) {
        let Some(name) = name_below(&suite.scenes, &path.with_extension("")) else { continue };
        if let Some(other) = shots.insert(name.clone(), path.clone()) {
            let other = other.file_name().unwrap_or(OsStr::new("")).display().to_string();
            let message = format!("and \"{other}\" beside it are both called \"{name}\"; rename one of them");
            return Err(Error::invalid(&path, "", message));
        }
    }
    if shots.is_empty() {
        let message = "there is neither a shot file (.toml) nor a scene (.glb, .gltf) here; docs/suites.md tells how to begin";
        return Err(Error::invalid(place(&suite.scenes), "", message));
    }
    Ok(shots.into_iter().map(|(name, path)| SuiteShot { name, path }).collect())
}

/// Shot files and scenes of the suite, without those of suites below it, its references and its report.
fn own_files(suite: &Suite) -> Result<Vec<PathBuf>> {
    let mut files = files_below(&suite.scenes)?;
    let own = same_file(&suite.file);
    let others: Vec<PathBuf> = files
        .iter()
        .filter(|file| file.file_name() == Some(OsStr::new(SUITE_FILE)) && same_file(file) != own)
        .filter_map(|file| file.parent().map(Path::to_owned))
        .collect();
    let results = [&suite.references, &suite.report].map(|folder| same_file(folder));
    files.retain(|file| {
        has_extension(file, &["toml", "gltf", "glb"])
            && same_file(file) != own
            && !others.iter().any(|folder| file.starts_with(folder))
            && !results.iter().any(|folder| same_file(file).starts_with(folder))
    });
    Ok(files)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
}

/// One path for all that name a file.
fn same_file(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

fn place(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes the text of a shot file for the name of its scene.
    struct TextIsScene;

    impl ShotReader for TextIsScene {
        fn scene(&self, shot: &Path) -> Result<PathBuf> {
            let text = std::fs::read_to_string(shot).map_err(Error::missing(shot))?;
            Ok(shot.with_file_name(text))
        }

        fn job(&self, _: &Suite, shot: &Path) -> Result<(SequenceJob, Vec<Warning>)> {
            Err(Error::invalid(shot, "", "is not read here"))
        }
    }

    fn discovered(files: &[(&str, &str)]) -> Result<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files.iter().chain(&[(SUITE_FILE, "")]) {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let shots = discover(&Suite::read(folder.path())?, &TextIsScene)?;
        Ok(shots.into_iter().map(|shot| shot.name).collect())
    }

    #[test]
    fn shots_are_files_and_scenes_that_none_names() {
        let shots = discovered(&[
            ("b/close.toml", "robot.glb"),
            ("b/far.toml", "./robot.glb"),
            ("b/robot.glb", ""),
            ("b/lamp.gltf", ""),
            ("b/lamp.bin", ""),
            ("a.v2.GLB", ""),
            (".cache/hidden.glb", ""),
            ("references/b/old.gltf", ""),
            ("report/x.toml", "x"),
            ("inner/suite.toml", ""),
            ("inner/c.glb", ""),
        ]);
        assert_eq!(shots.unwrap(), ["a.v2", "b/close", "b/far", "b/lamp"]);
    }

    #[test]
    fn names_stand_for_one_shot_and_there_is_at_least_one() {
        let told = discovered(&[("a.glb", ""), ("a.gltf", "")]).unwrap_err().to_string();
        assert!(told.contains("both called \"a\""), "{told}");
        assert!(discovered(&[]).unwrap_err().to_string().contains("neither a shot file"));
    }
}
