//! The names of what a scene holds, which an image's file may list, so that lost content is noticed where it is not in the image.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::count_text::counted;

/// Bytes of names of one kind that are listed. Of more, only the number is.
const MAX_LISTED_BYTES: usize = 16 << 10;

/// The kind of a mesh's morph targets.
const MORPH_TARGET: &str = "morph_target";
/// The kind of a clip's motion.
const MOTION: &str = "motion";
/// The beginning of a line about the duration of a clip.
pub(crate) const DURATION: &str = "duration of clip";

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
    /// Numbers of morph targets by the names of the nodes whose meshes have them; `None` in references of earlier versions, and of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub morph_targets: Option<BTreeMap<String, usize>>,
    /// Animation clips that change anything over time; `None` in references of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moving_clips: Option<ContentNames>,
    /// Lights that stand in a scene of the file; only those that have a name, or whose node has one. `None` in references of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<ContentNames>,
    /// Checksums of the keyframes of clips by their names: of those that play, or of all where none does. `None` in references of earlier
    /// versions, and of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motions: Option<BTreeMap<String, String>>,
    /// Times of the last keyframes of the same clips, milliseconds; `None` in references of earlier versions, and of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub durations_ms: Option<BTreeMap<String, u64>>,
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
    /// What it is: `node`, `clip`, `camera`, `variant`, `light`, `morph_target` or `motion`.
    pub kind: &'static str,
    /// Its name in quotes, for morph targets that of the node and for motion that of the clip, or a number where names are not listed.
    pub name: String,
    /// How many there are of it: more than 1 only of morph targets.
    pub count: usize,
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
            let change = |kind, name, count| ContentChange { kind, name, count, is_lost };
            for ((kind, names), (_, others)) in more.kinds().into_iter().zip(less.kinds()) {
                changes.extend(names.without(others).into_iter().map(|name| change(kind, name, 1)));
            }
            if let (Some(lights), Some(others)) = (&more.lights, &less.lights) {
                changes.extend(lights.without(others).into_iter().map(|name| change("light", name, 1)));
            }
            // Of what is lost or new as a whole, nothing more is told.
            if let (Some(more_counts), Some(counts)) = (&more.morph_targets, &less.morph_targets) {
                let nodes = more.nodes.without(&less.nodes);
                for (node, count) in more_counts {
                    let (name, others) = (quoted(node), counts.get(node).copied().unwrap_or(0));
                    if *count > others && !nodes.contains(&name) {
                        changes.push(change(MORPH_TARGET, name, count - others));
                    }
                }
            }
            if let (Some(moving), Some(others)) = (&more.moving_clips, &less.moving_clips) {
                let clips = more.clips.without(&less.clips);
                let moving = moving.without(others).into_iter().filter(|name| !clips.contains(name));
                changes.extend(moving.map(|name| change(MOTION, name, 1)));
            }
        }
        changes
    }

    /// What both have and is another, one line each.
    pub fn alterations_since(&self, reference: &Self) -> Vec<String> {
        let mut lines = Vec::new();
        // One that came to rest is told as lost.
        let changes = self.changes_since(reference);
        let is_told = |name: &str| changes.iter().any(|change| change.kind == MOTION && change.name == name);
        for (clip, was, is) in altered(self.motions.as_ref(), reference.motions.as_ref()) {
            let name = quoted(clip);
            let duration = |content: &Self| content.durations_ms.as_ref()?.get(clip).copied();
            match (duration(reference), duration(self)) {
                _ if is_told(&name) || was == is => {}
                (Some(was), Some(is)) if was != is => {
                    lines.push(format!("{DURATION} {name}: {} s → {} s", seconds(was), seconds(is)));
                }
                _ => lines.push(format!("{} changed", content_text(MOTION, &name, 1))),
            }
        }
        lines
    }

    fn kinds(&self) -> [(&'static str, &ContentNames); 4] {
        let Self { nodes, clips, cameras, variants, .. } = self;
        [("node", nodes), ("clip", clips), ("camera", cameras), ("variant", variants)]
    }

    /// Numbers of morph targets by node, unless the names are too many.
    pub fn listed_morph_targets(
        targets: impl Iterator<Item = (String, usize)>,
    ) -> Option<BTreeMap<String, usize>> {
        let mut counts = BTreeMap::new();
        for (node, count) in targets.filter(|(_, count)| *count > 0) {
            *counts.entry(node).or_default() += count;
        }
        (counts.keys().map(String::len).sum::<usize>() <= MAX_LISTED_BYTES).then_some(counts)
    }

    /// Values by the names of clips, unless the names are too many. Clips of one name are numbered.
    pub fn listed_by_clip<T>(values: impl Iterator<Item = (String, T)>) -> Option<BTreeMap<String, T>> {
        let (mut listed, mut next_numbers, mut bytes) = (BTreeMap::new(), BTreeMap::<_, usize>::new(), 0);
        for (name, value) in values {
            let mut free = name.clone();
            while listed.contains_key(&free) {
                let number = next_numbers.entry(name.clone()).or_insert(2);
                free = format!("{name} ({number})");
                *number += 1;
            }
            bytes += free.len();
            if bytes > MAX_LISTED_BYTES {
                return None;
            }
            listed.insert(free, value);
        }
        Some(listed)
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
        names.iter().filter(is_only_here).map(|name| quoted(name)).collect()
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
        write!(formatter, "{what}: {}", content_text(self.kind, &self.name, self.count))
    }
}

/// The clips that both list, with both values.
fn altered<'a, T>(
    actual: Option<&'a BTreeMap<String, T>>,
    reference: Option<&'a BTreeMap<String, T>>,
) -> Vec<(&'a String, &'a T, &'a T)> {
    let (Some(actual), Some(reference)) = (actual, reference) else { return Vec::new() };
    actual.iter().filter_map(|(clip, is)| Some((clip, reference.get(clip)?, is))).collect()
}

fn seconds(milliseconds: u64) -> String {
    format!("{}.{:03}", milliseconds / 1000, milliseconds % 1000)
}

/// A name in quotes, as changes of content have it.
pub(crate) fn quoted(name: &str) -> String {
    format!("\"{}\"", name.escape_debug())
}

/// Words for content by its kind, its name and how many there are of it, as [`ContentChange`] has them.
pub(crate) fn content_text(kind: &str, name: &str, count: usize) -> String {
    match kind {
        MORPH_TARGET => format!("{} of {name}", counted(count, "morph target")),
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
        assert_eq!(SceneContent::parse(&reference.text()), Some(reference));
        assert_eq!(SceneContent::parse("nodes"), None);
    }

    fn told(actual: &SceneContent, reference: &SceneContent) -> Vec<String> {
        actual.changes_since(reference).iter().map(ToString::to_string).collect()
    }

    /// What references of earlier versions list.
    fn earlier() -> SceneContent {
        SceneContent::parse(r#"{"nodes":["face"],"clips":["wave"],"cameras":[],"variants":[]}"#).unwrap()
    }

    #[test]
    fn morph_targets_are_counted_by_node() {
        let with = |targets| SceneContent {
            morph_targets: SceneContent::listed_morph_targets([("face".to_owned(), targets)].into_iter()),
            ..earlier()
        };
        assert_eq!(told(&with(50), &with(52)), ["lost: 2 morph targets of \"face\""]);
        assert_eq!(told(&with(0), &with(1)), ["lost: 1 morph target of \"face\""]);
        assert_eq!(told(&with(52), &with(50)), ["new: 2 morph targets of \"face\""]);
        for (actual, reference) in [(with(52), earlier()), (earlier(), with(52)), (with(0), with(0))] {
            assert_eq!(told(&actual, &reference), [""; 0]);
        }
        let nothing = SceneContent { nodes: listed(&[]), ..with(0) };
        assert_eq!(told(&nothing, &with(52)), ["lost: node \"face\""]);
        assert_eq!(SceneContent::parse(&with(3).text()), Some(with(3)));
        let many = (0..5000).map(|number| (format!("a node of number {number:06}"), 2));
        assert_eq!(SceneContent::listed_morph_targets(many), None);
    }

    #[test]
    fn clips_that_stand_still_are_told_unless_they_are_lost() {
        let with = |moving: &[&str]| SceneContent { moving_clips: Some(listed(moving)), ..earlier() };
        assert_eq!(told(&with(&[]), &with(&["wave"])), ["lost: motion of clip \"wave\""]);
        assert_eq!(told(&with(&["wave"]), &with(&[])), ["new: motion of clip \"wave\""]);
        assert_eq!(told(&with(&["wave"]), &earlier()), [""; 0]);
        assert_eq!(told(&earlier(), &with(&["wave"])), [""; 0]);
        let nothing = SceneContent { clips: listed(&[]), ..with(&[]) };
        assert_eq!(told(&nothing, &with(&["wave"])), ["lost: clip \"wave\""]);
    }

    #[test]
    fn lost_lights_and_other_keyframes_are_told() {
        let with = |lights: &[&str], motion: &str| SceneContent {
            lights: Some(listed(lights)),
            motions: SceneContent::listed_by_clip([("wave".to_owned(), motion.to_owned())].into_iter()),
            ..earlier()
        };
        let altered = |actual: &SceneContent, reference: &SceneContent| actual.alterations_since(reference);
        assert_eq!(told(&with(&["lamp"], "a"), &with(&["lamp", "sun"], "a")), ["lost: light \"sun\""]);
        assert_eq!(altered(&with(&[], "a"), &with(&[], "a")), [""; 0]);
        assert_eq!(altered(&with(&[], "b"), &with(&[], "a")), ["motion of clip \"wave\" changed"]);
        for (actual, reference) in [(with(&[], "a"), earlier()), (earlier(), with(&["sun"], "a"))] {
            assert_eq!((told(&actual, &reference), altered(&actual, &reference)), (vec![], vec![]));
        }
        let lasting = |milliseconds: u64, motion| SceneContent {
            durations_ms: SceneContent::listed_by_clip([("wave".to_owned(), milliseconds)].into_iter()),
            ..with(&[], motion)
        };
        assert_eq!(
            altered(&lasting(779, "b"), &lasting(708, "a")),
            ["duration of clip \"wave\": 0.708 s → 0.779 s"]
        );
        assert_eq!(altered(&lasting(708, "b"), &lasting(708, "a")), ["motion of clip \"wave\" changed"]);
        assert_eq!(altered(&lasting(708, "b"), &with(&[], "a")), ["motion of clip \"wave\" changed"]);
        let frozen = SceneContent { moving_clips: Some(listed(&[])), ..with(&[], "b") };
        let moving = SceneContent { moving_clips: Some(listed(&["wave"])), ..with(&[], "a") };
        assert_eq!(altered(&frozen, &moving), [""; 0]);
        assert_eq!(SceneContent::parse(&moving.text()), Some(moving));
        let twice = [("wave".to_owned(), 1), ("wave".to_owned(), 2)].into_iter();
        let names: Vec<_> = SceneContent::listed_by_clip(twice).unwrap().into_keys().collect();
        assert_eq!(names, ["wave", "wave (2)"]);
        let taken = ["wave", "wave (2)", "wave", "wave"].map(|name| (name.to_owned(), ()));
        let names: Vec<_> = SceneContent::listed_by_clip(taken.into_iter()).unwrap().into_keys().collect();
        assert_eq!(names, ["wave", "wave (2)", "wave (3)", "wave (4)"]);
        // As soon as names are too many, no more are read.
        let endless = std::iter::repeat_with(|| ("wave".to_owned(), ()));
        assert_eq!(SceneContent::listed_by_clip(endless), None);
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
