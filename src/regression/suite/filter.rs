//! The selection of shots and images by a word on the command line.

use std::collections::BTreeSet;

use super::SuiteShot;
use super::names::{numbered_shot, possible_shots};

/// A selection of shots and images. A word selects, in this order of precedence: everything if it is empty, the shot of that name with
/// all of its images, the image or reference file (`walk.exr`) of that name, or everything whose name contains the word.
#[derive(Clone, Debug)]
pub(super) struct Filter<'a> {
    word: &'a str,
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
    /// The selection by `word` among these shots, and images of these names below the references.
    pub(super) fn new<'b>(
        word: &'a str,
        shots: &'a [SuiteShot],
        images: impl Iterator<Item = &'b str>,
    ) -> Self {
        let images: Vec<&str> = images.collect();
        let shots: BTreeSet<&str> = shots.iter().map(|shot| shot.name.as_str()).collect();
        let file_of_shot = [".toml", ".gltf", ".glb"].iter().find_map(|ending| word.strip_suffix(ending));
        let is_image = numbered_shot(word).is_some_and(|name| owner(&shots, name).is_some());
        let (word, selection) = match (word.strip_suffix(".exr"), file_of_shot) {
            _ if word.is_empty() => (word, Selection::All),
            _ if shots.contains(word) => (word, Selection::Shot),
            (Some(image), _) => (image, Selection::Image),
            (_, Some(shot)) if shots.contains(shot) => (shot, Selection::Shot),
            _ if is_image || images.contains(&word) => (word, Selection::Image),
            _ => (word, Selection::Part),
        };
        let containing = images.iter().filter(|image| image.contains(word));
        let with_matching_images = containing.filter_map(|image| owner(&shots, image)).collect();
        Self { word, selection, shots, with_matching_images }
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
            Selection::Image => owner(&self.shots, self.word) == Some(name),
            Selection::Part => name.contains(self.word) || self.with_matching_images.contains(name),
        }
    }

    /// Whether the image `name` is selected.
    pub(super) fn matches_image(&self, name: &str) -> bool {
        match self.selection {
            Selection::All => true,
            Selection::Shot => owner(&self.shots, name) == Some(self.word),
            Selection::Image => name == self.word,
            Selection::Part => name.contains(self.word),
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
            let filter = Filter::new(word, &shots, images.iter().copied());
            let all = ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"];
            all.into_iter().filter(|name| filter.matches_image(name)).collect::<Vec<_>>()
        };
        assert_eq!(selected("point"), ["point"]);
        assert_eq!(selected("point.toml"), ["point"]);
        assert_eq!(selected("poin"), ["point", "point_far"]);
        assert_eq!(selected("walk"), ["walk", "walk.0000", "walk.0012"]);
        assert_eq!(selected("walk.0012"), ["walk.0012"]);
        assert_eq!(selected("walk.exr"), ["walk"]);
        assert_eq!(selected("old"), ["old"]);
        assert_eq!(selected(""), ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"]);
        let filter = Filter::new("walk.0012", &shots, images.iter().copied());
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        let filter = Filter::new("12", &shots, images.iter().copied());
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        assert_eq!((filter.owner("point_far"), filter.owner("old")), (Some("point_far"), None));
    }
}
