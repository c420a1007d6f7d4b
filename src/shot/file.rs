//! Reading a shot file, and the settings of a suite file.

use std::ffi::OsString;
use std::path::Path;

use clap::{Arg, Command};
use toml::de::{DeInteger, DeTable, DeValue};

use crate::error::{Error, Result};
use crate::settings_file::{line_of, not_toml, read_text};

use super::form::Form;
use super::setting::{Origin, Setting, Value, arg_of, rebased, unknown};

/// The table of a shot file that holds limits for comparing its pictures, and no settings.
const LIMITS: &str = "test";
/// The table of a suite file that holds settings for all its shots.
const SHOT: &str = "shot";

/// A file in hand, for saying where in it something is wrong.
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn line(&self, at: usize) -> usize {
        line_of(self.text, at)
    }

    /// What is wrong with the key that begins at the byte `at`.
    fn wrong(&self, at: usize, key: &str, why: &str) -> Error {
        let line = self.line(at);
        Error::invalid(self.path, "", format!("line {line}: \"{}\" {why}", key.escape_debug()))
    }

    fn table(&self) -> Result<DeTable<'_>> {
        let table = DeTable::parse(self.text);
        Ok(table.map_err(|error| not_toml(self.path, self.text, &error))?.into_inner())
    }

    /// The settings of a table, in the order of its lines.
    fn settings(&self, command: &Command, table: DeTable<'_>) -> Result<Vec<Setting>> {
        let mut settings = Vec::new();
        for (key, value) in table {
            settings.push(self.setting(command, (key.span().start, key.get_ref()), value.get_ref())?);
        }
        settings.sort_by_key(|setting| setting.origin.line());
        Ok(settings)
    }

    fn setting(&self, command: &Command, (at, key): (usize, &str), value: &DeValue<'_>) -> Result<Setting> {
        let wrong = |why: &str| self.wrong(at, key, why);
        if value.is_table() && arg_of(command, key).is_none() {
            return Err(wrong("is a table; settings stand in none, each in a line of its own"));
        }
        let arg = arg_of(command, key).ok_or_else(|| wrong(&unknown(command, key)))?;
        let form = Form::of(arg);
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let value = as_value(form, value)
            .map(|value| in_folder(value, arg, folder))
            .ok_or_else(|| wrong(&format!("is {}; write {}", kind_text(value), form.expected())))?;
        let origin = Origin::File { path: self.path.to_owned(), line: self.line(at) };
        Ok(Setting { key: key.to_owned(), value, origin })
    }
}

/// The settings of the shot file `path`, in the order of its lines.
///
/// # Errors
/// [`Error::Missing`] when it cannot be read, [`Error::Refused`] when it is too large, and [`Error::Invalid`] with the
/// line and the setting that is wrong.
pub fn read_shot(path: &Path, command: &Command) -> Result<Vec<Setting>> {
    let text = read_text(path)?;
    let source = Source { path, text: &text };
    let mut table = source.table()?;
    if table.get(LIMITS).is_some_and(|limits| limits.get_ref().is_table()) {
        table.remove(LIMITS);
    }
    source.settings(command, table)
}

/// What the shot file `path` sets as its scene, if anything; nothing else in it is understood.
///
/// # Errors
/// Those of [`read_shot`].
pub fn read_scene(path: &Path, command: &Command) -> Result<Option<Setting>> {
    let text = read_text(path)?;
    let source = Source { path, text: &text };
    let table = source.table()?;
    let scene = table.get_key_value("scene");
    scene
        .map(|(key, value)| source.setting(command, (key.span().start, key.get_ref()), value.get_ref()))
        .transpose()
}

/// The settings that the suite file `path` has for all its shots, in the order of its lines; nothing else in it is understood.
///
/// # Errors
/// Those of [`read_shot`].
pub fn read_suite(path: &Path, command: &Command) -> Result<Vec<Setting>> {
    let text = read_text(path)?;
    let source = Source { path, text: &text };
    let Some((key, shot)) = source.table()?.remove_entry(SHOT) else { return Ok(Vec::new()) };
    let table = match shot.into_inner() {
        DeValue::Table(table) => table,
        other => {
            let why = format!("is {}; write [{SHOT}] and below it settings for all shots", kind_text(&other));
            return Err(source.wrong(key.span().start, key.get_ref(), &why));
        }
    };
    if let Some((key, _)) = table.get_key_value("scene") {
        let why = "differs from shot to shot; name it in a shot file";
        return Err(source.wrong(key.span().start, key.get_ref(), why));
    }
    source.settings(command, table)
}

/// The value as the option takes it; `None` where it has the wrong form.
fn as_value(form: Form, value: &DeValue<'_>) -> Option<Value> {
    match value {
        DeValue::Boolean(value) if form.is_flag() => Some(Value::Flag(*value)),
        DeValue::Array(elements) => {
            let texts: Option<Vec<String>> =
                elements.iter().map(|element| scalar(element.get_ref())).collect();
            match form.separator {
                Some(separator) => Some(Value::Texts(vec![texts?.join(separator).into()])),
                None if form.is_repeated && elements.iter().all(|element| element.get_ref().is_str()) => {
                    Some(Value::Texts(texts?.into_iter().map(OsString::from).collect()))
                }
                None => None,
            }
        }
        DeValue::String(text) if form.takes_text() => Some(Value::Texts(vec![text.as_ref().into()])),
        DeValue::Integer(_) | DeValue::Float(_) if form.takes_number() => {
            Some(Value::Texts(vec![scalar(value)?.into()]))
        }
        _ => None,
    }
}

/// Numbers as they are written, and texts.
fn scalar(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.as_ref().to_owned()),
        DeValue::Integer(number) => Some(decimal(number)),
        DeValue::Float(number) => Some(number.as_str().to_owned()),
        _ => None,
    }
}

/// In decimal digits; what is too long for that is left as it is, and no option takes it.
fn decimal(number: &DeInteger<'_>) -> String {
    i64::from_str_radix(number.as_str(), number.radix())
        .map_or_else(|_| number.as_str().to_owned(), |number| number.to_string())
}

fn in_folder(value: Value, arg: &Arg, folder: &Path) -> Value {
    match value {
        Value::Texts(texts) => {
            Value::Texts(texts.into_iter().map(|text| rebased(arg, folder, text)).collect())
        }
        Value::Flag(_) => value,
    }
}

fn kind_text(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
