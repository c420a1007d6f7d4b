//! Discovery of the shots of a suite.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};

use super::super::folder_files::files_below;
use super::names::{name_below, possible_shots, same_file};
use super::suite_file::SuiteToml;
use super::{SUITE_FILE, Suite};
use crate::canonical_path::canonical;
use crate::error::{Error, Result};
use crate::image_file::job_files;
use crate::shot::scene_of_shot;

/// One image or sequence of a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SuiteShot {
    /// The path below the suite's scenes, without extension, with `/` on every system.
    pub name: String,
    /// The shot file, or a scene that is a shot by itself.
    pub path: PathBuf,
    /// The scene; the shot file where it names none that exists.
    pub scene: PathBuf,
}

/// All shots of a suite, sorted by name: its shot files, and the scenes that no shot file names, or only shot files with `whole_scene`.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read, [`Error::Invalid`] when images of two shots would share a name.
pub fn discover(suite: &Suite) -> Result<Vec<SuiteShot>> {
    Ok(discover_files(suite)?.0)
}

/// All shots of a suite, and its files `.toml` that have no setting of a shot and are no camera paths.
///
/// # Errors
/// Those of [`discover`].
pub(super) fn discover_files(suite: &Suite) -> Result<(Vec<SuiteShot>, Vec<PathBuf>)> {
    let OwnFiles { shot_files, scenes, stray } = own_files(suite)?;
    let mut named = BTreeSet::new();
    let mut shots = Vec::new();
    let shot = |path: PathBuf, scene: PathBuf| {
        let name = name_below(&suite.scenes, &path.with_extension(""))?;
        Some(SuiteShot { name, path, scene })
    };
    let mut whole = BTreeSet::new();
    for path in shot_files {
        let scene = scene_of_shot(&path).ok().filter(|scene| scene.exists());
        match &scene {
            // An error is reported when the shot is rendered.
            Some(scene) if suite.coverage_of(&path).is_ok_and(|coverage| coverage.whole_scene) => {
                whole.insert(same_file(scene));
            }
            Some(scene) => named.extend([same_file(scene)]),
            // The error is reported when the shot is rendered. Most likely it names the scene beside it.
            None => named.extend(["gltf", "glb"].map(|extension| same_file(&path.with_extension(extension)))),
        }
        let scene = scene.unwrap_or_else(|| path.clone());
        shots.extend(shot(path, scene));
    }
    let is_shot = |scene: &PathBuf| {
        let scene = same_file(scene);
        whole.contains(&scene) || !named.contains(&scene)
    };
    let unnamed = scenes.into_iter().filter(is_shot);
    shots.extend(unnamed.filter_map(|scene| shot(scene.clone(), scene)));
    shots.sort_by(|a, b| a.name.cmp(&b.name));
    refuse_shared_names(&shots)?;
    Ok((shots, stray))
}

/// Refuses shots that share a reference, also on file systems that ignore case.
fn refuse_shared_names(shots: &[SuiteShot]) -> Result<()> {
    let mut names = BTreeMap::new();
    for shot in shots {
        if let Some(other) = names.insert(shot.name.to_lowercase(), shot) {
            let message = format!(
                "and {} would share the reference {}.exr; rename one of them",
                other.path.display(),
                shot.name
            );
            return Err(Error::invalid(&shot.path, "", message));
        }
    }
    let frame = shots.iter().find_map(|shot| {
        let name = shot.name.to_lowercase();
        let other = possible_shots(&name).skip(1).find_map(|name| names.get(name))?;
        Some((shot, *other))
    });
    match frame {
        Some((shot, other)) => {
            let message = format!("has the name of an image of {}; rename one of them", other.path.display());
            Err(Error::invalid(&shot.path, "", message))
        }
        None => Ok(()),
    }
}

/// Files of a suite.
struct OwnFiles {
    shot_files: Vec<PathBuf>,
    scenes: Vec<PathBuf>,
    stray: Vec<PathBuf>,
}

/// Files of the suite, except those of suites below it, of its references, of its report and of jobs of `rayframe farm`.
fn own_files(suite: &Suite) -> Result<OwnFiles> {
    let (toml, mut models): (Vec<_>, Vec<_>) = files_below(&suite.scenes)?
        .into_iter()
        .filter(|file| has_extension(file, &["toml", "gltf", "glb"]))
        .partition(|file| has_extension(file, &["toml"]));
    let mut by_kind = BTreeMap::<_, Vec<PathBuf>>::new();
    for file in toml {
        by_kind.entry(SuiteToml::of(&file)).or_default().push(file);
    }
    let mut of_kind = |kind| by_kind.remove(&kind).unwrap_or_default();
    let (suites, mut shot_files, mut stray) =
        (of_kind(SuiteToml::Suite), of_kind(SuiteToml::Shot), of_kind(SuiteToml::Stray));
    let scenes = same_file(&suite.scenes);
    let below =
        |folder: PathBuf| Some(folder).filter(|folder| *folder != scenes && folder.starts_with(&scenes));
    let named = suites.iter().filter(|file| file.file_name() == Some(OsStr::new(SUITE_FILE)));
    let others = named.filter_map(|file| below(same_file(file).parent()?.to_owned()));
    let results = [&suite.references, &suite.report, &suite.cache]
        .into_iter()
        .filter_map(|folder| below(same_file(folder)));
    let skipped: Vec<PathBuf> = others.chain(results).collect();
    let excluded = ExcludedPaths::new(suite);
    let is_own = |file: &PathBuf| {
        let real = same_file(file);
        !excluded.contains(file) && !skipped.iter().any(|folder| real.starts_with(folder))
    };
    for files in [&mut shot_files, &mut models, &mut stray] {
        files.retain(is_own);
    }
    shot_files.retain(|file| !is_job_file(file));
    Ok(OwnFiles { shot_files, scenes: models, stray })
}

/// The files and folders that `exclude` names. A link among them is excluded, and what it leads to is not.
pub(super) struct ExcludedPaths<'a> {
    scenes: &'a Path,
    /// The folder of the scenes, without links.
    root: PathBuf,
    paths: Vec<PathBuf>,
}

impl<'a> ExcludedPaths<'a> {
    pub(super) fn new(suite: &'a Suite) -> Self {
        let root = same_file(&suite.scenes);
        let mut excluded = Self { scenes: &suite.scenes, root, paths: Vec::new() };
        excluded.paths = suite.excluded.iter().map(|path| excluded.own_path(path)).collect();
        excluded
    }

    /// Whether `file` or a folder above it is excluded.
    pub(super) fn contains(&self, file: &Path) -> bool {
        let file = self.own_path(file);
        self.paths.iter().any(|path| file.starts_with(path))
    }

    /// An absolute path in which links below the folder of the scenes are kept.
    fn own_path(&self, path: &Path) -> PathBuf {
        let is_below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        match path.strip_prefix(self.scenes) {
            Ok(below) if below.components().all(is_below) => self.root.join(below),
            // It may be below under another name of the folder.
            _ => canonical(path),
        }
    }
}

/// Whether `rayframe farm` wrote `file` among the files of a job.
fn is_job_file(file: &Path) -> bool {
    let (Some(folder), Some(name)) = (file.parent(), file.file_name()) else { return false };
    job_files(folder).contains_key(&*name.to_string_lossy())
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
}

/// The scenes that shot files name.
pub(super) struct NamedScenes<'a>(BTreeMap<PathBuf, &'a SuiteShot>);

impl<'a> NamedScenes<'a> {
    /// Those of `shots`.
    pub(super) fn new(shots: &'a [SuiteShot]) -> Self {
        let of_shot_files = shots.iter().filter(|shot| shot.scene != shot.path);
        // The first shot file of a scene counts.
        Self(of_shot_files.rev().map(|shot| (same_file(&shot.scene), shot)).collect())
    }

    /// The first shot file that names the scene `path`.
    pub(super) fn shot_file(&self, path: &Path) -> Option<&'a SuiteShot> {
        self.0.get(&same_file(path)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discovered(files: &[(&str, &str)]) -> Result<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files.iter().chain(&[(SUITE_FILE, "exclude = ['cache/old']")]) {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let shots = discover(&Suite::read(folder.path())?)?;
        Ok(shots.into_iter().map(|shot| shot.name).collect())
    }

    #[test]
    fn shots_are_shot_files_and_unnamed_scenes() {
        let shots = discovered(&[
            ("b/close.toml", "scene = 'robot.glb'"),
            ("b/far.toml", "scene = './robot.glb'"),
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
    fn a_scene_keeps_its_coverage_where_a_shot_file_says_so() {
        let files = |test: &str| {
            let near = format!("scene = 'robot.glb'\n[test]\n{test}");
            discovered(&[("near.toml", &near), ("far.toml", "scene = 'robot.glb'"), ("robot.glb", "")])
        };
        assert_eq!(files("").unwrap(), ["far", "near"]);
        assert_eq!(files("whole_scene = false").unwrap(), ["far", "near"]);
        assert_eq!(files("whole_scene = true").unwrap(), ["far", "near", "robot"]);
        // Their images have one name.
        let same = [("robot.toml", "scene = 'robot.glb'\n[test]\nwhole_scene = true"), ("robot.glb", "")];
        assert!(discovered(&same).unwrap_err().to_string().contains("rename one of them"));
    }

    #[test]
    fn shots_may_not_share_a_reference() {
        for files in [["a.glb", "a.gltf"], ["a.glb", "A.gltf"]] {
            let error = discovered(&files.map(|name| (name, ""))).unwrap_err().to_string();
            assert!(error.contains("would share the reference"), "{error}");
        }
        let error = discovered(&[("walk.glb", ""), ("walk.0012.glb", "")]).unwrap_err().to_string();
        assert!(error.contains("walk.0012.glb") && error.contains("name of an image of"), "{error}");
        // Names that Blender gives to copies.
        let copies = discovered(&[("chair.glb", ""), ("chair.001.glb", "")]);
        assert_eq!(copies.unwrap(), ["chair", "chair.001"]);
        assert_eq!(discovered(&[]).unwrap(), [] as [&str; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_cycles_end() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("suite/a")).unwrap();
        std::fs::create_dir(at("models")).unwrap();
        std::fs::write(at("models/m.glb"), "").unwrap();
        std::fs::write(at("suite").join(SUITE_FILE), "").unwrap();
        std::os::unix::fs::symlink(at("models"), at("suite/linked")).unwrap();
        std::os::unix::fs::symlink(at("suite"), at("suite/a/cycle")).unwrap();
        let shots = discover(&Suite::read(&at("suite")).unwrap()).unwrap();
        assert_eq!(shots.iter().map(|shot| shot.name.as_str()).collect::<Vec<_>>(), ["linked/m"]);
    }

    #[cfg(unix)]
    #[test]
    fn exclusion_compares_the_names_of_links_and_not_what_they_lead_to() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for below in ["in", "out"] {
            std::fs::create_dir(at(below)).unwrap();
        }
        for scene in ["in/b.glb", "out/c.glb"] {
            std::fs::write(at(scene), "").unwrap();
        }
        for (link, target) in [("link.glb", "in/b.glb"), ("in/d.glb", "out/c.glb"), ("linked", "out")] {
            std::os::unix::fs::symlink(at(target), at(link)).unwrap();
        }
        let shots = |excluded: &str| {
            std::fs::write(at(SUITE_FILE), format!("exclude = ['{excluded}']")).unwrap();
            let shots = discover(&Suite::read(folder.path()).unwrap()).unwrap();
            shots.into_iter().map(|shot| shot.name).collect::<Vec<_>>()
        };
        let without_in = ["link", "linked/c", "out/c"];
        assert_eq!(shots("in"), without_in);
        assert_eq!(shots(&at("in").display().to_string()), without_in);
        assert_eq!(shots("./link.glb"), ["in/b", "in/d", "linked/c", "out/c"]);
        assert_eq!(shots("linked"), ["in/b", "in/d", "link", "out/c"]);
        assert_eq!(shots("linked/c.glb"), shots("linked"));
        assert_eq!(shots("out"), ["in/b", "in/d", "link", "linked/c"]);
    }
}
