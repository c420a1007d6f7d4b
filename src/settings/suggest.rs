//! Suggests the closest existing name for a misspelled one.

use std::collections::BTreeSet;

use super::nearest::distance;

/// Names that are listed.
const MOST_LISTED: usize = 20;

/// `did you mean "floor"? There are "floor", "roof" and 12 more`, the nearest first.
pub(crate) fn choices<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> String {
    let names: BTreeSet<&str> = names.collect();
    let mut names: Vec<_> = names.into_iter().map(|name| (distance(asked, name), name)).collect();
    names.sort_unstable();
    let Some(&(nearest, name)) = names.first() else {
        return "the file names none".to_owned();
    };
    // As it is typed: apostrophes need no escape between double quotes.
    let quoted = |name: &str| format!("\"{}\"", name.escape_debug().to_string().replace("\\'", "'"));
    // Half of the letters may be wrong, or fewer.
    let is_near = nearest * 2 <= asked.chars().count().max(1);
    let suggestion = if is_near { format!("did you mean {}? ", quoted(name)) } else { String::new() };
    let listed: Vec<_> = names.iter().take(MOST_LISTED).map(|(_, name)| quoted(name)).collect();
    let more = match names.len() - listed.len() {
        0 => String::new(),
        more => format!(" and {more} more, which rayframe info --json lists"),
    };
    format!("{suggestion}there are {}{more}", listed.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first() {
        let names = ["roof", "Floor", "lamp"];
        assert_eq!(
            choices("flor", names.into_iter()),
            "did you mean \"Floor\"? there are \"Floor\", \"roof\", \"lamp\""
        );
        assert!(choices("xyzxyz", names.into_iter()).starts_with("there are "));
        assert_eq!(choices("a", [].into_iter()), "the file names none");
        assert_eq!(choices("\n", ["l'été\n"].into_iter()), "there are \"l'été\\n\"");
        let many: Vec<String> = (10..40).map(|i| format!("n{i}")).collect();
        assert!(choices("n", many.iter().map(String::as_str)).contains("and 10 more"));
    }

    #[test]
    fn letters_that_differ_are_counted() {
        assert_eq!((distance("kitten", "Sitting"), distance("", "abc"), distance("a", "a")), (3, 3, 0));
    }
}
