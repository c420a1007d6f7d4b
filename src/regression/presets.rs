//! Limits on the measures of a comparison, and four presets of them.

use serde::Serialize;

use super::ValueLimits;

/// The largest values that pass. Infinity is no limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Number of values whose bits differ, over all channels.
    pub different_values: f64,
    /// Limits on values of layers of light, in linear light or in display values from 0 to 1.
    pub light: ValueLimits,
    /// Share of pixels with a value of light beyond both limits.
    pub light_share: f64,
    /// Limits on values of layers of data (depth, normals, albedo, …), in units of the layer; where depths or positions lie within less than
    /// one unit, the absolute limit is a share of their range. Ids must be equal.
    pub data: ValueLimits,
    /// Share of pixels with a value of data beyond both limits.
    pub data_share: f64,
    /// Mean FLIP, 0 to 1.
    pub mean_flip: f64,
    /// Mean FLIP of the worst tile of 8x8 pixels, 0 to 1. Small objects that vanish exceed this limit first.
    pub tile_flip: f64,
    /// Mean FLIP of the worst object, 0 to 1. Limits slight changes of a whole object, whatever its share of the image. It applies
    /// where both images have the layer `object_id`.
    pub object_flip: f64,
    /// Difference of mean luminance, as a share of the reference's.
    pub brightness: f64,
}

/// A limit that any value may have: infinity is none.
const ANY: (f64, &str) = (f64::INFINITY, "write a number from 0, or inf for no limit");
/// A limit on FLIP or on a share of pixels, which are 1 at most: a larger one would be no limit without saying so.
const SHARE: (f64, &str) = (1.0, "write a number from 0 to 1, or inf for no limit");

impl Limits {
    /// Checks a limit of the name that it has in the table `[test]` of a suite.
    ///
    /// # Errors
    /// What to write instead.
    pub fn check(name: &str, value: f64) -> Result<(), &'static str> {
        let is_share = name.ends_with("_flip") || name.ends_with("_share");
        let (largest, remedy) = if is_share { SHARE } else { ANY };
        let is_limit = (0.0..=largest).contains(&value) || value == f64::INFINITY;
        if is_limit { Ok(()) } else { Err(remedy) }
    }
}

/// A named set of limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Every bit of every value must be equal. For renders of one version, which are deterministic.
    Exact,
    /// Catches every difference that a person could find, and smaller ones. Rounding errors of other programs pass.
    Strict,
    /// Catches what a person sees when flipping between the images, such as a lost or moved object or a paler material. What nobody
    /// sees passes: vertices of 14 bits, a little noise or exposure.
    #[default]
    Visual,
    /// Catches images that cannot show the same scene. Noise passes.
    Noisy,
}

impl Preset {
    /// All presets, the strictest first.
    pub const ALL: [Self; 4] = [Self::Exact, Self::Strict, Self::Visual, Self::Noisy];

    /// The names, for messages.
    pub const NAMES: &'static str = "exact, strict, visual or noisy";

    /// The preset of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Strict => "strict",
            Self::Visual => "visual",
            Self::Noisy => "noisy",
        }
    }

    /// The limits of the preset.
    pub fn limits(self) -> Limits {
        match self {
            Self::Exact => EXACT,
            Self::Strict => STRICT,
            Self::Visual => VISUAL,
            Self::Noisy => NOISY,
        }
    }
}

const EXACT: Limits = Limits {
    different_values: 0.0,
    light: ValueLimits { absolute: 0.0, relative: 0.0 },
    light_share: 0.0,
    data: ValueLimits { absolute: 0.0, relative: 0.0 },
    data_share: 0.0,
    mean_flip: 0.0,
    tile_flip: 0.0,
    object_flip: 0.0,
    brightness: 0.0,
};

/// Half a step of eight bits, or half a percent, which rounding explains. One pixel in ten thousand may be further off.
const STRICT: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.002, relative: 0.005 },
    light_share: 1e-4,
    data: ValueLimits { absolute: 1e-3, relative: 1e-3 },
    data_share: 1e-4,
    mean_flip: 0.005,
    tile_flip: 0.05,
    object_flip: 0.02,
    brightness: 0.002,
};

/// Limits single values of data only, which have no noise. Edits of assets that nobody sees give their worst tile up to 0.078, those
/// that a person sees at least 0.122 (`tests/oracles/asset_edits.py`). Mean FLIP of 2 % more light, which passes, is up to 0.06, that of
/// its worst tile 0.093 (`cargo test --test library corruptions -- --nocapture`).
const VISUAL: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.0, relative: 0.0 },
    light_share: f64::INFINITY,
    data: ValueLimits { absolute: 0.01, relative: 0.01 },
    data_share: 1e-3,
    mean_flip: 0.08,
    tile_flip: 0.1,
    object_flip: 0.06,
    brightness: 0.03,
};

/// Admits images of few samples, and data of edges that other samples hit. The brightness must agree.
const NOISY: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.0, relative: 0.0 },
    light_share: f64::INFINITY,
    data: ValueLimits { absolute: 0.05, relative: 0.05 },
    data_share: 0.05,
    mean_flip: 0.15,
    tile_flip: 0.5,
    object_flip: 0.3,
    brightness: 0.05,
};
