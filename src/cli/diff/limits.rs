//! Options that replace single limits of a preset.

use clap::Args;
use rayframe::regression::{Limits, Preset};

/// Limits in place of the preset's. Their names are those of the table `[test]` of a suite.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Limits")]
pub(in crate::cli) struct LimitOptions {
    /// Largest mean FLIP, from 0 to 1, in place of the preset's; inf is no limit
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |text: &str| limit("mean_flip", text))]
    mean_flip: Option<f64>,
    /// Largest FLIP of a tile of 8x8 pixels, from 0 to 1, in place of the preset's
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |text: &str| limit("tile_flip", text))]
    tile_flip: Option<f64>,
    /// Largest mean FLIP of an object, where both have its layer object_id, in place of the preset's
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |text: &str| limit("object_flip", text))]
    object_flip: Option<f64>,
    /// Largest difference of mean brightness as a share of the reference's, in place of the preset's
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |text: &str| limit("brightness", text))]
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

fn limit(name: &str, text: &str) -> Result<f64, &'static str> {
    // What is no number gets the same advice.
    let number = text.parse().unwrap_or(f64::NAN);
    Limits::check(name, number).map(|()| number)
}
