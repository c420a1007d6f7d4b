//! Keys of settings: finding a definition, and suggestions for unknown keys.

use std::ffi::OsStr;

use crate::error::{Provenance, SettingError};

use super::definitions::{DEFINITIONS, Definition, Settings};
use super::nearest::nearest;
use super::synonyms::synonym;

/// Options that are no settings.
const COMMAND_LINE_ONLY: [&str; 3] = ["config", "set", "dry_run"];

/// Whether a key of a shot file is a setting.
pub(crate) fn is_setting(key: &str) -> bool {
    Definition::of(key).is_some()
}

/// The definition of a key.
///
/// # Errors
/// A suggestion for an unknown key.
pub(super) fn find(key: &str) -> Result<&'static Definition, String> {
    if let Some(definition) = Definition::of(key) {
        return Ok(definition);
    }
    if COMMAND_LINE_ONLY.contains(&key) {
        return Err("is no setting of a shot; it belongs on the command line".to_owned());
    }
    if let Some(hint) = synonym(key) {
        return Err(format!("is no setting; {hint}"));
    }
    let plain = key.replace('-', "_");
    let long = key.replace('_', "-");
    let called = DEFINITIONS.iter().find(|definition| {
        definition.name == plain || definition.aliases.contains(&key) || definition.option == Some(&long)
    });
    let names: Vec<&str> = DEFINITIONS.iter().map(|definition| definition.name).collect();
    let suggestion = called.map(|definition| definition.name).or_else(|| nearest(key, &names));
    Err(match suggestion {
        Some(name) => format!("is no setting; did you mean \"{name}\"?"),
        None => "is no setting; keys are the long options of rayframe render, with _ for -".to_owned(),
    })
}

impl Settings {
    /// Sets one setting by its name from text. It replaces its earlier value and settings that cannot be combined with it, with those
    /// that have no effect without them; `false` replaces no other setting, and repeated settings add up. After an error nothing has changed.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::error::Error::Setting) for an unknown name, with the closest one, and for a wrong value.
    pub fn set(&mut self, name: &str, text: &OsStr, origin: &Provenance) -> Result<(), SettingError> {
        let error = |why| SettingError { setting: name.to_owned(), origin: origin.clone(), why };
        let definition = find(name).map_err(error)?;
        let mut parsed = Self::default();
        definition.parse(&mut parsed, text, origin).map_err(error)?;
        if definition.is_in_effect(&parsed) {
            for other in DEFINITIONS.iter().filter(|other| other.is_excluded_by(definition)) {
                if other.origin(self).is_some() {
                    self.clear(other.name);
                    let dependent =
                        DEFINITIONS.iter().filter(|dependent| dependent.requires == Some(other.name));
                    dependent.for_each(|dependent| self.clear(dependent.name));
                }
            }
        }
        if definition.form.is_repeated {
            return definition.parse(self, text, origin).map_err(error);
        }
        (definition.access.copy)(self, &parsed);
        Ok(())
    }
}
