//! Levels of settings, merged field by field.

use std::path::PathBuf;

use crate::error::{Error, Provenance, Result, SettingError};

use super::conflicts::{camera_decides_about_crop, conflicts};
use super::definitions::{DEFINITIONS, Definition, Settings};

impl Settings {
    /// Adds what `lower` gives and these settings do not, unless it cannot be combined with them or has no effect beside them: then it
    /// gives way, and so does what has no effect without it. Folders of `allow_dir` add up.
    pub fn fill_from(&mut self, lower: &Self) {
        let is_new = |definition: &Definition| definition.origin(self).is_none();
        let mut both = self.clone();
        if let (Some(own), Some(others)) = (&mut both.allow_dir, &lower.allow_dir) {
            let is_other = |folder: &&PathBuf| self.allow_dir.iter().all(|own| !own.value.contains(folder));
            own.value.extend(others.value.iter().filter(is_other).cloned());
        }
        for definition in DEFINITIONS.iter().filter(|definition| is_new(definition)) {
            if definition.origin(lower).is_some() && !self.excludes(definition) {
                (definition.access.copy)(&mut both, lower);
            }
        }
        let values = both.values();
        if self.crop.is_none() && both.crop.is_some() {
            both.crop_gives_way = lower.crop_gives_way || camera_decides_about_crop(self, &values);
        }
        let gives_way = |definition: &Definition| {
            is_new(definition) && (self.excludes(definition) || conflicts(definition.name, self, &values))
        };
        let lacks_another = |definition: &Definition| {
            is_new(definition) && definition.requires.and_then(Definition::of).is_some_and(gives_way)
        };
        for definition in DEFINITIONS {
            if gives_way(definition) || lacks_another(definition) {
                (definition.access.clear)(&mut both);
            }
        }
        *self = both;
    }

    /// Whether a setting cannot be combined with one that is in effect here.
    pub(super) fn excludes(&self, definition: &Definition) -> bool {
        DEFINITIONS.iter().any(|other| other.is_excluded_by(definition) && other.is_in_effect(self))
    }

    /// Checks the settings of one level: no two may exclude each other.
    ///
    /// # Errors
    /// [`Error::Setting`] for the later of two settings.
    pub fn check_exclusions(&self) -> Result<()> {
        for (index, later) in DEFINITIONS.iter().enumerate().rev() {
            let earlier = &DEFINITIONS[..index];
            let conflict = earlier.iter().find(|earlier| {
                later.is_in_effect(self) && earlier.is_in_effect(self) && later.is_excluded_by(earlier)
            });
            if let Some(earlier) = conflict {
                return Err(self.error(later.name, format!("cannot be combined with `{}`", earlier.name)));
            }
        }
        Ok(())
    }

    /// Checks values that come from code, as texts are checked where they are read.
    ///
    /// # Errors
    /// [`Error::Setting`] for the first that no text gives.
    pub(crate) fn check_values(&self) -> Result<()> {
        for definition in DEFINITIONS {
            if definition.origin(self) == Some(&Provenance::Library) {
                (definition.access.check)(self).map_err(|why| self.error(definition.name, why))?;
            }
        }
        Ok(())
    }

    /// Checks that no setting lacks the one without which it has no meaning.
    ///
    /// # Errors
    /// [`Error::Setting`] for the first that does.
    pub fn check_requirements(&self) -> Result<()> {
        for definition in DEFINITIONS.iter().filter(|definition| definition.origin(self).is_some()) {
            if let Some(needed) = definition.requires.filter(|needed| self.origin_of(needed).is_none()) {
                return Err(self.error(definition.name, format!("has no effect without `{needed}`")));
            }
        }
        Ok(())
    }

    /// Where the setting `name` was given.
    pub fn origin_of(&self, name: &str) -> Option<&Provenance> {
        Definition::of(name)?.origin(self)
    }

    /// An error about the setting `name`, with its origin.
    pub fn error(&self, name: &str, why: impl Into<String>) -> Error {
        let origin = self.origin_of(name).cloned().unwrap_or_default();
        SettingError { setting: name.to_owned(), origin, why: why.into() }.into()
    }

    /// The error with the origin of the setting that it concerns.
    pub fn locate(&self, error: Error) -> Error {
        match error {
            Error::Setting(error) if error.origin == Provenance::Library => {
                self.error(&error.setting, error.why)
            }
            error => error,
        }
    }

    /// Takes the setting `name` out.
    pub fn clear(&mut self, name: &str) {
        if let Some(definition) = Definition::of(name) {
            (definition.access.clear)(self);
        }
    }
}

impl Definition {
    /// Whether it is given, and not `false`.
    pub(super) fn is_in_effect(&self, settings: &Settings) -> bool {
        self.texts(settings).is_some_and(|texts| !self.is_flag() || texts.iter().any(|text| text == "true"))
    }
}
