//! The difference of two assets as rows of text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::difference::{AssetDifference, Change, ChangeKind, PropertyChange};
use super::group_kind::GroupKind;
use super::value::Value;
use crate::regression::{ChangeGroup, ChangeRow};

/// Elements of a list that are named; the others are counted.
const MOST_ELEMENTS: usize = 6;

impl AssetDifference {
    /// The changes in groups, without empty ones.
    pub fn table(&self) -> Vec<ChangeGroup> {
        let mut groups = Vec::<ChangeGroup>::new();
        for change in &self.changes {
            let title = change.group.name();
            if groups.last().is_none_or(|group| group.title != title) {
                groups.push(ChangeGroup { title, rows: Vec::new() });
            }
            if let Some(group) = groups.last_mut() {
                group.rows.extend(rows(change));
            }
        }
        groups
    }
}

fn rows(change: &Change) -> Vec<ChangeRow> {
    let whole =
        |mark, values| vec![ChangeRow { mark, name: change.name.clone(), property: String::new(), values }];
    match change.kind {
        ChangeKind::Removed => whole('-', summary(change)),
        ChangeKind::Added => whole('+', summary(change)),
        ChangeKind::Changed => {
            let row = |(index, property): (usize, &PropertyChange)| ChangeRow {
                mark: '~',
                name: if index == 0 { change.name.clone() } else { String::new() },
                property: property.property.clone(),
                values: property.text(),
            };
            if change.properties.is_empty() {
                return whole('~', "nothing uses it any more".to_owned());
            }
            change.properties.iter().enumerate().map(row).collect()
        }
    }
}

/// What an item is that only one side has: `mesh Wheel`, `2048x2048 PNG`.
fn summary(change: &Change) -> String {
    let (named, shown): (bool, &[&str]) = match change.group {
        GroupKind::Nodes => (true, &["mesh", "camera", "light"]),
        GroupKind::Meshes => (true, &["triangles"]),
        GroupKind::Textures => (false, &["size", "format"]),
        GroupKind::Clips => (false, &["duration"]),
        GroupKind::Cameras => (false, &["projection"]),
        GroupKind::Lights => (false, &["kind"]),
        _ => (false, &[]),
    };
    let parts = change.properties.iter().filter(|property| shown.contains(&property.property.as_str()));
    let parts = parts.filter_map(|property| {
        let value = property.reference.as_ref().or(property.actual.as_ref())?;
        Some(if named { format!("{} {value}", property.property) } else { value.to_string() })
    });
    parts.collect::<Vec<_>>().join(if named { ", " } else { " " })
}

impl PropertyChange {
    /// The values before and after: `0.5 → 0.8`, `4.2 MB → 1.3 MB (-69 %)`. Of lists only what was removed and what was added.
    pub fn text(&self) -> String {
        let text =
            |value: &Option<Value>| value.as_ref().map_or_else(|| "none".to_owned(), ToString::to_string);
        let change = format!("{} → {}", text(&self.reference), text(&self.actual));
        match (&self.reference, &self.actual) {
            (Some(Value::List(before)), Some(Value::List(after))) => list_text(before, after),
            (Some(Value::Bytes(before)), Some(Value::Bytes(after)))
            | (Some(Value::Count(before)), Some(Value::Count(after)))
                if *before >= 100 =>
            {
                let percent = (*after as f64 / *before as f64 - 1.0) * 100.0;
                let decimals = usize::from(percent.abs() < 10.0);
                format!("{change} ({percent:+.decimals$} %)")
            }
            _ => change,
        }
    }
}

/// `- TANGENT float32, + COLOR_0 uint8`.
fn list_text(before: &[String], after: &[String]) -> String {
    let removed = without(before, after).into_iter().map(|name| format!("- {name}"));
    let added = without(after, before).into_iter().map(|name| format!("+ {name}"));
    let parts: Vec<_> = removed.chain(added).collect();
    let mut text = parts[..parts.len().min(MOST_ELEMENTS)].join(", ");
    if parts.len() > MOST_ELEMENTS {
        let _ = write!(text, ", and {} more", parts.len() - MOST_ELEMENTS);
    }
    text
}

/// The elements of `list` that `other` does not have as often.
fn without<'a>(list: &'a [String], other: &[String]) -> Vec<&'a String> {
    let mut counts = BTreeMap::<_, usize>::new();
    for name in other {
        *counts.entry(name).or_default() += 1;
    }
    let is_left = |name: &&String| match counts.get_mut(*name) {
        Some(count) if *count > 0 => {
            *count -= 1;
            false
        }
        _ => true,
    };
    list.iter().filter(is_left).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(reference: Value, actual: Value) -> String {
        PropertyChange { property: String::new(), reference: Some(reference), actual: Some(actual) }.text()
    }

    #[test]
    fn values_are_told_as_before_and_after() {
        assert_eq!(text(Value::Bytes(4_200_000), Value::Bytes(1_300_000)), "4.2 MB → 1.3 MB (-69 %)");
        assert_eq!(text(Value::Count(1000), Value::Count(1004)), "1 000 → 1 004 (+0.4 %)");
        assert_eq!(text(Value::Count(3), Value::Count(4)), "3 → 4");
        let gone =
            PropertyChange { property: String::new(), reference: Some(Value::Flag(true)), actual: None };
        assert_eq!(gone.text(), "yes → none");
    }

    #[test]
    fn lists_tell_what_is_gone_and_what_is_new() {
        let list = |names: &[&str]| Value::List(names.iter().map(|&name| name.to_owned()).collect());
        assert_eq!(text(list(&["a", "b", "b"]), list(&["b", "c"])), "- a, - b, + c");
        assert_eq!(
            text(list(&[]), list(&["1", "2", "3", "4", "5", "6", "7", "8"])),
            "+ 1, + 2, + 3, + 4, + 5, + 6, and 2 more"
        );
    }
}
