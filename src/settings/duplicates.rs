//! Names that several things have.

use std::collections::{BTreeMap, BTreeSet};

/// Adds ` 2`, ` 3` and so on to all but the first of equal names. Case does not count, as it does not on some file systems.
pub(crate) fn number_duplicates<'a>(names: impl Iterator<Item = &'a mut String>) {
    let mut taken = BTreeSet::new();
    let mut last_numbers = BTreeMap::<String, u32>::new();
    for name in names {
        let plain = name.to_lowercase();
        if taken.insert(plain.clone()) {
            continue;
        }
        let number = last_numbers.entry(plain).or_insert(1);
        let own = name.clone();
        while !taken.insert(name.to_lowercase()) {
            *number += 1;
            *name = format!("{own} {number}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_names_get_numbers() {
        let mut names = ["walk", "Walk", "walk 2", "walk", "run", "walk"].map(str::to_owned);
        number_duplicates(names.iter_mut());
        assert_eq!(names, ["walk", "Walk 2", "walk 2 2", "walk 3", "run", "walk 4"]);
    }
}
