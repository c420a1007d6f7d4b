//! One setting: its name, its value as the option takes it, and where it comes from.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Arg, Command};

use crate::error::{Error, Result};
use crate::sequence::OutputPattern;

use super::form::{Form, PathForm};
use super::nearest::nearest;
use super::options;

/// Options that make no sense among the settings of a shot: those that name it, and the one that prints it.
const NOT_SETTINGS: [&str; 3] = ["config", "set", "dry_run"];

/// A setting that was given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Its name.
    pub key: String,
    /// Its value.
    pub value: Value,
    /// Who says so.
    pub origin: Origin,
}

/// What an option takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// Whether it is there.
    Flag(bool),
    /// What follows it, each time it is given.
    Texts(Vec<OsString>),
}

/// Where a setting comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An option.
    Typed,
    /// `-D` with this text.
    Defined(String),
    /// A line of a shot file, the first of which is 1.
    File {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
    },
}

impl Origin {
    /// The line in the shot file, or 0.
    pub fn line(&self) -> usize {
        match self {
            Self::File { line, .. } => *line,
            Self::Typed | Self::Defined(_) => 0,
        }
    }
}

impl Value {
    /// Adds the texts of `other`.
    pub fn extend(&mut self, other: Self) {
        if let (Self::Texts(texts), Self::Texts(more)) = (self, other) {
            texts.extend(more);
        }
    }

    /// Whether the option is there at all.
    fn is_given(&self) -> bool {
        match self {
            Self::Flag(is_given) => *is_given,
            Self::Texts(texts) => !texts.is_empty(),
        }
    }
}

impl Setting {
    /// What is wrong with the setting, said to whoever gave it.
    pub fn error(&self, why: &str) -> Error {
        match &self.origin {
            Origin::Typed => Error::usage(why),
            Origin::Defined(text) => Error::usage(format!("-D {text}: {why}")),
            Origin::File { path, line } => {
                Error::invalid(path, "", format!("line {line}: {}: {why}", self.key))
            }
        }
    }
}

/// Whether the option can be set by name.
pub fn is_setting(arg: &Arg) -> bool {
    !NOT_SETTINGS.contains(&arg.get_id().as_str())
}

/// The option of a setting.
pub fn arg_of<'a>(command: &'a Command, key: &str) -> Option<&'a Arg> {
    command.get_arguments().find(|arg| is_setting(arg) && arg.get_id() == key)
}

/// Why nothing can be set by the name `key`.
pub fn unknown(command: &Command, key: &str) -> String {
    if NOT_SETTINGS.contains(&key) {
        return "is no setting of a shot; it belongs on the command line".to_owned();
    }
    let args: Vec<_> = command.get_arguments().filter(|arg| is_setting(arg)).collect();
    let long = key.replace('_', "-");
    let is_called = |arg: &&&Arg| {
        arg.get_id() == key.replace('-', "_").as_str()
            || arg.get_long_and_visible_aliases().is_some_and(|names| names.contains(&long.as_str()))
    };
    let ids: Vec<&str> = args.iter().map(|arg| arg.get_id().as_str()).collect();
    let called = args.iter().find(is_called).map(|arg| arg.get_id().as_str());
    let meant = match called.or_else(|| nearest(key, &ids)) {
        Some(id) => format!("did you mean \"{id}\"?"),
        None => "settings are called as the long options of rayframe render, with _ in place of -".to_owned(),
    };
    format!("is no setting; {meant}")
}

/// `KEY=VALUE`, as typed.
pub fn defined(command: &Command, text: &str) -> Result<Setting> {
    let usage = |why: &str| Error::usage(format!("-D {text}: {why}"));
    let (key, value) = text.split_once('=').ok_or_else(|| usage("write KEY=VALUE, such as samples=16"))?;
    let key = key.trim().replace('-', "_");
    let arg = arg_of(command, &key)
        .ok_or_else(|| usage(&format!("\"{}\" {}", key.escape_debug(), unknown(command, &key))))?;
    let value = match (Form::of(arg).is_flag(), value) {
        (false, _) => Value::Texts(vec![value.into()]),
        (true, "true") => Value::Flag(true),
        (true, "false") => Value::Flag(false),
        (true, _) => return Err(usage("write true or false")),
    };
    Ok(Setting { key, value, origin: Origin::Defined(text.to_owned()) })
}

/// Whether `higher` leaves no room for `lower`: it sets the same, or what cannot be set beside it.
pub fn excludes(command: &Command, higher: &Setting, lower: &Setting) -> bool {
    if higher.key == lower.key {
        return true;
    }
    let (Some(a), Some(b)) = (arg_of(command, &higher.key), arg_of(command, &lower.key)) else {
        return false;
    };
    let conflicts =
        |a: &Arg, b: &Arg| command.get_arg_conflicts_with(a).iter().any(|other| other.get_id() == b.get_id());
    higher.value.is_given() && (conflicts(a, b) || conflicts(b, a))
}

/// The settings as they would be typed, with a scene in any case.
pub fn argument_list<'a>(
    command: &Command,
    settings: impl IntoIterator<Item = &'a Setting>,
) -> Vec<OsString> {
    let mut arguments = Vec::new();
    let mut scene = OsString::from("scene.glb");
    for setting in settings {
        let long = command
            .get_arguments()
            .find(|arg| arg.get_id() == setting.key.as_str())
            .and_then(Arg::get_long)
            .unwrap_or_default();
        match &setting.value {
            Value::Texts(texts) if setting.key == "scene" => {
                scene = texts.last().cloned().unwrap_or_default();
            }
            Value::Flag(true) => arguments.push(format!("--{long}").into()),
            Value::Flag(false) => {}
            Value::Texts(texts) => arguments.extend(texts.iter().map(|text| {
                let mut argument = OsString::from(format!("--{long}="));
                argument.push(text);
                argument
            })),
        }
    }
    arguments.extend(["--".into(), scene]);
    arguments
}

/// The value with files that are named from `folder`.
pub fn rebased(arg: &Arg, folder: &Path, text: OsString) -> OsString {
    let joined = |text: OsString| folder.join(text).into_os_string();
    if text.is_empty() {
        return text;
    }
    match Form::of(arg).path {
        PathForm::None => text,
        PathForm::File => joined(text),
        PathForm::Pattern if Path::new(&text).is_absolute() => text,
        PathForm::Pattern => Path::new(&OutputPattern::escaped(folder)).join(text).into_os_string(),
        PathForm::Picture => {
            let is_picture = match options::background(&text) {
                Ok(source) => matches!(source, Some(options::EnvironmentSource::File(..))),
                // A name that tells nothing may still be that of a file.
                Err(_) => folder.join(&text).is_file(),
            };
            if is_picture { joined(text) } else { text }
        }
    }
}
