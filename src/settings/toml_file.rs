//! Shot files and suite files as TOML, with the line and column of every key.

use std::path::Path;

use toml::de::{DeTable, DeValue};

use crate::error::{Error, Provenance, Result, SettingError};

use super::nearest::nearest;
use super::text_file::location;
use super::toml_value::{kind, number};

/// A file of TOML and its text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TomlFile<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

/// A key of a table, and its value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TomlEntry<'t> {
    /// Byte of the key in the text.
    pub(crate) at: usize,
    /// The key.
    pub(crate) key: &'t str,
    /// The value.
    pub(crate) value: &'t DeValue<'t>,
}

impl<'a> TomlFile<'a> {
    /// The table of the whole file.
    ///
    /// # Errors
    /// [`Error::Setting`] with line and column where the text is not TOML.
    pub(crate) fn table(&self) -> Result<DeTable<'a>> {
        Ok(DeTable::parse(self.text).map_err(|error| self.not_toml(&error))?.into_inner())
    }

    /// The origin of the key at byte `at`.
    pub(crate) fn origin(&self, at: usize) -> Provenance {
        let (line, column) = location(self.text, at);
        Provenance::File { path: self.path.to_owned(), line, column }
    }

    /// An error about the key of `entry`, which is not known.
    pub(crate) fn wrong_key(&self, entry: TomlEntry<'_>, why: &str) -> Error {
        let why = format!("\"{}\" {why}", entry.key.escape_debug());
        SettingError { setting: String::new(), origin: self.origin(entry.at), why }.into()
    }

    /// An error about a key that is none of `names`, with the closest one.
    pub(crate) fn unknown_key(&self, entry: TomlEntry<'_>, what: &str, names: &[&str]) -> Error {
        let hint = match nearest(entry.key, names) {
            Some(name) => format!("did you mean \"{name}\"?"),
            None => format!("there are {}", names.join(", ")),
        };
        self.wrong_key(entry, &format!("is not {what}; {hint}"))
    }

    /// An error about the value of `entry`.
    pub(crate) fn wrong_value(&self, entry: TomlEntry<'_>, why: impl Into<String>) -> Error {
        let setting = entry.key.to_owned();
        SettingError { setting, origin: self.origin(entry.at), why: why.into() }.into()
    }

    /// An error about a value of another kind than `expected`.
    pub(crate) fn wrong_kind(&self, entry: TomlEntry<'_>, expected: &str) -> Error {
        self.wrong_value(entry, wrong_kind(entry.value, expected, |_| Ok(())))
    }

    /// A number that `check` accepts; what it returns otherwise says what to write.
    ///
    /// # Errors
    /// [`Error::Setting`] with line and column of another value.
    pub(crate) fn number(
        &self,
        entry: TomlEntry<'_>,
        check: impl Fn(f64) -> std::result::Result<(), &'static str>,
    ) -> Result<f64> {
        let check_value = |value: &DeValue<'_>| number(value).map_or(Ok(()), &check).map_err(str::to_owned);
        let Some(number) = number(entry.value) else {
            return Err(self.wrong_value(entry, wrong_kind(entry.value, "a number", check_value)));
        };
        check(number).map_err(|why| self.wrong_value(entry, why))?;
        Ok(number)
    }

    fn not_toml(&self, error: &toml::de::Error) -> Error {
        let why = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        let at = error.span().map_or(0, |span| span.start);
        let hint = if self.is_escape(at, &why) { BACKSLASHES } else { "" };
        let why = format!("not valid TOML: {why}{hint}");
        SettingError { setting: String::new(), origin: self.origin(at), why }.into()
    }

    /// Whether an error at byte `at` is about a backslash before it in its line.
    fn is_escape(&self, at: usize, why: &str) -> bool {
        let before = self.text.get(..at).unwrap_or_default();
        let line = before.rsplit('\n').next().unwrap_or_default();
        line.contains('\\') && (why.contains("escape") || why.contains("unicode"))
    }
}

/// What to do about a backslash that is no escape, as in Windows paths.
const BACKSLASHES: &str =
    "; a backslash in \"…\" begins an escape: write the text in single quotes, such as 'C:\\robot.glb'";

/// The value that the text would be without its quotes, where `expected` names such a value: not all numbers that Rust parses are TOML.
fn unquoted<'t>(text: &'t str, expected: &str) -> Option<DeValue<'t>> {
    let value = DeValue::parse(text).ok()?.into_inner();
    let is_expected = match value {
        DeValue::Boolean(_) => expected.contains(text),
        DeValue::Integer(_) | DeValue::Float(_) => expected.contains("number"),
        _ => false,
    };
    is_expected.then_some(value)
}

/// `expected a number, found a text; write 4 without quotes`. `check` says what to write where the value is wrong without quotes, too.
pub(super) fn wrong_kind(
    value: &DeValue<'_>,
    expected: &str,
    check: impl Fn(&DeValue<'_>) -> std::result::Result<(), String>,
) -> String {
    let text = value.as_str().map(str::trim);
    let found = kind(value);
    match text.and_then(|text| Some((text, check(&unquoted(text, expected)?)))) {
        None => format!("expected {expected}, found {found}"),
        Some((text, Ok(()))) => format!("expected {expected}, found {found}; write {text} without quotes"),
        Some((_, Err(why))) => format!("expected {expected} without quotes, found {found}; {why}"),
    }
}

/// The entries of a table in the order of the lines.
pub(crate) fn entries<'t>(table: &'t DeTable<'t>) -> Vec<TomlEntry<'t>> {
    let entry =
        |(key, value): (&'t toml::Spanned<std::borrow::Cow<'t, str>>, &'t toml::Spanned<DeValue<'t>>)| {
            TomlEntry { at: key.span().start, key: key.get_ref(), value: value.get_ref() }
        };
    let mut entries: Vec<_> = table.iter().map(entry).collect();
    entries.sort_by_key(|entry| entry.at);
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_that_toml_reads() {
        for text in ["4", "-2", "1.5", "1e3"] {
            assert!(unquoted(text, "a number").is_some(), "{text}");
        }
        for text in [".5", "5.", "05", "many", "true", ""] {
            assert!(unquoted(text, "a number").is_none(), "{text}");
        }
    }
}
