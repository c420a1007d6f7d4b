//! Options that replace single limits of a preset.

use clap::Args;
use rayframe::regression::{Limits, Preset};

/// Limits in place of the preset's. Their names are those of the table `[test]` of a suite.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Limits")]
pub(in crate::cli) struct LimitOptions {
    /// Largest mean FLIP, from 0 to 1, in place of the preset's; inf is no limit
    #[arg(long, value_name = "X", value_parser = limit)]
    mean_flip: Option<f64>,
    /// Largest FLIP of a tile of 8x8 pixels, from 0 to 1, in place of the preset's
    #[arg(long, value_name = "X", value_parser = limit)]
    tile_flip: Option<f64>,
    /// Largest mean FLIP of an object, where both have its layer object_id, in place of the preset's
    #[arg(long, value_name = "X", value_parser = limit)]
    object_flip: Option<f64>,
    /// Largest difference of mean brightness as a share of the reference's, in place of the preset's
    #[arg(long, value_name = "X", value_parser = limit)]
    brightness: Option<f64>,
}

impl LimitOptions {
    /// The limits of the preset with those that are given.
    pub(super) fn limits(&self, preset: Preset) -> Limits {
        let limits = preset.limits();
        Limits {
            mean_flip: self.mean_flip.unwrap_or(limits.mean_flip),
            tile_flip: self.tile_flip.unwrap_or(limits.tile_flip),
            object_flip: self.object_flip.unwrap_or(limits.object_flip),
            brightness: self.brightness.unwrap_or(limits.brightness),
            ..limits
        }
    }

    /// The preset's name, with a suffix where limits are changed.
    pub(super) fn preset_name(&self, preset: Preset) -> String {
        let name = preset.name();
        if self.limits(preset) == preset.limits() {
            name.to_owned()
        } else {
            format!("{name} with own limits")
        }
    }

    /// The options as they may be typed.
    pub(super) fn words(&self) -> Vec<String> {
        let options = [
            ("mean-flip", self.mean_flip),
            ("tile-flip", self.tile_flip),
            ("object-flip", self.object_flip),
            ("brightness", self.brightness),
        ];
        let typed =
            options.into_iter().filter_map(|(name, value)| Some([format!("--{name}"), value?.to_string()]));
        typed.flatten().collect()
    }
}

fn limit(text: &str) -> std::result::Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "write a number from 0, or inf for no limit".to_owned())?;
    if number.is_nan() || number < 0.0 {
        return Err("write a number from 0, or inf for no limit".to_owned());
    }
    Ok(number)
}
