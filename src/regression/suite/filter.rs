//! Which pictures a word on the command line means.

use std::collections::BTreeSet;

use super::SuiteShot;
use super::names::numbered_shot;

/// What a word means: in this order nothing in particular, one shot with all its pictures, one picture, one reference file
/// (`walk.exr`), and everything that contains it.
#[derive(Clone, Debug)]
pub(super) struct Filter<'a> {
    word: &'a str,
    meaning: Meaning,
    shots: BTreeSet<&'a str>,
    /// Shots of which a picture's name contains the word.
    of_pictures: BTreeSet<&'a str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    All,
    Shot,
    Picture,
    Part,
}

impl<'a> Filter<'a> {
    /// The meaning of `word` where there are these shots, and pictures of these names among the references.
    pub(super) fn new<'b>(
        word: &'a str,
        shots: &'a [SuiteShot],
        pictures: impl Iterator<Item = &'b str>,
    ) -> Self {
        let pictures: Vec<&str> = pictures.collect();
        let shots: BTreeSet<&str> = shots.iter().map(|shot| shot.name.as_str()).collect();
        let file_of_shot = [".toml", ".gltf", ".glb"].iter().find_map(|ending| word.strip_suffix(ending));
        let is_frame = numbered_shot(word).is_some_and(|shot| shots.contains(shot));
        let (word, meaning) = match (word.strip_suffix(".exr"), file_of_shot) {
            _ if word.is_empty() => (word, Meaning::All),
            _ if shots.contains(word) => (word, Meaning::Shot),
            (Some(picture), _) => (picture, Meaning::Picture),
            (_, Some(shot)) if shots.contains(shot) => (shot, Meaning::Shot),
            _ if is_frame || pictures.contains(&word) => (word, Meaning::Picture),
            _ => (word, Meaning::Part),
        };
        let containing = pictures.iter().filter(|picture| picture.contains(word));
        let of_pictures = containing.filter_map(|picture| owner(&shots, picture)).collect();
        Self { word, meaning, shots, of_pictures }
    }

    /// Whether the word is a name, so that it is a mistake if nothing of that name is there.
    pub(super) fn is_name(&self) -> bool {
        matches!(self.meaning, Meaning::Shot | Meaning::Picture)
    }

    /// Whether the shot `name` is meant, or a picture of it.
    pub(super) fn matches_shot(&self, name: &str) -> bool {
        match self.meaning {
            Meaning::All => true,
            Meaning::Shot => name == self.word,
            Meaning::Picture => owner(&self.shots, self.word) == Some(name),
            Meaning::Part => name.contains(self.word) || self.of_pictures.contains(name),
        }
    }

    /// Whether the picture `name` is meant.
    pub(super) fn matches_image(&self, name: &str) -> bool {
        match self.meaning {
            Meaning::All => true,
            Meaning::Shot => owner(&self.shots, name) == Some(self.word),
            Meaning::Picture => name == self.word,
            Meaning::Part => name.contains(self.word),
        }
    }

    /// The shot that the picture `name` belongs to.
    pub(super) fn owner(&self, name: &str) -> Option<&'a str> {
        owner(&self.shots, name)
    }
}

fn owner<'a>(shots: &BTreeSet<&'a str>, picture: &str) -> Option<&'a str> {
    let named = |name: &str| shots.get(name).copied();
    named(picture).or_else(|| named(numbered_shot(picture)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shots(names: &[&str]) -> Vec<SuiteShot> {
        names.iter().map(|name| SuiteShot { name: (*name).to_owned(), path: name.into() }).collect()
    }

    #[test]
    fn words_mean_the_narrowest_thing_of_their_name() {
        let shots = shots(&["point", "point_far", "walk"]);
        let pictures = ["point", "walk.0000", "walk.0012", "old"];
        let meant = |word: &str| {
            let filter = Filter::new(word, &shots, pictures.iter().copied());
            let all = ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"];
            all.into_iter().filter(|name| filter.matches_image(name)).collect::<Vec<_>>()
        };
        assert_eq!(meant("point"), ["point"]);
        assert_eq!(meant("point.toml"), ["point"]);
        assert_eq!(meant("poin"), ["point", "point_far"]);
        assert_eq!(meant("walk"), ["walk", "walk.0000", "walk.0012"]);
        assert_eq!(meant("walk.0012"), ["walk.0012"]);
        assert_eq!(meant("walk.exr"), ["walk"]);
        assert_eq!(meant("old"), ["old"]);
        assert_eq!(meant(""), ["point", "point_far", "walk", "walk.0000", "walk.0012", "old"]);
        let filter = Filter::new("walk.0012", &shots, pictures.iter().copied());
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        let filter = Filter::new("12", &shots, pictures.iter().copied());
        assert!(filter.matches_shot("walk") && !filter.matches_shot("point"));
        assert_eq!((filter.owner("point_far"), filter.owner("old")), (Some("point_far"), None));
    }
}
