//! The definition of a setting: name, help, default, exclusions, and access to its field.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use crate::error::Provenance;

use super::setting_type::{NamedChoice, SettingType, ValueForm};

/// A value and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Assigned<T> {
    /// The value.
    pub value: T,
    /// Where it comes from.
    pub origin: Provenance,
}

impl<T> From<T> for Assigned<T> {
    fn from(value: T) -> Self {
        Self { value, origin: Provenance::Library }
    }
}

/// Headings of the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Group {
    /// The scene file, without a heading.
    Input,
    /// Output files.
    Output,
    /// Frames and time.
    Frames,
    /// Image size, sampling and shading.
    Image,
    /// Position and lens of the camera.
    Camera,
    /// What is rendered, and what lights it.
    Scene,
    /// Resources, acceleration and messages.
    Run,
}

impl Group {
    /// The heading.
    pub fn heading(self) -> Option<&'static str> {
        match self {
            Self::Input => None,
            Self::Output => Some("Output"),
            Self::Frames => Some("Frames"),
            Self::Image => Some("Image"),
            Self::Camera => Some("Camera"),
            Self::Scene => Some("Scene"),
            Self::Run => Some("Run"),
        }
    }
}

/// Access to the field of one setting.
#[derive(Clone, Copy, Debug)]
pub(super) struct Access<S: 'static> {
    pub(super) parse: fn(&mut S, &OsStr, &Provenance) -> Result<(), String>,
    pub(super) origin: fn(&S) -> Option<&Provenance>,
    pub(super) write: fn(&S) -> Option<Vec<OsString>>,
    pub(super) check: fn(&S) -> Result<(), String>,
    pub(super) write_default: fn() -> Option<Vec<OsString>>,
    pub(super) copy: fn(to: &mut S, from: &S),
    pub(super) clear: fn(&mut S),
    pub(super) rebase: fn(OsString, &Path) -> OsString,
    pub(super) choices: fn() -> Vec<NamedChoice>,
}

/// One setting of the struct `S`.
#[derive(Clone, Copy, Debug)]
pub struct DefinitionOf<S: 'static> {
    /// Its key in shot files.
    pub name: &'static str,
    /// Its heading.
    pub group: Group,
    /// Help, line by line; the first line stands alone.
    pub help: &'static [&'static str],
    /// Placeholder of its value.
    pub value_name: &'static str,
    /// The default in words, where it depends on the scene or the machine.
    pub default_help: &'static str,
    /// How TOML writes it.
    pub form: ValueForm,
    /// Whether the short help shows it.
    pub is_common: bool,
    /// Value of the option without one. Then a value follows `=` alone, so that a file after the option is not taken for it.
    pub value_alone: Option<&'static str>,
    /// Letter of the option.
    pub short: Option<char>,
    /// Name of the option, where it is not the key with `-` for `_`.
    pub option: Option<&'static str>,
    /// Other keys and options for the same setting, which the help shows.
    pub aliases: &'static [&'static str],
    /// Earlier spellings.
    pub hidden_aliases: &'static [&'static str],
    /// Settings that cannot be combined with it.
    pub excludes: &'static [&'static str],
    /// The setting without which it has no meaning.
    pub requires: Option<&'static str>,
    /// Whether it decides about files or the terminal only, and not about what a suite compares.
    pub is_for_runs: bool,
    pub(super) access: Access<S>,
}

impl<S> DefinitionOf<S> {
    pub(super) const fn new(name: &'static str, group: Group, form: ValueForm, access: Access<S>) -> Self {
        Self {
            name,
            group,
            help: &[],
            value_name: "",
            default_help: "",
            form,
            is_common: false,
            value_alone: None,
            short: None,
            option: None,
            aliases: &[],
            hidden_aliases: &[],
            excludes: &[],
            requires: None,
            is_for_runs: false,
            access,
        }
    }

    /// Name of its option, without dashes.
    pub fn option_name(&self) -> String {
        self.option.map_or_else(|| self.name.replace('_', "-"), str::to_owned)
    }

    /// Whether it is `true` or `false`.
    pub fn is_flag(&self) -> bool {
        self.form == ValueForm::FLAG
    }

    /// The accepted names, where it is an enum.
    pub fn choices(&self) -> Vec<NamedChoice> {
        (self.access.choices)()
    }

    /// The default as text, or in words.
    pub fn default_text(&self) -> Option<String> {
        if !self.default_help.is_empty() {
            return Some(self.default_help.to_owned());
        }
        let texts = (self.access.write_default)()?;
        Some(texts.first()?.to_string_lossy().into_owned()).filter(|text| !self.is_flag() && !text.is_empty())
    }

    /// Where `settings` has its value from.
    pub fn origin<'a>(&self, settings: &'a S) -> Option<&'a Provenance> {
        (self.access.origin)(settings)
    }

    /// The texts of its value in `settings`.
    pub fn texts(&self, settings: &S) -> Option<Vec<OsString>> {
        (self.access.write)(settings)
    }

    /// Sets it in `settings` from text. On one level, values of repeated settings add up.
    ///
    /// # Errors
    /// Why the text is no value.
    pub fn parse(&self, settings: &mut S, text: &OsStr, origin: &Provenance) -> Result<(), String> {
        (self.access.parse)(settings, text, origin)
    }

    /// Whether it and `other` cannot be combined.
    pub fn is_excluded_by(&self, other: &Self) -> bool {
        self.excludes.contains(&other.name) || other.excludes.contains(&self.name)
    }
}

/// Sets a field from text.
pub(super) fn set<T: SettingType>(
    field: &mut Option<Assigned<T::Value>>,
    text: &OsStr,
    origin: &Provenance,
) -> Result<(), String> {
    let value = T::parse(text)?;
    match field {
        Some(given) => {
            T::add(&mut given.value, value);
            given.origin = origin.clone();
        }
        None => *field = Some(Assigned { value, origin: origin.clone() }),
    }
    Ok(())
}
