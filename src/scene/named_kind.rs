//! Kinds of things that requests name, how they are found, and the warning about a name that several have.

use super::NameOrIndex;
use crate::error::{Error, Result, Warning};

/// Most things that an error lists.
const MOST_LISTED: usize = 20;

/// What a name of a request may refer to.
pub(crate) struct NamedKind {
    /// The singular; an s makes the plural.
    pub(crate) noun: &'static str,
    /// The setting with the name.
    pub(crate) setting: &'static str,
    /// JSON pointer of the array.
    pub(crate) pointer: &'static str,
}

impl NamedKind {
    /// The warning about a name that the things with these indices share; `None` for one thing.
    pub(crate) fn ambiguity(&self, name: &str, mut indices: impl Iterator<Item = usize>) -> Option<Warning> {
        let (first, second) = (indices.next()?, indices.next()?);
        let count = 2 + indices.count();
        let Self { noun, setting, pointer } = self;
        let name = name.escape_debug();
        Some(Warning {
            pointer: format!("{pointer}/{first}"),
            message: format!(
                "{count} {noun}s are called \"{name}\", and the first one is used; `{setting}` '#{second}' selects the next one"
            ),
        })
    }
}

/// The index among `names` that `selected` refers to, with a warning if others have its name.
pub(super) fn find<'a>(
    kind: &NamedKind,
    selected: &NameOrIndex,
    names: impl ExactSizeIterator<Item = Option<&'a str>> + Clone,
    warnings: &mut Vec<Warning>,
) -> Result<usize> {
    let (found, label_of_request) = match selected {
        NameOrIndex::Name(name) => {
            // A number that is no name is an index, because shells take # for a comment.
            let as_index = || name.parse().ok().filter(|&i: &usize| i < names.len());
            let mut named =
                names.clone().enumerate().filter(|(_, other)| *other == Some(name)).map(|(i, _)| i);
            warnings.extend(kind.ambiguity(name, named.clone()));
            let found = named.next().or_else(as_index);
            (found, format!("\"{name}\""))
        }
        NameOrIndex::Index(index) => (Some(*index).filter(|&i| i < names.len()), format!("#{index}")),
    };
    found.ok_or_else(|| {
        let count = names.len();
        let listed: Vec<String> =
            names.enumerate().take(MOST_LISTED).map(|(i, name)| label(i, name)).collect();
        let choices = match count - listed.len() {
            _ if count == 0 => "the file has none".to_owned(),
            0 => format!("choose one of: {}", listed.join(", ")),
            more => {
                let listed = listed.join(", ");
                format!("choose one of: {listed} and {more} more, which rayframe info --json lists")
            }
        };
        Error::setting(kind.setting, format!("there is no {} {label_of_request}; {choices}", kind.noun))
    })
}

pub(super) fn label(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("#{index}"), |name| format!("#{index} \"{name}\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_list_at_most_twenty_names() {
        const CLIP: NamedKind = NamedKind { noun: "clip", setting: "animation", pointer: "/animations" };
        let message = |count: usize| {
            let names: Vec<String> = (0..count).map(|i| format!("c{i}")).collect();
            let names = names.iter().map(|name| Some(name.as_str()));
            let selected = NameOrIndex::Name("walk".to_owned());
            find(&CLIP, &selected, names, &mut Vec::new()).unwrap_err().to_string()
        };
        assert!(message(0).ends_with("there is no clip \"walk\"; the file has none"), "{}", message(0));
        assert!(message(20).ends_with("#18 \"c18\", #19 \"c19\""), "{}", message(20));
        let many = message(3000);
        assert!(many.contains("; choose one of: #0 \"c0\", #1 \"c1\""), "{many}");
        assert!(many.ends_with("#19 \"c19\" and 2980 more, which rayframe info --json lists"), "{many}");
    }
}
