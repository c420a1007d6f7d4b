//! The names of what a scene holds, which an image's file may list, so that lost content is noticed where it is not in the image.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Bytes of names of one kind that are listed. Of more, only the number is.
const MAX_LISTED_BYTES: usize = 16 << 10;

/// Names of the content of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneContent {
    /// Nodes with a mesh; only those that have a name.
    pub nodes: ContentNames,
    /// Animation clips.
    pub clips: ContentNames,
    /// Cameras.
    pub cameras: ContentNames,
    /// Material variants.
    pub variants: ContentNames,
}

/// Names of one kind of content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ContentNames {
    /// The names, sorted. Several items may share one.
    Listed(Vec<String>),
    /// The number of many.
    Counted(usize),
}

/// Content that only one of two scenes has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContentChange {
    /// What it is: `node`, `clip`, `camera` or `variant`.
    pub kind: &'static str,
    /// Its name in quotes, or a number where names are not listed.
    pub name: String,
    /// Whether the reference has it.
    pub is_lost: bool,
}

impl SceneContent {
    /// Name of the text attribute in EXR files.
    pub const ATTRIBUTE: &'static str = "sceneContent";

    /// The value of the attribute, JSON.
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The content of a value of the attribute; `None` for any other text.
    pub fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// What the reference has and this has not, then what is new.
    pub fn changes_since(&self, reference: &Self) -> Vec<ContentChange> {
        let mut changes = Vec::new();
        for is_lost in [true, false] {
            let (more, less) = if is_lost { (reference, self) } else { (self, reference) };
            for ((kind, names), (_, others)) in more.kinds().into_iter().zip(less.kinds()) {
                let only = names.without(others);
                changes.extend(only.into_iter().map(|name| ContentChange { kind, name, is_lost }));
            }
        }
        changes
    }

    fn kinds(&self) -> [(&'static str, &ContentNames); 4] {
        let Self { nodes, clips, cameras, variants } = self;
        [("node", nodes), ("clip", clips), ("camera", cameras), ("variant", variants)]
    }
}

impl ContentNames {
    /// Lists names in any order, or counts them.
    pub fn new(mut names: Vec<String>) -> Self {
        if names.iter().map(String::len).sum::<usize>() > MAX_LISTED_BYTES {
            return Self::Counted(names.len());
        }
        names.sort_unstable();
        Self::Listed(names)
    }

    fn count(&self) -> usize {
        match self {
            Self::Listed(names) => names.len(),
            Self::Counted(count) => *count,
        }
    }

    /// Those that `other` has not, or has fewer times.
    fn without(&self, other: &Self) -> Vec<String> {
        let (Self::Listed(names), Self::Listed(others)) = (self, other) else {
            let (count, all) = (self.count().saturating_sub(other.count()), self.count());
            return if count > 0 { vec![format!("({count} of {all})")] } else { Vec::new() };
        };
        let mut left = BTreeMap::<&str, usize>::new();
        for name in others {
            *left.entry(name).or_default() += 1;
        }
        let is_only_here = |name: &&String| match left.get_mut(name.as_str()) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => true,
        };
        names.iter().filter(is_only_here).map(|name| format!("\"{}\"", name.escape_debug())).collect()
    }
}

impl Default for ContentNames {
    fn default() -> Self {
        Self::Listed(Vec::new())
    }
}

impl std::fmt::Display for ContentChange {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = if self.is_lost { "lost" } else { "new" };
        write!(formatter, "{what}: {} {}", self.kind, self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(names: &[&str]) -> ContentNames {
        ContentNames::new(names.iter().map(|name| (*name).to_owned()).collect())
    }

    #[test]
    fn lost_and_new_content_is_named() {
        let reference = SceneContent {
            nodes: listed(&["hat", "wheel", "wheel"]),
            clips: listed(&["walk"]),
            ..SceneContent::default()
        };
        let actual = SceneContent {
            nodes: listed(&["wheel", "hat"]),
            cameras: listed(&["far"]),
            ..SceneContent::default()
        };
        let lines: Vec<_> = actual.changes_since(&reference).iter().map(ToString::to_string).collect();
        assert_eq!(lines, ["lost: node \"wheel\"", "lost: clip \"walk\"", "new: camera \"far\""]);
        assert!(reference.changes_since(&reference).is_empty());
        assert_eq!(SceneContent::parse(&reference.text()), Some(reference));
        assert_eq!(SceneContent::parse("nodes"), None);
    }

    #[test]
    fn long_lists_are_counted() {
        let many = |count: usize| SceneContent {
            nodes: ContentNames::new(
                (0..count).map(|number| format!("a node of number {number:06}")).collect(),
            ),
            ..SceneContent::default()
        };
        assert!(many(5000).text().len() < 100);
        let changes = many(4990).changes_since(&many(5000));
        assert_eq!(changes.iter().map(ToString::to_string).collect::<Vec<_>>(), ["lost: node (10 of 5000)"]);
        assert_eq!(SceneContent::parse(&many(5000).text()), Some(many(5000)));
    }
}
