//! Unique names of things whose names in a file may be equal.

use std::collections::{BTreeMap, BTreeSet};

/// Makes names unique: the first of several equal names stays, the others become `name (2)` and so on, skipping taken names. Empty
/// names stay empty.
pub(crate) fn unique_names(names: &[String]) -> Vec<String> {
    let originals: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let mut counts = BTreeMap::<&str, u32>::new();
    let mut unique = Vec::with_capacity(names.len());
    for name in names {
        let count = counts.entry(name).or_insert(0);
        *count += 1;
        let mut chosen = name.clone();
        while *count > 1 && !name.is_empty() {
            chosen = format!("{name} ({count})");
            if !originals.contains(chosen.as_str()) {
                break;
            }
            *count += 1;
        }
        unique.push(chosen);
    }
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_names_get_unused_numbers() {
        let unique =
            |names: &[&str]| unique_names(&names.iter().map(|&name| name.into()).collect::<Vec<_>>());
        assert_eq!(unique(&["a", "b", "a", "a"]), ["a", "b", "a (2)", "a (3)"]);
        assert_eq!(unique(&["a", "a", "a (2)", "a (2)"]), ["a", "a (3)", "a (2)", "a (2) (2)"]);
        assert_eq!(unique(&["", "a", ""]), ["", "a", ""]);
    }
}
