//! Limits of a suite or shot: the table `[test]` of suite and shot files.

use serde::Deserialize;

use super::super::{Limits, Preset};

/// The table `[test]` as written. Absent fields keep the previous limit.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(super) struct LimitTable {
    preset: Option<String>,
    different_values: Option<f64>,
    light_absolute: Option<f64>,
    light_relative: Option<f64>,
    light_share: Option<f64>,
    data_absolute: Option<f64>,
    data_relative: Option<f64>,
    data_share: Option<f64>,
    mean_flip: Option<f64>,
    tile_flip: Option<f64>,
    brightness: Option<f64>,
}

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

    /// Applies `table`. A preset in it replaces all limits.
    ///
    /// # Errors
    /// A message with the name of the invalid field.
    pub(super) fn with(mut self, table: &LimitTable) -> Result<Self, String> {
        if let Some(name) = &table.preset {
            let preset = Preset::of_name(name).ok_or_else(|| {
                format!("preset: there is no \"{}\"; write {}", name.escape_debug(), Preset::NAMES)
            })?;
            self = Self { preset, limits: preset.limits() };
        }
        let limits = &mut self.limits;
        for (name, value, limit) in [
            ("different_values", table.different_values, &mut limits.different_values),
            ("light_share", table.light_share, &mut limits.light_share),
            ("data_share", table.data_share, &mut limits.data_share),
            ("mean_flip", table.mean_flip, &mut limits.mean_flip),
            ("tile_flip", table.tile_flip, &mut limits.tile_flip),
            ("brightness", table.brightness, &mut limits.brightness),
            ("light_absolute", table.light_absolute, &mut limits.light.absolute),
            ("light_relative", table.light_relative, &mut limits.light.relative),
            ("data_absolute", table.data_absolute, &mut limits.data.absolute),
            ("data_relative", table.data_relative, &mut limits.data.relative),
        ] {
            set(name, value, limit)?;
        }
        Ok(self)
    }
}

fn set(name: &str, value: Option<f64>, limit: &mut f64) -> Result<(), String> {
    match value {
        // NaN fails this comparison.
        Some(value) if value >= 0.0 => *limit = value,
        Some(_) => return Err(format!("{name}: write a number from 0, or inf for no limit")),
        None => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> LimitTable {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn absent_fields_keep_their_limits() {
        let strict = PresetLimits { preset: Preset::Strict, limits: Preset::Strict.limits() };
        assert_eq!(strict.with(&table("")), Ok(strict));
        let changed = strict.with(&table("tile_flip = 1\nlight_absolute = 0.25")).unwrap();
        assert_eq!((changed.limits.tile_flip, changed.limits.light.absolute), (1.0, 0.25));
        assert_eq!(changed.limits.mean_flip, Preset::Strict.limits().mean_flip);
        assert_eq!(changed.name(), "strict with own limits");
        let noisy = changed.with(&table("preset = 'noisy'\nbrightness = inf")).unwrap();
        assert_eq!(noisy.limits.brightness, f64::INFINITY);
        assert_eq!(noisy.limits.tile_flip, Preset::Noisy.limits().tile_flip);
    }

    #[test]
    fn invalid_fields_are_named() {
        let error = |text: &str| PresetLimits::default().with(&table(text)).unwrap_err();
        assert!(error("preset = 'lose'").contains("exact, strict, visual or noisy"));
        assert!(error("mean_flip = -1").starts_with("mean_flip: "));
        assert!(error("data_relative = nan").starts_with("data_relative: "));
        assert!(toml::from_str::<LimitTable>("flip = 1").is_err());
    }
}
