//! Unique names of things whose names in a file may be equal.

use std::collections::{BTreeMap, BTreeSet};

/// Makes names unique: the first of several equal names stays, the others become `name (2)` and so on, skipping names of the list.
/// Empty names stay empty.
pub(crate) fn make_unique<'n>(names: impl IntoIterator<Item = &'n mut String>) {
    number_equal(names, str::to_owned);
}

/// The same for names that become those of files. Case does not count, as it does not on some file systems.
pub(crate) fn make_unique_for_files<'n>(names: impl IntoIterator<Item = &'n mut String>) {
    number_equal(names, str::to_lowercase);
}

/// Numbers names that are equal by `key`.
fn number_equal<'n>(names: impl IntoIterator<Item = &'n mut String>, key: fn(&str) -> String) {
    let names: Vec<_> = names.into_iter().filter(|name| !name.is_empty()).collect();
    let keys: Vec<_> = names.iter().map(|name| key(name)).collect();
    let originals: BTreeSet<_> = keys.iter().collect();
    let mut counts = BTreeMap::<_, u32>::new();
    for (name, own_key) in names.into_iter().zip(&keys) {
        let count = counts.entry(own_key).or_insert(0);
        *count += 1;
        while *count > 1 {
            let numbered = format!("{name} ({count})");
            if !originals.contains(&key(&numbered)) {
                *name = numbered;
                break;
            }
            *count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_names_get_unused_numbers() {
        let unique = |names: &[&str]| {
            let mut names: Vec<_> = names.iter().map(|&name| name.to_owned()).collect();
            make_unique(&mut names);
            names
        };
        assert_eq!(unique(&["a", "b", "a", "a"]), ["a", "b", "a (2)", "a (3)"]);
        assert_eq!(unique(&["a", "a", "a (2)", "a (2)"]), ["a", "a (3)", "a (2)", "a (2) (2)"]);
        assert_eq!(unique(&["", "a", ""]), ["", "a", ""]);
        assert_eq!(unique(&["a", "A"]), ["a", "A"]);
    }

    #[test]
    fn case_does_not_count_for_files() {
        let mut names = ["walk", "Walk", "WALK (2)", "walk", "run", "Walk (2)"].map(str::to_owned);
        make_unique_for_files(&mut names);
        assert_eq!(names, ["walk", "Walk (3)", "WALK (2)", "walk (4)", "run", "Walk (2) (2)"]);
    }
}
