//! Writes settings as a shot file or as JSON.

use std::ffi::OsString;
use std::path::Path;

use serde_json::{Map, Value, json};
use toml::de::DeValue;

use super::definitions::{DEFINITIONS, Definition, Settings};
use super::setting_type::{Single, ValueForm};
use crate::terminal::misleads;

impl Settings {
    /// The same settings with defaults given where they have a meaning beside them, and files named from `folder`.
    #[must_use]
    pub fn with_defaults(&self, folder: &Path) -> Self {
        let mut all = Self::default();
        for definition in DEFINITIONS {
            let lacks_another = definition.requires.is_some_and(|needed| self.origin_of(needed).is_none());
            let has_meaning = !lacks_another && !self.excludes(definition);
            let default = || (definition.access.write_default)().filter(|_| has_meaning);
            let Some(texts) = definition.texts(self).or_else(default) else { continue };
            let origin = definition.origin(self).cloned().unwrap_or(crate::error::Provenance::Default);
            if definition.is_flag() && texts.iter().all(|text| text == "false") {
                continue;
            }
            for text in texts {
                let text = (definition.access.rebase)(text, folder);
                let parsed = definition.parse(&mut all, &text, &origin);
                debug_assert!(parsed.is_ok(), "{} is no value of {}", text.display(), definition.name);
            }
        }
        all
    }

    /// Lines of a shot file, with headings as comments.
    pub fn to_toml(&self) -> String {
        let mut lines = Vec::new();
        let mut heading = None;
        for definition in DEFINITIONS {
            let Some(texts) = definition.texts(self) else { continue };
            if heading != definition.group.heading() {
                heading = definition.group.heading();
                lines.extend(heading.map(|heading| format!("\n# {heading}")));
            }
            lines.push(line(definition, &texts));
        }
        lines.join("\n")
    }

    /// A JSON object. A setting that takes numbers or texts is a text, so that it has one type.
    pub fn to_json(&self) -> Map<String, Value> {
        let given = DEFINITIONS.iter().filter_map(|definition| Some((definition, definition.texts(self)?)));
        given
            .map(|(definition, texts)| (definition.name.to_owned(), json_value(definition.form, &texts)))
            .collect()
    }
}

fn line(definition: &Definition, texts: &[OsString]) -> String {
    let key = definition.name;
    let form = definition.form;
    let Some(texts) = texts.iter().map(|text| text.to_str()).collect::<Option<Vec<_>>>() else {
        return format!("# {key} cannot be written here, for it is not Unicode");
    };
    if form.is_repeated {
        let texts: Vec<_> = texts.into_iter().map(quoted).collect();
        return format!("{key} = [{}]", texts.join(", "));
    }
    let text = texts.last().copied().unwrap_or_default();
    if form == ValueForm::FLAG {
        return format!("{key} = {text}");
    }
    format!("{key} = {}", number(form, text).unwrap_or_else(|| quoted(text)))
}

fn json_value(form: ValueForm, texts: &[OsString]) -> Value {
    let mut texts = texts.iter().map(|text| text.to_string_lossy());
    if form.is_repeated {
        return json!(texts.collect::<Vec<_>>());
    }
    let text = texts.next_back().unwrap_or_default();
    if form == ValueForm::FLAG {
        return json!(text == "true");
    }
    let number = number(form, &text).filter(|_| form.single == Single::Number);
    number.and_then(|number| serde_json::from_str(&number).ok()).unwrap_or_else(|| json!(text))
}

/// The text as a number of TOML and JSON, where the form accepts numbers.
fn number(form: ValueForm, text: &str) -> Option<String> {
    let value = text.parse::<f64>().ok().filter(|value| form.takes_number() && value.is_finite())?;
    let is_number = |text: &str| {
        DeValue::parse(text).is_ok_and(|value| value.get_ref().is_integer() || value.get_ref().is_float())
            && serde_json::from_str::<serde_json::Number>(text).is_ok()
    };
    let same = |number: &String| number.parse::<f64>().is_ok_and(|same| same == value);
    [text.to_owned(), format!("{value}"), format!("{value:?}")]
        .into_iter()
        .find(|number| is_number(number) && same(number))
}

/// An escape of TOML.
fn escaped(c: char) -> String {
    match u32::from(c) {
        code @ ..=0xffff => format!("\\u{code:04X}"),
        code => format!("\\U{code:08X}"),
    }
}

/// A basic string of TOML, in which no character misleads on a terminal.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if misleads(c) => quoted.push_str(&escaped(c)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_texts_are_read_as_written() {
        for text in [
            "",
            "a\"b\\c",
            "\u{1}\u{7f}\u{85}\n\t",
            "'''",
            "#0 → é",
            "می\u{200c}شود\u{ad}\u{202e}\u{feff}\u{e0001}",
        ] {
            let line = quoted(text);
            let read = DeValue::parse(&line).unwrap();
            assert_eq!(read.get_ref().as_str(), Some(text), "{line}");
            assert!(!line.contains(misleads), "{line} is printed otherwise");
        }
    }
}
