//! The names of what a scene holds, which an image's file may list, so that lost content is noticed where it is not in the image.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Bytes of names of one kind that are listed. Of more, only the number is.
const MAX_LISTED_BYTES: usize = 16 << 10;

/// The kind of a mesh's morph targets.
const MORPH_TARGET: &str = "morph target";
/// The kind of a clip's motion.
const MOTION: &str = "motion";

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
    /// Names of nodes with a mesh, once for each of its morph targets. Only losses count: references of earlier versions list none.
    #[serde(default, skip_serializing_if = "ContentNames::is_empty")]
    pub morph_targets: ContentNames,
    /// Animation clips that change anything over time. Only losses count, as for morph targets.
    #[serde(default, skip_serializing_if = "ContentNames::is_empty")]
    pub moving_clips: ContentNames,
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
    /// What it is: `node`, `clip`, `camera`, `variant`, `morph target` or `motion`.
    pub kind: &'static str,
    /// Its name in quotes, for morph targets that of the node and for motion that of the clip, or a number where names are not listed.
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
                if [MORPH_TARGET, MOTION].contains(&kind) && !is_lost {
                    continue;
                }
                let mut only = names.without(others);
                // What is lost as a whole is told as such.
                let whole = match kind {
                    MORPH_TARGET => reference.nodes.without(&self.nodes),
                    MOTION => reference.clips.without(&self.clips),
                    _ => Vec::new(),
                };
                only.retain(|name| !whole.iter().any(|whole| quoted(whole) == quoted(name)));
                changes.extend(only.into_iter().map(|name| ContentChange { kind, name, is_lost }));
            }
        }
        changes
    }

    fn kinds(&self) -> [(&'static str, &ContentNames); 6] {
        let Self { nodes, clips, cameras, variants, morph_targets, moving_clips } = self;
        [
            ("node", nodes),
            ("clip", clips),
            ("camera", cameras),
            ("variant", variants),
            (MORPH_TARGET, morph_targets),
            (MOTION, moving_clips),
        ]
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

    fn is_empty(&self) -> bool {
        self.count() == 0
    }

    fn count(&self) -> usize {
        match self {
            Self::Listed(names) => names.len(),
            Self::Counted(count) => *count,
        }
    }

    /// Those that `other` has not, or has fewer times; each with how many times it is missing there, if more than once.
    fn without(&self, other: &Self) -> Vec<String> {
        let (Self::Listed(names), Self::Listed(others)) = (self, other) else {
            let (count, all) = (self.count().saturating_sub(other.count()), self.count());
            return if count > 0 { vec![format!("({count} of {all})")] } else { Vec::new() };
        };
        let mut missing = BTreeMap::<&str, isize>::new();
        for name in names {
            *missing.entry(name).or_default() += 1;
        }
        for name in others {
            *missing.entry(name).or_default() -= 1;
        }
        let text = |(name, count): (&str, isize)| match count {
            ..1 => None,
            1 => Some(format!("\"{}\"", name.escape_debug())),
            _ => Some(format!("\"{}\" ({count} times)", name.escape_debug())),
        };
        missing.into_iter().filter_map(text).collect()
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
        write!(formatter, "{what}: {}", content_text(self.kind, &self.name))
    }
}

/// The quoted part of the name of a change.
fn quoted(name: &str) -> &str {
    name.rfind('"').map_or(name, |end| &name[..=end])
}

/// Words for content by its kind and name, as [`ContentChange`] has them.
pub(crate) fn content_text(kind: &str, name: &str) -> String {
    match kind {
        MORPH_TARGET => format!("morph target of {name}"),
        MOTION => format!("motion of clip {name}"),
        _ => format!("{kind} {name}"),
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
        let counted = SceneContent { nodes: listed(&["wheel"; 4]), ..SceneContent::default() };
        let lines: Vec<_> = actual.changes_since(&counted).iter().map(ToString::to_string).collect();
        assert_eq!(lines, ["lost: node \"wheel\" (3 times)", "new: node \"hat\"", "new: camera \"far\""]);
        assert_eq!(SceneContent::parse(&reference.text()), Some(reference));
        assert_eq!(SceneContent::parse("nodes"), None);
    }

    #[test]
    fn lost_morph_targets_are_told_and_new_ones_are_not() {
        let with = |targets: usize| SceneContent {
            morph_targets: listed(&vec!["face"; targets]),
            ..SceneContent::default()
        };
        let told = |actual: &SceneContent, reference: &SceneContent| {
            actual.changes_since(reference).iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(told(&with(50), &with(52)), ["lost: morph target of \"face\" (2 times)"]);
        assert_eq!(told(&with(0), &with(1)), ["lost: morph target of \"face\""]);
        assert_eq!(told(&with(52), &with(50)), [""; 0]);
        // References of earlier versions do not list them.
        let earlier = SceneContent::parse(r#"{"nodes":[],"clips":[],"cameras":[],"variants":[]}"#).unwrap();
        assert_eq!(told(&with(52), &earlier), [""; 0]);
        assert_eq!(SceneContent::parse(&with(3).text()), Some(with(3)));
        let node = |targets| SceneContent { nodes: listed(&["face"]), ..with(targets) };
        assert_eq!(told(&SceneContent::default(), &node(2)), ["lost: node \"face\""]);
        let moving = SceneContent { moving_clips: listed(&["wave"]), ..SceneContent::default() };
        assert_eq!(told(&SceneContent::default(), &moving), ["lost: motion of clip \"wave\""]);
        let clip = SceneContent { clips: listed(&["wave"]), ..moving.clone() };
        assert_eq!(told(&SceneContent::default(), &clip), ["lost: clip \"wave\""]);
        assert_eq!(told(&moving, &earlier), [""; 0]);
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
