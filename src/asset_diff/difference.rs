//! What differs between the facts of two assets.

use std::collections::BTreeMap;

use serde::Serialize;

use super::facts::AssetFacts;
use super::facts::nodes::IN_NO_SCENE;
use super::group_kind::GroupKind;
use super::item::{Item, Property};
use super::matching::Matching;
use super::value::Value;

/// The difference of two assets: changes by group in the order of [`GroupKind`], within a group first what is removed, then what is
/// added, then what is changed, each in the order of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssetDifference {
    /// The changes.
    pub changes: Vec<Change>,
    /// The pairs of items, by group.
    pub(super) matchings: BTreeMap<GroupKind, Matching>,
}

/// What happened to an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChangeKind {
    /// Only the reference has it.
    Removed,
    /// Only the actual asset has it.
    Added,
    /// Both have it, with different properties.
    Changed,
}

/// A change of one item.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// What the item is.
    pub group: GroupKind,
    /// What happened to it.
    pub kind: ChangeKind,
    /// Its name in the reference, or in the actual asset where that alone has it.
    pub name: String,
    /// Whether content is lost: a clip, a camera, a light, a variant, a node with a mesh, a mesh's morph targets, or a clip's motion.
    pub is_loss: bool,
    /// The properties that differ. Those of an item that only one side has are all that the side has.
    pub properties: Vec<PropertyChange>,
}

/// A change of one property.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PropertyChange {
    /// The property.
    pub property: String,
    /// Its value in the reference; `None` where that does not have it.
    pub reference: Option<Value>,
    /// Its value in the actual asset.
    pub actual: Option<Value>,
}

impl AssetDifference {
    /// Compares two assets.
    pub fn new(actual: &AssetFacts, reference: &AssetFacts) -> Self {
        let groups = || actual.groups.iter().zip(&reference.groups);
        let matchings: BTreeMap<_, _> = groups()
            .map(|(ours, theirs)| (theirs.group, Matching::new(&ours.items, &theirs.items)))
            .collect();
        let mut changes = Vec::new();
        for (ours, theirs) in groups() {
            let Some(matching) = matchings.get(&theirs.group) else { continue };
            let removed = matching.removed.iter().map(|&index| removed(theirs.group, &theirs.items[index]));
            let added = matching.added.iter().map(|&index| added(ours.group, &ours.items[index]));
            let changed = matching.pairs.iter().filter_map(|&(actual, reference)| {
                changed(ours.group, (&ours.items[actual], &theirs.items[reference]), &matchings)
            });
            changes.extend(removed.chain(added).chain(changed));
        }
        Self { changes, matchings }
    }

    /// Changes that lose content.
    pub fn losses(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| change.is_loss)
    }
}

impl Change {
    fn leaves_all_scenes(&self) -> bool {
        self.properties.iter().any(|change| change.property == IN_NO_SCENE && change.actual.is_some())
    }

    /// The loss in words, such as `lost: clip "walk"`.
    pub fn loss_text(&self) -> String {
        let what = self.group.name().trim_end_matches('s');
        match (self.group, self.kind) {
            (GroupKind::Clips, ChangeKind::Changed) => {
                format!("lost: the motion of the clip \"{}\"", self.name)
            }
            (GroupKind::Meshes, _) => format!("lost: morph targets of the mesh \"{}\"", self.name),
            (GroupKind::Nodes, ChangeKind::Removed) => format!("lost: node \"{}\" with a mesh", self.name),
            (GroupKind::Nodes, _) if self.leaves_all_scenes() => {
                format!("lost: node \"{}\" with a mesh, which stands in no scene any more", self.name)
            }
            (GroupKind::Nodes, _) => format!("lost: the mesh of the node \"{}\"", self.name),
            (_, ChangeKind::Changed) => {
                format!("lost: {what} \"{}\", which nothing uses any more", self.name)
            }
            _ => format!("lost: {what} \"{}\"", self.name),
        }
    }
}

fn removed(group: GroupKind, item: &Item) -> Change {
    let properties =
        item.properties.iter().map(|property| property_change(&property.name, Some(&property.value), None));
    Change {
        group,
        kind: ChangeKind::Removed,
        name: item.name.clone(),
        // Nothing outside of the file can refer to a node without a name.
        is_loss: item.is_content && (item.is_named || group != GroupKind::Nodes),
        properties: properties.collect(),
    }
}

fn added(group: GroupKind, item: &Item) -> Change {
    let properties =
        item.properties.iter().map(|property| property_change(&property.name, None, Some(&property.value)));
    Change {
        group,
        kind: ChangeKind::Added,
        name: item.name.clone(),
        is_loss: false,
        properties: properties.collect(),
    }
}

/// The properties that differ, in the reference's order, then those that only the actual item has.
fn changed(
    group: GroupKind,
    (actual, reference): (&Item, &Item),
    matchings: &BTreeMap<GroupKind, Matching>,
) -> Option<Change> {
    let mut properties = Vec::new();
    // Names of nodes are paths; one that moved in the hierarchy has another parent.
    let is_renamed = match group {
        GroupKind::Nodes => false,
        _ => actual.is_named != reference.is_named || (actual.is_named && actual.name != reference.name),
    };
    if is_renamed {
        let name = |item: &Item| item.is_named.then(|| Value::Text(item.name.clone()));
        properties.push(PropertyChange {
            property: "name".to_owned(),
            reference: name(reference),
            actual: name(actual),
        });
    }
    let [ours, theirs] = [actual, reference].map(by_name);
    for Property { name, value } in &reference.properties {
        let ours = ours.get(name.as_str()).copied();
        if ours.is_none_or(|ours| !is_same(ours, value, matchings)) {
            properties.push(property_change(name, Some(value), ours));
        }
    }
    let new = actual.properties.iter().filter(|property| !theirs.contains_key(property.name.as_str()));
    properties.extend(new.map(|property| property_change(&property.name, None, Some(&property.value))));
    let is_loss = reference.is_content && !actual.is_content
        || properties.iter().any(|change| loses_morph_targets(change) || loses_motion(change));
    let name = if reference.is_named { &reference.name } else { &actual.name };
    let change = Change { group, kind: ChangeKind::Changed, name: name.clone(), is_loss, properties };
    (change.is_loss || !change.properties.is_empty()).then_some(change)
}

/// The values of properties. Of equal names the first counts.
fn by_name(item: &Item) -> BTreeMap<&str, &Value> {
    item.properties.iter().rev().map(|property| (property.name.as_str(), &property.value)).collect()
}

/// Whether two values are equal; items are where they are a pair, whatever their names and indices.
fn is_same(actual: &Value, reference: &Value, matchings: &BTreeMap<GroupKind, Matching>) -> bool {
    match (actual, reference) {
        (Value::Item(group, actual, _), Value::Item(_, reference, _)) => {
            matchings.get(group).is_some_and(|matching| matching.pairs(*actual, *reference))
        }
        _ => actual.is_same(reference),
    }
}

fn property_change(name: &str, reference: Option<&Value>, actual: Option<&Value>) -> PropertyChange {
    PropertyChange { property: name.to_owned(), reference: reference.cloned(), actual: actual.cloned() }
}

/// Whether a mesh has fewer morph targets. Images do not show targets whose weights are zero.
fn loses_morph_targets(change: &PropertyChange) -> bool {
    let count = |value: &Option<Value>| match value {
        Some(Value::Count(count)) => *count,
        _ => 0,
    };
    change.property == "morph targets" && count(&change.actual) < count(&change.reference)
}

/// Whether a clip is still that moved. Images of its first, middle and last frame may all show one pose.
fn loses_motion(change: &PropertyChange) -> bool {
    change.property == "moves"
        && change.reference == Some(Value::Flag(true))
        && change.actual == Some(Value::Flag(false))
}

#[cfg(test)]
mod tests;
