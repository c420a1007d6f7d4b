//! Pairs of items of two files that stand for the same thing.

use std::collections::{BTreeMap, BTreeSet};

use super::item::Item;

/// Indices of items of the actual and of the reference group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Matching {
    /// Actual and reference index, in the order of the reference.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Indices of the actual group without a counterpart.
    pub(super) added: Vec<usize>,
    /// Indices of the reference group without a counterpart.
    pub(super) removed: Vec<usize>,
}

impl Matching {
    /// Pairs items by name, then by alias. Unnamed ones that are left have nothing but their order, in which they are paired where they
    /// are equally many. Where one side has no names at all, as programs drop them, so are all that are left.
    pub(super) fn new(actual: &[Item], reference: &[Item]) -> Self {
        let mut matching = Self {
            pairs: Vec::new(),
            added: (0..actual.len()).collect(),
            removed: (0..reference.len()).collect(),
        };
        matching.pair_by(actual, reference, |item| item.is_named.then_some(item.name.as_str()));
        matching.pair_by(actual, reference, |item| item.alias.as_deref());
        let unnamed = |items: &[Item], indices: &[usize]| -> Vec<usize> {
            indices.iter().copied().filter(|&index| !items[index].is_named).collect()
        };
        let (ours, theirs) = (unnamed(actual, &matching.added), unnamed(reference, &matching.removed));
        let one_side_has_no_names =
            [actual, reference].iter().any(|side| side.iter().all(|item| !item.is_named));
        if ours.len() == theirs.len() {
            matching.pair_in_order(&ours, &theirs);
        } else if one_side_has_no_names && matching.added.len() == matching.removed.len() {
            matching.pair_in_order(&matching.added.clone(), &matching.removed.clone());
        }
        matching.pairs.sort_by_key(|&(_, reference)| reference);
        matching
    }

    /// Whether an actual and a reference index are a pair.
    pub(super) fn pairs(&self, actual: usize, reference: usize) -> bool {
        let found = self.pairs.binary_search_by_key(&reference, |pair| pair.1);
        found.is_ok_and(|found| self.pairs[found].0 == actual)
    }

    fn pair_in_order(&mut self, actual: &[usize], reference: &[usize]) {
        self.pairs.extend(actual.iter().copied().zip(reference.iter().copied()));
        let [actual, reference]: [BTreeSet<_>; 2] = [actual, reference].map(|side| side.iter().collect());
        self.added.retain(|index| !actual.contains(index));
        self.removed.retain(|index| !reference.contains(index));
    }

    /// Pairs what is left and has equal keys; of several items with one key the first with the first.
    fn pair_by(
        &mut self,
        actual: &[Item],
        reference: &[Item],
        key: impl for<'i> Fn(&'i Item) -> Option<&'i str>,
    ) {
        let mut by_key = BTreeMap::<&str, Vec<usize>>::new();
        for &index in self.added.iter().rev() {
            if let Some(key) = key(&actual[index]) {
                by_key.entry(key).or_default().push(index);
            }
        }
        let (pairs, mut paired) = (&mut self.pairs, BTreeSet::new());
        self.removed.retain(|&index| {
            let found = key(&reference[index]).and_then(|key| by_key.get_mut(key)?.pop());
            pairs.extend(found.map(|found| (found, index)));
            paired.extend(found);
            found.is_none()
        });
        self.added.retain(|index| !paired.contains(index));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn items(names: &[Option<&str>]) -> Vec<Item> {
        names.iter().enumerate().map(|(index, name)| Item::new(*name, index)).collect()
    }

    #[test]
    fn names_pair_items_in_any_order() {
        let actual = items(&[Some("b"), Some("new"), Some("a"), Some("a")]);
        let reference = items(&[Some("a"), Some("b"), Some("a"), Some("old")]);
        let matching = Matching::new(&actual, &reference);
        assert_eq!(matching.pairs, [(2, 0), (0, 1), (3, 2)]);
        assert_eq!((matching.added, matching.removed), (vec![1], vec![3]));
    }

    #[test]
    fn dropped_names_leave_the_order() {
        let reference = items(&[Some("a"), Some("b")]);
        let stripped = Matching::new(&items(&[None, None]), &reference);
        assert_eq!(stripped.pairs, [(0, 0), (1, 1)]);
        // With one item less there is no telling which.
        let fewer = Matching::new(&items(&[None]), &reference);
        assert_eq!((fewer.pairs.len(), fewer.added.len(), fewer.removed.len()), (0, 1, 2));
        // An item that alone has lost its name is not the one that it was.
        let one = Matching::new(&items(&[Some("a"), None]), &reference);
        assert_eq!((one.pairs, one.added, one.removed), (vec![(0, 0)], vec![1], vec![1]));
        // A renamed item is another one.
        let renamed = Matching::new(&items(&[Some("a"), Some("c")]), &reference);
        assert_eq!((renamed.pairs.len(), renamed.added, renamed.removed), (1, vec![1], vec![1]));
    }

    #[test]
    fn aliases_pair_what_names_do_not() {
        let (mut actual, mut reference) = (items(&[Some("x"), None]), items(&[None, Some("y")]));
        (actual[0].alias, reference[0].alias) = (Some("holder".to_owned()), Some("holder".to_owned()));
        assert_eq!(Matching::new(&actual, &reference).pairs, [(0, 0)]);
    }
}
