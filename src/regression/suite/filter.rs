//! The selection of shots and images by a word on the command line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::names::{kind_of, name_below, numbered_shot, possible_shots, same_file};
use super::rendered_images::is_below;
use super::{Suite, SuiteShot};

/// A selection of shots and images. A word selects, in this order of precedence: everything if it is empty, the shot of that name with
/// all of its images, the image or reference file (`walk.exr`) of that name, the shot or image whose file has that path, the shots that
/// render the scene of that path, or everything whose name contains the word.
#[derive(Clone, Debug)]
pub(super) struct Filter<'a> {
    word: String,
    selection: Selection,
    shots: BTreeSet<&'a str>,
    /// Shots whose file or scene has the path that the word is.
    of_path: BTreeSet<&'a str>,
    /// Shots with an image whose name contains the word.
    with_matching_images: BTreeSet<&'a str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Selection {
    All,
    Shot,
    Image,
    Path,
    Part,
}

impl<'a> Filter<'a> {
    /// The selection by `word`, a name or a path, among these shots of `suite`, and images of these names below its references.
    pub(super) fn new<'b>(
        suite: &Suite,
        word: &str,
        shots: &'a [SuiteShot],
        images: impl Iterator<Item = &'b str>,
    ) -> Self {
        let images: Vec<&str> = images.collect();
        let by_name = Self::by_name(word, shots, &images);
        let is_known = match by_name.selection {
            Selection::All | Selection::Shot | Selection::Path => true,
            Selection::Image => {
                images.contains(&by_name.word.as_str()) || by_name.owner(&by_name.word).is_some()
            }
            Selection::Part => false,
        };
        if is_known {
            return by_name;
        }
        let path = Path::new(word);
        let of_path = shots_of_path(suite, path, shots);
        if !of_path.is_empty() {
            return Self { selection: Selection::Path, of_path, ..by_name };
        }
        match image_of_path(suite, path) {
            Some(word) => Self { word, selection: Selection::Image, ..by_name },
            None => by_name,
        }
    }

    /// Everything.
    pub(super) fn all(shots: &'a [SuiteShot]) -> Self {
        Self::by_name("", shots, &[])
    }

    fn by_name(word: &str, shots: &'a [SuiteShot], images: &[&str]) -> Self {
        let shots: BTreeSet<&str> = shots.iter().map(|shot| shot.name.as_str()).collect();
        let file_of_shot = [".toml", ".gltf", ".glb"].iter().find_map(|ending| word.strip_suffix(ending));
        let file_of_image = kind_of(word);
        let is_image = numbered_shot(word).is_some_and(|name| owner(&shots, name).is_some());
        let (word, selection) = match (&file_of_image, file_of_shot) {
            _ if word.is_empty() => (word, Selection::All),
            _ if shots.contains(word) => (word, Selection::Shot),
            (Some(image), _) => (image.name(), Selection::Image),
            (_, Some(shot)) if shots.contains(shot) => (shot, Selection::Shot),
            _ if is_image || images.contains(&word) => (word, Selection::Image),
            _ => (word, Selection::Part),
        };
        let containing = images.iter().filter(|image| image.contains(word));
        let with_matching_images = containing.filter_map(|image| owner(&shots, image)).collect();
        Self { word: word.to_owned(), selection, shots, of_path: BTreeSet::new(), with_matching_images }
    }

    /// Whether the word is the exact name or path of shots or of an image.
    pub(super) fn is_name(&self) -> bool {
        matches!(self.selection, Selection::Shot | Selection::Image | Selection::Path)
    }

    /// Whether the shot `name` is selected, or one of its images.
    pub(super) fn matches_shot(&self, name: &str) -> bool {
        match self.selection {
            Selection::All => true,
            Selection::Shot => name == self.word,
            Selection::Image => owner(&self.shots, &self.word) == Some(name),
            Selection::Path => self.of_path.contains(name),
            Selection::Part => name.contains(&self.word) || self.with_matching_images.contains(name),
        }
    }

    /// Whether the image `name` is selected.
    pub(super) fn matches_image(&self, name: &str) -> bool {
        match self.selection {
            Selection::All => true,
            Selection::Shot => owner(&self.shots, name) == Some(self.word.as_str()),
            Selection::Image => name == self.word,
            Selection::Path => owner(&self.shots, name).is_some_and(|owner| self.of_path.contains(owner)),
            Selection::Part => name.contains(&self.word),
        }
    }

    /// The shot that renders the image `name`.
    pub(super) fn owner(&self, name: &str) -> Option<&'a str> {
        owner(&self.shots, name)
    }
}

fn owner<'a>(shots: &BTreeSet<&'a str>, image: &str) -> Option<&'a str> {
    possible_shots(image).find_map(|name| shots.get(name).copied())
}

/// The shot whose file has this path, relative to the current folder or to that of the scenes. Of a scene, the shot of its name, or else
/// all shots that render it.
fn shots_of_path<'a>(suite: &Suite, path: &Path, shots: &'a [SuiteShot]) -> BTreeSet<&'a str> {
    let below_scenes = suite.scenes.join(path);
    let is_named = |shot: &&SuiteShot| shot.path == path || shot.path == below_scenes;
    let is_same = |shot: &&SuiteShot| {
        shot.path.file_name() == path.file_name() && without_links(&shot.path) == without_links(path)
    };
    if let Some(shot) = shots.iter().find(is_named).or_else(|| shots.iter().find(is_same)) {
        return [shot.name.as_str()].into();
    }
    let is_scene = path
        .extension()
        .is_some_and(|found| ["gltf", "glb"].iter().any(|extension| found.eq_ignore_ascii_case(extension)));
    if !is_scene {
        return BTreeSet::new();
    }
    let names = scene_names(suite, path);
    if let Some(shot) = shots.iter().find(|shot| names.contains(&shot.name)) {
        return [shot.name.as_str()].into();
    }
    let scenes = [path, &below_scenes].map(same_file);
    let renders_it = shots.iter().filter(|shot| scenes.contains(&same_file(&shot.scene)));
    renders_it.map(|shot| shot.name.as_str()).collect()
}

/// The names that a shot of the scene at `path` would have.
fn scene_names(suite: &Suite, path: &Path) -> Vec<String> {
    let below = |folder: &Path, file: &Path| name_below(folder, &file.with_extension(""));
    let names = [
        below(&suite.scenes, path),
        below(&suite.scenes, &suite.scenes.join(path)),
        without_links(path).and_then(|path| below(&same_file(&suite.scenes), &path)),
    ];
    names.into_iter().flatten().collect()
}

/// The name of the image whose reference or pending file has this path, relative to the current folder.
fn image_of_path(suite: &Suite, path: &Path) -> Option<String> {
    let name = name_below(&suite.references, path)
        .filter(|name| is_below(name))
        .or_else(|| name_below(&same_file(&suite.references), &without_links(path)?));
    Some(kind_of(&name?)?.name().to_owned())
}

/// The path in its folder without links. The file itself may be one of several links.
fn without_links(path: &Path) -> Option<PathBuf> {
    Some(same_file(path.parent()?).join(path.file_name()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shots(names: &[&str]) -> Vec<SuiteShot> {
        names
            .iter()
            .map(|name| SuiteShot { name: (*name).to_owned(), path: name.into(), scene: name.into() })
            .collect()
    }

    #[test]
    fn exact_names_precede_partial_matches() {
        let shots = shots(&["point", "point_far", "walk"]);
        let images = ["point", "walk.0000", "walk.0012", "old"];
        let selected = |word: &str| {
            let filter = Filter::by_name(word, &shots, &images);
            let all = ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"];
            all.into_iter().filter(|name| filter.matches_image(name)).collect::<Vec<_>>()
        };
        assert_eq!(selected("point"), ["point"]);
        assert_eq!(selected("point.toml"), ["point"]);
        assert_eq!(selected("poin"), ["point", "point_far"]);
        assert_eq!(selected("walk"), ["walk", "walk.0000", "walk.0012"]);
        assert_eq!(selected("walk.0012"), ["walk.0012"]);
        assert_eq!(selected("walk.exr"), ["walk"]);
        assert_eq!(selected("walk.0012.exr.changed.new"), ["walk.0012"]);
        assert_eq!(selected("old"), ["old"]);
        assert_eq!(selected(""), ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"]);
        let filter = Filter::by_name("walk.0012", &shots, &images);
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        let filter = Filter::by_name("12", &shots, &images);
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        assert_eq!((filter.owner("point_far"), filter.owner("old")), (Some("point_far"), None));
    }

    #[test]
    fn paths_of_scenes_select_the_shots_that_render_them() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("sub/in")).unwrap();
        std::fs::write(at("suite.toml"), "scenes = 'sub'").unwrap();
        let suite = Suite::read(folder.path()).unwrap();
        let shot = |name: &str, file: &str, scene: &str| {
            let [path, scene] = [file, scene].map(|file| at("sub").join(file));
            for file in [&path, &scene] {
                std::fs::write(file, "").unwrap();
            }
            SuiteShot { name: name.to_owned(), path, scene }
        };
        let shots = [
            shot("far", "far.toml", "robot.glb"),
            shot("lamp", "lamp.toml", "lamp.gltf"),
            shot("near", "near.toml", "robot.glb"),
            shot("night", "night.toml", "lamp.gltf"),
        ];
        let selected = |path: PathBuf| {
            let filter = Filter::new(&suite, path.to_str().unwrap(), &shots, std::iter::empty());
            let names = ["far", "lamp", "near", "night"];
            let of_shots = names.into_iter().filter(|name| filter.matches_shot(name)).collect::<Vec<_>>();
            let of_images = names.into_iter().filter(|name| filter.matches_image(&format!("{name}.0012")));
            assert_eq!(of_images.collect::<Vec<_>>(), of_shots);
            (filter.is_name(), of_shots)
        };
        // The shot of its name precedes others of the scene.
        for path in ["lamp.gltf".into(), at("sub/lamp.gltf"), at("sub/in/../lamp.gltf")] {
            assert_eq!(selected(path), (true, vec!["lamp"]));
        }
        for path in ["robot.glb".into(), at("sub/robot.glb"), at("sub/in/../robot.glb")] {
            assert_eq!(selected(path), (true, vec!["far", "near"]));
        }
        for path in ["sub/lamp.png", "sub/in/lamp.gltf", "robot.glb"] {
            assert_eq!(selected(at(path)).1, [""; 0], "{path}");
        }
    }

    #[test]
    fn paths_of_files_are_names_where_no_name_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for below in ["models/chars", "refs/chars"] {
            std::fs::create_dir_all(at(below)).unwrap();
        }
        std::fs::write(at("suite.toml"), "scenes = 'models'\nreferences = 'refs'").unwrap();
        let suite = Suite::read(folder.path()).unwrap();
        let shot = |name: &str, file: &str| {
            let path = at("models").join(file);
            SuiteShot { name: name.to_owned(), path: path.clone(), scene: path }
        };
        let shots = [shot("chars/Fox", "chars/Fox.GLB"), shot("walk", "walk.toml")];
        let images = ["chars/Fox", "walk.0000", "walk.0012"];
        let selected = |path: PathBuf| {
            let filter = Filter::new(&suite, path.to_str().unwrap(), &shots, images.iter().copied());
            let selected = images.into_iter().filter(|name| filter.matches_image(name));
            (filter.is_name(), selected.collect::<Vec<_>>())
        };
        assert_eq!(selected(at("models/walk.toml")), (true, vec!["walk.0000", "walk.0012"]));
        assert_eq!(selected(at("models/chars/../walk.toml")), (true, vec!["walk.0000", "walk.0012"]));
        for path in ["models/chars/Fox.GLB", "refs/chars/Fox.exr", "refs/chars/../chars/Fox.exr.new"] {
            assert_eq!(selected(at(path)), (true, vec!["chars/Fox"]), "{path}");
        }
        // Relative to the scenes, where the ending is not in small letters.
        assert_eq!(selected("chars/Fox.GLB".into()), (true, vec!["chars/Fox"]));
        assert_eq!(selected(at("refs/walk.0012.exr")), (true, vec!["walk.0012"]));
        // Neither a path of the suite nor part of a name.
        for path in ["walk.toml", "walk.0012.exr", "refs"] {
            assert_eq!(selected(at(path)).1, [""; 0], "{path}");
        }
        assert_eq!(selected("walk".into()), (true, vec!["walk.0000", "walk.0012"]));
        assert_eq!(selected("ox".into()), (false, vec!["chars/Fox"]));
    }
}
