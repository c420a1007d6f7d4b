//! The selection of shots and images by a word on the command line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::names::{kind_of, name_below, numbered_shot, possible_shots, same_file};
use super::rendered_images::is_below;
use super::{Suite, SuiteShot};

/// A selection of shots and images. A word selects, in this order of precedence: everything if it is empty, the shot of that name with
/// all of its images, the image or reference file (`walk.exr`) of that name, the shot or image whose file has that path, or everything
/// whose name contains the word.
#[derive(Clone, Debug)]
pub(super) struct Filter<'a> {
    word: String,
    selection: Selection,
    shots: BTreeSet<&'a str>,
    /// Shots with an image whose name contains the word.
    with_matching_images: BTreeSet<&'a str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Selection {
    All,
    Shot,
    Image,
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
            Selection::All | Selection::Shot => true,
            Selection::Image => {
                images.contains(&by_name.word.as_str()) || by_name.owner(&by_name.word).is_some()
            }
            Selection::Part => false,
        };
        if is_known {
            return by_name;
        }
        let path = Path::new(word);
        let shot = shot_of_path(suite, path, shots).map(|name| (name, Selection::Shot));
        match shot.or_else(|| Some((image_of_path(suite, path)?, Selection::Image))) {
            Some((word, selection)) => Self { word, selection, ..by_name },
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
        Self { word: word.to_owned(), selection, shots, with_matching_images }
    }

    /// Whether the word is the exact name of a shot or image.
    pub(super) fn is_name(&self) -> bool {
        matches!(self.selection, Selection::Shot | Selection::Image)
    }

    /// Whether the shot `name` is selected, or one of its images.
    pub(super) fn matches_shot(&self, name: &str) -> bool {
        match self.selection {
            Selection::All => true,
            Selection::Shot => name == self.word,
            Selection::Image => owner(&self.shots, &self.word) == Some(name),
            Selection::Part => name.contains(&self.word) || self.with_matching_images.contains(name),
        }
    }

    /// Whether the image `name` is selected.
    pub(super) fn matches_image(&self, name: &str) -> bool {
        match self.selection {
            Selection::All => true,
            Selection::Shot => owner(&self.shots, name) == Some(self.word.as_str()),
            Selection::Image => name == self.word,
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

/// The name of the shot whose file has this path, relative to the current folder or to that of the scenes.
fn shot_of_path(suite: &Suite, path: &Path, shots: &[SuiteShot]) -> Option<String> {
    let below_scenes = suite.scenes.join(path);
    let is_named = |shot: &&SuiteShot| shot.path == path || shot.path == below_scenes;
    let is_same = |shot: &&SuiteShot| {
        shot.path.file_name() == path.file_name() && without_links(&shot.path) == without_links(path)
    };
    let shot = shots.iter().find(is_named).or_else(|| shots.iter().find(is_same));
    shot.map(|shot| shot.name.clone())
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
