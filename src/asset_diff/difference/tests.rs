//! Differences of small lists of items.

use super::*;
use crate::asset_diff::item::Group;

fn facts(group: GroupKind, items: Vec<Item>) -> AssetFacts {
    AssetFacts { groups: vec![Group { group, items }] }
}

fn item(name: &str, is_content: bool, properties: &[(&str, Value)]) -> Item {
    let mut item = Item { is_content, ..Item::new(Some(name), 0) };
    for (name, value) in properties {
        item.set(*name, value.clone());
    }
    item
}

fn count(count: u64) -> Value {
    Value::Count(count)
}

#[test]
fn equal_assets_have_no_changes() {
    let facts = facts(GroupKind::Clips, vec![item("walk", true, &[("channels", count(3))])]);
    assert_eq!(AssetDifference::new(&facts, &facts).changes, []);
}

#[test]
fn removed_comes_before_added_and_changed_with_old_and_new_values() {
    let reference = facts(
        GroupKind::Materials,
        vec![item("paint", false, &[("coat", count(1)), ("kept", count(7))]), item("old", false, &[])],
    );
    let actual = facts(
        GroupKind::Materials,
        vec![
            item("new", false, &[("sheen", count(2))]),
            item("paint", false, &[("kept", count(7)), ("film", count(4))]),
        ],
    );
    let changes = AssetDifference::new(&actual, &reference).changes;
    let told: Vec<_> = changes.iter().map(|change| (change.kind, change.name.as_str())).collect();
    let expected = [(ChangeKind::Removed, "old"), (ChangeKind::Added, "new"), (ChangeKind::Changed, "paint")];
    assert_eq!(told, expected);
    let lost = PropertyChange { property: "coat".to_owned(), reference: Some(count(1)), actual: None };
    let new = PropertyChange { property: "film".to_owned(), reference: None, actual: Some(count(4)) };
    assert_eq!(changes[2].properties, [lost, new]);
    assert!(changes.iter().all(|change| !change.is_loss));
}

#[test]
fn content_that_is_gone_is_a_loss_and_more_of_it_is_none() {
    let with = facts(GroupKind::Clips, vec![item("walk", true, &[])]);
    let without = facts(GroupKind::Clips, Vec::new());
    let lost = AssetDifference::new(&without, &with);
    let texts: Vec<_> = lost.losses().map(Change::loss_text).collect();
    assert_eq!(texts, ["lost: clip \"walk\""]);
    assert_eq!(AssetDifference::new(&with, &without).losses().count(), 0);
}

#[test]
fn fewer_morph_targets_are_a_loss() {
    let face =
        |targets| facts(GroupKind::Meshes, vec![item("face", false, &[("morph targets", count(targets))])]);
    let fewer = AssetDifference::new(&face(2), &face(52));
    assert_eq!(
        fewer.losses().map(Change::loss_text).collect::<Vec<_>>(),
        ["lost: morph targets of the mesh \"face\""]
    );
    assert_eq!(AssetDifference::new(&face(52), &face(2)).losses().count(), 0);
}

#[test]
fn clips_that_are_still_lost_their_motion() {
    let wave = |moves| facts(GroupKind::Clips, vec![item("wave", true, &[("moves", Value::Flag(moves))])]);
    let still = AssetDifference::new(&wave(false), &wave(true));
    assert_eq!(
        still.losses().map(Change::loss_text).collect::<Vec<_>>(),
        ["lost: the motion of the clip \"wave\""]
    );
    assert_eq!(AssetDifference::new(&wave(true), &wave(false)).losses().count(), 0);
}

#[test]
fn a_name_that_is_dropped_is_a_change() {
    let named = facts(GroupKind::Meshes, vec![item("face", false, &[])]);
    let unnamed = facts(GroupKind::Meshes, vec![Item::new(None, 0)]);
    let changes = AssetDifference::new(&unnamed, &named).changes;
    assert_eq!((changes.len(), changes[0].name.as_str()), (1, "face"));
    let name = Some(Value::Text("face".to_owned()));
    assert_eq!(
        changes[0].properties,
        [PropertyChange { property: "name".to_owned(), reference: name, actual: None }]
    );
}
