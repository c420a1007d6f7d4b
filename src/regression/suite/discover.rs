//! Which shots a suite has.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::names::{files_below, name_below, numbered_shot};
use super::suite_file::is_suite_file;
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
/// [`Error::Missing`] when a folder cannot be read, [`Error::Invalid`] when pictures of two shots would have one name.
pub fn discover(suite: &Suite, reader: &dyn ShotReader) -> Result<Vec<SuiteShot>> {
    let (shot_files, scenes): (Vec<_>, Vec<_>) =
        own_files(suite)?.into_iter().partition(|file| has_extension(file, &["toml"]));
    let mut named = BTreeSet::new();
    for shot in &shot_files {
        match reader.scene(shot) {
            Ok(scene) if scene.exists() => {
                named.insert(same_file(&scene));
            }
            // What is wrong with it is said when it is rendered. It most likely names the scene beside it.
            _ => {
                named.extend(["gltf", "glb"].map(|extension| same_file(&shot.with_extension(extension))));
            }
        }
    }
    let bare = scenes.into_iter().filter(|scene| !named.contains(&same_file(scene)));
    let shots = shot_files.into_iter().chain(bare).filter_map(|path| {
        let name = name_below(&suite.scenes, &path.with_extension(""))?;
        Some(SuiteShot { name, path })
    });
    let mut shots: Vec<_> = shots.collect();
    shots.sort_by(|a, b| a.name.cmp(&b.name));
    refuse_to_share_names(&shots)?;
    Ok(shots)
}

/// No two shots may ask for one reference, nor for two that some systems take for one.
fn refuse_to_share_names(shots: &[SuiteShot]) -> Result<()> {
    let mut names = BTreeMap::new();
    for shot in shots {
        if let Some(other) = names.insert(shot.name.to_lowercase(), shot) {
            let message = format!(
                "and {} would have one reference, {}.exr; rename one of them",
                other.path.display(),
                shot.name
            );
            return Err(Error::invalid(&shot.path, "", message));
        }
    }
    let frame =
        shots.iter().find_map(|shot| Some((shot, *names.get(&numbered_shot(&shot.name)?.to_lowercase())?)));
    match frame {
        Some((shot, other)) => {
            let message = format!("is called as a frame of {}; rename one of them", other.path.display());
            Err(Error::invalid(&shot.path, "", message))
        }
        None => Ok(()),
    }
}

/// Shot files and scenes of the suite, without those of suites below it, its references and its report.
fn own_files(suite: &Suite) -> Result<Vec<PathBuf>> {
    let files = files_below(&suite.scenes)?;
    let (suites, mut files): (Vec<_>, Vec<_>) = files
        .into_iter()
        .filter(|file| has_extension(file, &["toml", "gltf", "glb"]))
        .partition(|file| has_extension(file, &["toml"]) && is_suite_file(file));
    let scenes = same_file(&suite.scenes);
    let below =
        |folder: PathBuf| Some(folder).filter(|folder| *folder != scenes && folder.starts_with(&scenes));
    let named = suites.iter().filter(|file| file.file_name() == Some(OsStr::new(SUITE_FILE)));
    let others = named.filter_map(|file| below(same_file(file).parent()?.to_owned()));
    let results =
        [&suite.references, &suite.report].into_iter().filter_map(|folder| below(same_file(folder)));
    let excluded = suite.excluded.iter().map(|path| same_file(path));
    let left_out: Vec<PathBuf> = others.chain(results).chain(excluded).collect();
    files.retain(|file| {
        let file = same_file(file);
        !left_out.iter().any(|folder| file.starts_with(folder))
    });
    Ok(files)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
}

/// One path for all that name a file.
fn same_file(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes the text of a shot file for the name of its scene.
    struct TextIsScene;

    impl ShotReader for TextIsScene {
        fn scene(&self, shot: &Path) -> Result<PathBuf> {
            let text = std::fs::read_to_string(shot).map_err(Error::missing(shot))?;
            let scene = text.strip_prefix("# ").ok_or_else(|| Error::invalid(shot, "", "names no scene"))?;
            Ok(shot.with_file_name(scene))
        }

        fn job(&self, _: &Suite, shot: &Path) -> Result<(SequenceJob, Vec<Warning>)> {
            Err(Error::invalid(shot, "", "is not read here"))
        }
    }

    fn discovered(files: &[(&str, &str)]) -> Result<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files.iter().chain(&[(SUITE_FILE, "exclude = ['cache/old']")]) {
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
            ("b/close.toml", "# robot.glb"),
            ("b/far.toml", "# ./robot.glb"),
            ("b/lamp.toml", "samples"),
            ("b/fast.toml", "[shot]\nsamples = 1"),
            ("b/robot.glb", ""),
            ("b/lamp.gltf", ""),
            ("b/lamp.bin", ""),
            ("a.v2.GLB", ""),
            (".cache/hidden.glb", ""),
            ("cache/old/a.glb", ""),
            ("references/b/old.gltf", ""),
            ("report/x.toml", "x"),
            ("inner/suite.toml", ""),
            ("inner/c.glb", ""),
        ]);
        assert_eq!(shots.unwrap(), ["a.v2", "b/close", "b/far", "b/lamp"]);
    }

    #[test]
    fn names_stand_for_one_reference() {
        for files in [["a.glb", "a.gltf"], ["a.glb", "A.gltf"]] {
            let told = discovered(&files.map(|name| (name, ""))).unwrap_err().to_string();
            assert!(told.contains("would have one reference"), "{told}");
        }
        let told = discovered(&[("walk.glb", ""), ("walk.0012.glb", "")]).unwrap_err().to_string();
        assert!(told.contains("walk.0012.glb") && told.contains("as a frame of"), "{told}");
        assert_eq!(discovered(&[]).unwrap(), [] as [&str; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_lead_to_an_end() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("suite/a")).unwrap();
        std::fs::create_dir(at("models")).unwrap();
        std::fs::write(at("models/m.glb"), "").unwrap();
        std::fs::write(at("suite").join(SUITE_FILE), "").unwrap();
        std::os::unix::fs::symlink(at("models"), at("suite/linked")).unwrap();
        std::os::unix::fs::symlink(at("suite"), at("suite/a/round")).unwrap();
        let shots = discover(&Suite::read(&at("suite")).unwrap(), &TextIsScene).unwrap();
        assert_eq!(shots.iter().map(|shot| shot.name.as_str()).collect::<Vec<_>>(), ["linked/m"]);
    }
}
