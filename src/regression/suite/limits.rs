//! Limits of a suite or shot: the table `[test]` of suite and shot files.

use toml::de::{DeTable, DeValue};

use super::super::{Limits, Preset};
use super::coverage::COVERAGE_KEYS;
use crate::error::Result;
use crate::settings::{TomlEntry, TomlFile, entries, nearest};

/// Name of the table.
const TEST: &str = "test";
/// Keys of the table.
const KEYS: [&str; 12] = [
    "preset",
    "different_values",
    "light_absolute",
    "light_relative",
    "light_share",
    "data_absolute",
    "data_relative",
    "data_share",
    "mean_flip",
    "tile_flip",
    "object_flip",
    "brightness",
];

/// A preset, and its limits with changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PresetLimits {
    pub(super) preset: Preset,
    pub(super) limits: Limits,
}

impl Default for PresetLimits {
    fn default() -> Self {
        Self { preset: Preset::default(), limits: Preset::default().limits() }
    }
}

impl PresetLimits {
    /// The preset's name, with a suffix where limits were changed.
    pub(super) fn name(&self) -> String {
        let name = self.preset.name();
        if self.limits == self.preset.limits() { name.to_owned() } else { format!("{name} with own limits") }
    }

    /// Applies the table `[test]` of a file, if it has one. A preset in it replaces all limits; absent keys keep theirs.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::error::Error::Setting) with line and column of a wrong key or value.
    pub(super) fn with(mut self, file: &TomlFile<'_>, whole: &DeTable<'_>) -> Result<Self> {
        let Some(test) = entries(whole).into_iter().find(|entry| entry.key == TEST) else {
            return Ok(self);
        };
        let DeValue::Table(table) = test.value else {
            return Err(file.wrong_kind(test, "[test] and below it limits"));
        };
        let entries = entries(table);
        // The preset comes first, wherever it stands.
        if let Some(&entry) = entries.iter().find(|entry| entry.key == "preset") {
            let preset = preset(file, entry)?;
            self = Self { preset, limits: preset.limits() };
        }
        let is_limit = |entry: &TomlEntry<'_>| entry.key != "preset" && !COVERAGE_KEYS.contains(&entry.key);
        for entry in entries.into_iter().filter(is_limit) {
            let limit = self.limits.named_mut(entry.key).ok_or_else(|| {
                file.unknown_key(entry, "a key of [test]", &[&KEYS[..], &COVERAGE_KEYS].concat())
            })?;
            *limit = file.number(entry, |value| Limits::check(entry.key, value))?;
        }
        Ok(self)
    }
}

impl Limits {
    fn named_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "different_values" => &mut self.different_values,
            "light_absolute" => &mut self.light.absolute,
            "light_relative" => &mut self.light.relative,
            "light_share" => &mut self.light_share,
            "data_absolute" => &mut self.data.absolute,
            "data_relative" => &mut self.data.relative,
            "data_share" => &mut self.data_share,
            "mean_flip" => &mut self.mean_flip,
            "tile_flip" => &mut self.tile_flip,
            "object_flip" => &mut self.object_flip,
            "brightness" => &mut self.brightness,
            _ => return None,
        })
    }
}

fn preset(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<Preset> {
    let DeValue::String(name) = entry.value else {
        return Err(file.wrong_kind(entry, "a text in quotes"));
    };
    Preset::of_name(name).ok_or_else(|| {
        let names = Preset::ALL.map(Preset::name);
        let suggestion = nearest(name, &names).map(|name| format!("; did you mean \"{name}\"?"));
        let hint = suggestion.unwrap_or_else(|| format!("; write {}", Preset::NAMES));
        file.wrong_value(entry, format!("there is no \"{}\"{hint}", name.escape_debug()))
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn with(limits: PresetLimits, text: &str) -> Result<PresetLimits> {
        let text = format!("[test]\n{text}");
        let file = TomlFile { path: Path::new("suite.toml"), text: &text };
        limits.with(&file, &file.table()?)
    }

    #[test]
    fn absent_keys_keep_their_limits() {
        let strict = PresetLimits { preset: Preset::Strict, limits: Preset::Strict.limits() };
        assert_eq!(with(strict, "").unwrap(), strict);
        let changed = with(strict, "tile_flip = 1\nlight_absolute = 25").unwrap();
        assert_eq!((changed.limits.tile_flip, changed.limits.light.absolute), (1.0, 25.0));
        assert_eq!(changed.limits.mean_flip, Preset::Strict.limits().mean_flip);
        assert_eq!(changed.name(), "strict with own limits");
        let noisy = with(changed, "brightness = inf\npreset = 'noisy'").unwrap();
        assert_eq!(noisy.limits.brightness, f64::INFINITY);
        assert_eq!(noisy.limits.tile_flip, Preset::Noisy.limits().tile_flip);
    }

    #[test]
    fn every_key_is_a_limit_or_the_preset() {
        let mut limits = Preset::Exact.limits();
        assert!(KEYS.iter().all(|&key| key == "preset" || limits.named_mut(key).is_some()));
    }

    #[test]
    fn errors_have_a_position_and_a_suggestion() {
        for (text, message) in [
            ("preset = 'exat'", "suite.toml:2:1: preset: there is no \"exat\"; did you mean \"exact\"?"),
            (
                "preset = 'xyzzy'",
                "suite.toml:2:1: preset: there is no \"xyzzy\"; write exact, strict, visual or noisy",
            ),
            ("preset = 1", "suite.toml:2:1: preset: expected a text in quotes, found a number"),
            (
                "\n mean_flipp = 1",
                "suite.toml:3:2: \"mean_flipp\" is not a key of [test]; did you mean \"mean_flip\"?",
            ),
            ("mean_flip = 'low'", "suite.toml:2:1: mean_flip: expected a number, found a text"),
            (
                "mean_flip = '5'",
                "suite.toml:2:1: mean_flip: expected a number without quotes, found a text; write a number from 0 to 1, or inf for no limit",
            ),
            ("brightness = -1", "suite.toml:2:1: brightness: write a number from 0, or inf for no limit"),
            ("mean_flip = 5", "suite.toml:2:1: mean_flip: write a number from 0 to 1, or inf for no limit"),
            (
                "data_share = nan",
                "suite.toml:2:1: data_share: write a number from 0 to 1, or inf for no limit",
            ),
        ] {
            let error = with(PresetLimits::default(), text).unwrap_err();
            assert_eq!(error.to_string(), message);
            assert_eq!(error.exit_code(), 65);
        }
    }
}
