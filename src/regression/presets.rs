//! What may differ: limits on every measure, and four sets of them.

use serde::Serialize;

use super::ValueLimits;

/// The largest values that pass. Infinity asks for nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Values whose bits differ, of all channels.
    pub different_values: f64,
    /// A value of a layer of light is too far off when it is beyond both of these: linear light, or 0 to 1 of a display.
    pub light: ValueLimits,
    /// Pixels with such a value, as a share of all.
    pub light_share: f64,
    /// A value of a layer of data (depth, normals, albedo, …) is too far off when it is beyond both: in its own units. Ids
    /// are either equal or too far off.
    pub data: ValueLimits,
    /// Pixels with such a value, as a share of all.
    pub data_share: f64,
    /// Mean FLIP, 0 to 1.
    pub mean_flip: f64,
    /// Mean FLIP of the worst tile of 8x8 pixels, 0 to 1. This is what notices a speck.
    pub tile_flip: f64,
    /// How far the mean luminance may be off, as a share of the reference's.
    pub brightness: f64,
}

/// The sets that have names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Every bit of every value: for renders of one version, which are deterministic.
    Exact,
    /// Everything that a person could find by looking for it, and less; roundings of other programs pass.
    Strict,
    /// What somebody sees who flips between the pictures: an object that is lost or moved, but not a little noise or
    /// exposure.
    #[default]
    Visual,
    /// Whether two noisy pictures could be of one scene.
    Noisy,
}

impl Preset {
    /// All of them, the narrowest first.
    pub const ALL: [Self; 4] = [Self::Exact, Self::Strict, Self::Visual, Self::Noisy];

    /// Their names, for messages.
    pub const NAMES: &'static str = "exact, strict, visual or noisy";

    /// The one of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Strict => "strict",
            Self::Visual => "visual",
            Self::Noisy => "noisy",
        }
    }

    /// Its limits.
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
    brightness: 0.0,
};

/// Half a step of eight bits, or half a percent: what rounding explains. One pixel in ten thousand may be further off.
const STRICT: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.002, relative: 0.005 },
    light_share: 1e-4,
    data: ValueLimits { absolute: 1e-3, relative: 1e-3 },
    data_share: 1e-4,
    mean_flip: 0.005,
    tile_flip: 0.05,
    brightness: 0.002,
};

/// Values are not looked at one by one, but for data, which have no noise. Mean FLIP of 2 % more light is up to 0.06, of its
/// worst tile 0.1; a speck of 6x6 pixels half as bright gives its tile 0.3 (`cargo test --test library corruptions -- --nocapture`).
const VISUAL: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.0, relative: 0.0 },
    light_share: f64::INFINITY,
    data: ValueLimits { absolute: 0.01, relative: 0.01 },
    data_share: 1e-3,
    mean_flip: 0.08,
    tile_flip: 0.2,
    brightness: 0.03,
};

/// Wide enough for pictures of few samples, and for data of edges that other samples met; their brightness must agree.
const NOISY: Limits = Limits {
    different_values: f64::INFINITY,
    light: ValueLimits { absolute: 0.0, relative: 0.0 },
    light_share: f64::INFINITY,
    data: ValueLimits { absolute: 0.05, relative: 0.05 },
    data_share: 0.05,
    mean_flip: 0.15,
    tile_flip: 0.5,
    brightness: 0.05,
};
