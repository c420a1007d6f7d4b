//! The colour channels that a ray carries.

use glam::Vec3;

/// The colour channels that a ray carries. A dispersive surface splits a white ray into three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorChannels {
    /// All three.
    #[default]
    White,
    /// Red alone.
    Red,
    /// Green alone.
    Green,
    /// Blue alone.
    Blue,
}

impl ColorChannels {
    /// The single channels, in the order of their vector components.
    pub const SINGLE: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// What a component of light is multiplied by that the ray carries, so that three single channels are white light on average.
    pub fn gain(self) -> f32 {
        if self == Self::White { 1.0 } else { 3.0 }
    }

    /// 1 in the channels that the ray carries, 0 in the others.
    pub fn mask(self) -> Vec3 {
        match self {
            Self::White => Vec3::ONE,
            Self::Red => Vec3::X,
            Self::Green => Vec3::Y,
            Self::Blue => Vec3::Z,
        }
    }
}
