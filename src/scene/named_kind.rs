//! Kinds of things that requests name, and the warning about a name that several have.

use crate::error::Warning;

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
