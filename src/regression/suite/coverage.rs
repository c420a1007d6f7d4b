//! What a suite tests of a scene: the keys `frames`, `cameras`, `views`, `clips`, `variants` and `whole_scene` of the table `[test]`.
//!
//! All keys but the last are lists, and all combinations of their elements are tested. A list that is absent leaves to the shot what it
//! is about.

use toml::de::{DeTable, DeValue};

use crate::error::Result;
use crate::framing::NamedView;
use crate::scene::NameOrIndex;
use crate::settings::{Named as _, NamedFrame, TomlEntry, TomlFile, entries, nearest, stored_frame};

/// Keys of the table that are not limits.
pub(super) const COVERAGE_KEYS: [&str; 6] = ["frames", "cameras", "views", "clips", "variants", WHOLE_SCENE];
/// The key by which a scene that a shot file names is a shot by itself, too.
pub(super) const WHOLE_SCENE: &str = "whole_scene";
/// The word for every element of the file.
const EACH: &str = "each";

/// What is tested of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    pub(super) frames: Option<Vec<NamedFrame>>,
    pub(super) cameras: Option<Covered>,
    pub(super) views: Option<Vec<NamedView>>,
    pub(super) clips: Option<Covered>,
    pub(super) variants: Option<Covered>,
    /// Whether the scene of a shot file is a shot by itself, too.
    pub(super) whole_scene: bool,
}

/// Elements of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Covered {
    /// Every one.
    Each,
    /// These.
    Named(Vec<NameOrIndex>),
}

impl Coverage {
    /// Applies the table `[test]` of a file, if it has one. Absent keys keep theirs.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::error::Error::Setting) with line and column of a wrong value.
    pub(super) fn with(mut self, file: &TomlFile<'_>, whole: &DeTable<'_>) -> Result<Self> {
        let test = entries(whole).into_iter().find(|entry| entry.key == "test");
        let Some(DeValue::Table(table)) = test.map(|test| test.value) else { return Ok(self) };
        for entry in entries(table) {
            match entry.key {
                "frames" => self.frames = Some(frames(file, entry)?),
                "cameras" => self.cameras = Some(covered(file, entry)?),
                "views" => self.views = Some(views(file, entry)?),
                "clips" => self.clips = Some(covered(file, entry)?),
                "variants" => self.variants = Some(covered(file, entry)?),
                WHOLE_SCENE => {
                    let DeValue::Boolean(value) = entry.value else {
                        return Err(file.wrong_kind(entry, "true or false"));
                    };
                    self.whole_scene = *value;
                }
                _ => {}
            }
        }
        Ok(self)
    }

    /// Whether no list is given.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self { whole_scene: self.whole_scene, ..Self::default() }
    }
}

/// `"each"`, or a list of names and `"#0"` for the first.
fn covered(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<Covered> {
    if entry.value.as_str() == Some(EACH) {
        return Ok(Covered::Each);
    }
    let expected = "\"each\", or an array of names, such as [\"walk\", \"#0\"]";
    let names = texts(file, entry, expected)?;
    Ok(Covered::Named(names.into_iter().map(NameOrIndex::parse).collect()))
}

fn views(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<Vec<NamedView>> {
    let names: Vec<&str> = NamedView::CHOICES.iter().map(|(_, name, _)| *name).collect();
    let view = |text: &str| {
        let found = NamedView::CHOICES.iter().find(|(_, name, _)| *name == text).map(|(view, ..)| *view);
        found.ok_or_else(|| {
            let hint = nearest(text, &names).map_or_else(
                || format!("; there are {}", names.join(", ")),
                |name| format!("; did you mean \"{name}\"?"),
            );
            file.wrong_value(entry, format!("there is no view \"{}\"{hint}", text.escape_debug()))
        })
    };
    let texts = texts(file, entry, "an array of views, such as [\"front\", \"left\"]")?;
    texts.into_iter().map(view).collect()
}

fn frames(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<Vec<NamedFrame>> {
    let expected = "an array of frames, such as [\"first\", \"middle\", \"last\"] or [0, 12]";
    let DeValue::Array(elements) = entry.value else { return Err(file.wrong_kind(entry, expected)) };
    let unexpected = || file.wrong_value(entry, format!("expected {expected}"));
    let frame = |value: &DeValue<'_>| match value {
        DeValue::Integer(number) => {
            let number = stored_frame(number.as_str(), number.radix());
            number.map(NamedFrame::Number).map_err(|why| file.wrong_value(entry, why))
        }
        DeValue::String(word) => match word.as_ref() {
            "first" => Ok(NamedFrame::First),
            "middle" => Ok(NamedFrame::Middle),
            "last" => Ok(NamedFrame::Last),
            _ => Err(unexpected()),
        },
        _ => Err(unexpected()),
    };
    let frames: Vec<_> = elements.iter().map(|element| frame(element.get_ref())).collect::<Result<_>>()?;
    if frames.is_empty() { Err(unexpected()) } else { Ok(frames) }
}

/// The texts of an array that is not empty.
fn texts<'t>(file: &TomlFile<'_>, entry: TomlEntry<'t>, expected: &str) -> Result<Vec<&'t str>> {
    let DeValue::Array(elements) = entry.value else { return Err(file.wrong_kind(entry, expected)) };
    let texts: Option<Vec<&str>> = elements.iter().map(|element| element.get_ref().as_str()).collect();
    match texts {
        Some(texts) if !texts.is_empty() => Ok(texts),
        _ => Err(file.wrong_value(entry, format!("expected {expected}"))),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn with(coverage: Coverage, text: &str) -> Result<Coverage> {
        let text = format!("[test]\n{text}");
        let file = TomlFile { path: Path::new("suite.toml"), text: &text };
        coverage.with(&file, &file.table()?)
    }

    #[test]
    fn keys_are_lists_and_replace_those_of_the_suite() {
        let suite =
            with(Coverage::default(), "clips = 'each'\nframes = ['first', 'middle', 'last', -3]").unwrap();
        assert_eq!(suite.clips, Some(Covered::Each));
        let frames = [NamedFrame::First, NamedFrame::Middle, NamedFrame::Last, NamedFrame::Number(-3)];
        assert_eq!(suite.frames.as_deref(), Some(&frames[..]));
        let shot = with(suite.clone(), "clips = ['walk', '#1']\nviews = ['front', 'three-quarter']").unwrap();
        let named = vec![NameOrIndex::Name("walk".to_owned()), NameOrIndex::Index(1)];
        assert_eq!((shot.clips, shot.frames), (Some(Covered::Named(named)), suite.frames));
        assert_eq!(shot.views, Some(vec![NamedView::Front, NamedView::ThreeQuarter]));
        assert!(with(Coverage::default(), "preset = 'exact'\nwhole_scene = true").unwrap().is_empty());
    }

    #[test]
    fn errors_say_what_to_write() {
        for (text, words) in [
            ("clips = 'walk'", "clips: expected \"each\", or an array of names"),
            ("cameras = []", "cameras: expected \"each\", or an array of names"),
            ("variants = [1]", "variants: expected \"each\", or an array of names"),
            ("views = ['fron']", "there is no view \"fron\"; did you mean \"front\"?"),
            ("views = 'front'", "views: expected an array of views"),
            ("whole_scene = 1", "whole_scene: expected true or false"),
            ("frames = 0", "frames: expected an array of frames"),
            ("frames = ['end']", "frames: expected an array of frames"),
            ("frames = []", "frames: expected an array of frames"),
            (
                "frames = [0, 99999999999]",
                "frames: 99999999999 is beyond the frame numbers that files can hold",
            ),
            ("frames = [-2147483649]", "frames: -2147483649 is beyond"),
            ("frames = [0xFFFFFFFFF]", "frames: 0xFFFFFFFFF is beyond"),
        ] {
            let error = with(Coverage::default(), text).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("suite.toml:2:1"), "{error}");
        }
    }
}
