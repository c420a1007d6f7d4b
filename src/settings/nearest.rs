//! The nearest of several words by edit distance.

/// The name that takes the fewest changes to become, at most a third of its letters. Words are joined by `_` however they were typed.
pub(crate) fn nearest<'a>(word: &str, names: &[&'a str]) -> Option<&'a str> {
    let plain = word.replace(['-', '.', ' '], "_");
    let near = names.iter().map(|&name| (distance(&plain, name), name));
    near.filter(|&(changes, name)| changes <= name.len().div_ceil(3))
        .min_by_key(|&(changes, _)| changes)
        .map(|(_, name)| name)
}

/// Letters to change, add or take away, whatever their case (Levenshtein), of the first 64.
pub(crate) fn distance(a: &str, b: &str) -> usize {
    let lower = |text: &str| text.chars().flat_map(char::to_lowercase).take(64).collect::<Vec<_>>();
    let (a, b) = (lower(a), lower(b));
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_changes() {
        assert_eq!(distance("kitten", "Sitting"), 3);
        assert_eq!((distance("", "ab"), distance("ab", "")), (2, 2));
        assert_eq!(nearest("Object-Id", &["node_id", "object_id"]), Some("object_id"));
        assert_eq!(nearest("xyz", &["node_id"]), None);
    }
}
