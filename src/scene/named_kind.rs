//! Kinds of things that requests name, how they are found, and the warning about a name that several have.

use super::NameOrIndex;
use crate::error::{Error, Result, Warning};

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
        let choices: Vec<String> = names.enumerate().map(|(i, name)| label(i, name)).collect();
        let choices = if choices.is_empty() {
            "the file has none".to_owned()
        } else {
            format!("choose one of: {}", choices.join(", "))
        };
        Error::setting(kind.setting, format!("there is no {} {label_of_request}; {choices}", kind.noun))
    })
}

pub(super) fn label(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("#{index}"), |name| format!("#{index} \"{name}\""))
}
