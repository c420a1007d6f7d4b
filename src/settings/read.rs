//! Reads settings from shot files, suite files and definitions `KEY=VALUE`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::{Provenance, Result, SettingError};

use super::definitions::Settings;
use super::keys::find;
use super::text_file::read_text;
use super::toml_file::{TomlEntry, TomlFile, entries, wrong_kind};
use super::toml_value::texts;

/// Table of a shot file with the limits of `rayframe test`, which are no settings.
const LIMITS: &str = "test";
/// Table of a suite file with settings of all its shots.
const SHOT: &str = "shot";

impl TomlFile<'_> {
    /// Sets all keys of a table, in the order of the lines.
    fn read_table(&self, settings: &mut Settings, table: &DeTable<'_>) -> Result<()> {
        for entry in entries(table) {
            self.read_entry(settings, entry)?;
        }
        settings.check_exclusions()
    }

    fn read_entry(&self, settings: &mut Settings, entry: TomlEntry<'_>) -> Result<()> {
        let definition = find(entry.key).map_err(|why| {
            let why = if entry.value.is_table() {
                "is a table; only [test] is one, settings are lines above it"
            } else {
                &why
            };
            self.wrong_key(entry, why)
        })?;
        let origin = self.origin(entry.at);
        let wrong =
            |why: String| SettingError { setting: definition.name.to_owned(), origin: origin.clone(), why };
        // The value that a text is without its quotes must be valid, too.
        let check = |value: &DeValue<'_>| {
            let texts = texts(definition.form, value).unwrap_or_default();
            texts.iter().try_for_each(|text| definition.parse(&mut Settings::default(), text, &origin))
        };
        let texts = texts(definition.form, entry.value)
            .ok_or_else(|| wrong(wrong_kind(entry.value, &definition.form.expected(), check)))?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if definition.origin(settings).is_some() {
            return Err(wrong("is set twice".to_owned()).into());
        }
        for text in texts {
            let text: OsString = (definition.access.rebase)(text, folder);
            definition.parse(settings, &text, &origin).map_err(wrong)?;
        }
        Ok(())
    }
}

impl Settings {
    /// The settings of a shot file.
    ///
    /// # Errors
    /// [`Error::Missing`](crate::error::Error::Missing) when it cannot be read, [`Error::Refused`](crate::error::Error::Refused) when it is too large, and [`Error::Setting`](crate::error::Error::Setting) with line
    /// and column for a wrong key or value.
    pub fn read_shot(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        let file = TomlFile { path, text: &text };
        let mut table = file.table()?;
        if table.get(LIMITS).is_some_and(|limits| limits.get_ref().is_table()) {
            table.remove(LIMITS);
        }
        let mut settings = Self::default();
        file.read_table(&mut settings, &table)?;
        Ok(settings)
    }

    /// The scene of a shot file, if it names one; other settings are not checked.
    ///
    /// # Errors
    /// Those of [`Settings::read_shot`].
    pub fn read_shot_scene(path: &Path) -> Result<Option<PathBuf>> {
        let text = read_text(path)?;
        let file = TomlFile { path, text: &text };
        let table = file.table()?;
        let mut settings = Self::default();
        if let Some(scene) = entries(&table).into_iter().find(|entry| entry.key == "scene") {
            file.read_entry(&mut settings, scene)?;
        }
        Ok(settings.scene.map(|scene| scene.value))
    }

    /// The settings that a suite file has for all its shots.
    ///
    /// # Errors
    /// Those of [`Settings::read_shot`].
    pub fn read_suite(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        let file = TomlFile { path, text: &text };
        let mut settings = Self::default();
        let whole = file.table()?;
        let Some(shot) = entries(&whole).into_iter().find(|entry| entry.key == SHOT) else {
            return Ok(settings);
        };
        let DeValue::Table(table) = shot.value else {
            let expected = format!("[{SHOT}] and below it settings for all shots");
            return Err(file.wrong_kind(shot, &expected));
        };
        if let Some(scene) = entries(table).into_iter().find(|entry| entry.key == "scene") {
            return Err(file.wrong_key(scene, "differs from shot to shot; name it in a shot file"));
        }
        file.read_table(&mut settings, table)?;
        Ok(settings)
    }

    /// The settings of definitions `KEY=VALUE`. A value is TOML, or text where it is no TOML value. The last of several
    /// definitions of a setting counts; repeated settings add up.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::error::Error::Setting) for a wrong key or value.
    pub fn read_definitions<'a>(definitions: impl IntoIterator<Item = &'a String>) -> Result<Self> {
        let mut settings = Self::default();
        for text in definitions {
            settings.define(text)?;
        }
        settings.check_exclusions()?;
        Ok(settings)
    }

    fn define(&mut self, definition_text: &str) -> Result<()> {
        let origin = Provenance::Define(definition_text.to_owned());
        let wrong = |why: String| SettingError { setting: String::new(), origin: origin.clone(), why };
        let (key, value) = definition_text
            .split_once('=')
            .ok_or_else(|| wrong("write KEY=VALUE, such as samples=16".to_owned()))?;
        let (key, value) = (key.trim().replace('-', "_"), value.trim());
        let definition = find(&key).map_err(|why| wrong(format!("\"{}\" {why}", key.escape_debug())))?;
        let parsed = DeValue::parse(value).ok();
        let texts = parsed.and_then(|value| texts(definition.form, value.get_ref()));
        for text in texts.unwrap_or_else(|| vec![value.into()]) {
            definition.parse(self, &text, &origin).map_err(wrong)?;
        }
        Ok(())
    }
}
