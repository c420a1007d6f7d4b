//! Images and how they are looked up.

use super::ImageIndex;

/// An image with its sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Which image.
    pub image: ImageIndex,
    /// How it is looked up.
    pub sampler: Sampler,
}

/// What happens outside the unit square and between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: WrapMode,
    /// Along v.
    pub wrap_v: WrapMode,
    /// Between texels, where a texel covers more than a pixel.
    pub magnify: Filter,
    /// Between texels of one level, where a pixel covers more than a texel.
    pub minify: Filter,
    /// Between levels of detail, there.
    pub mip: MipFilter,
}

/// How smaller copies of an image are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MipFilter {
    /// Not at all: the full image is looked up once, however much of it a pixel covers.
    None,
    /// The closest one.
    Nearest,
    /// Linear interpolation between two.
    #[default]
    Linear,
}

/// What happens outside the unit interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum WrapMode {
    /// Starts again.
    #[default]
    Repeat,
    /// Starts again, every other time mirrored.
    MirroredRepeat,
    /// Continues the border texel.
    ClampToEdge,
}

/// How a value between samples is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// The closest one.
    Nearest,
    /// Linear interpolation.
    #[default]
    Linear,
}

/// A decoded image; row 0 is the top row.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Name or URI, for messages.
    pub name: Option<String>,
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major texels, `width · height` of them.
    pub texels: Texels,
}

/// What the channels of a texture mean, which decides how they become numbers and what their mean is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Colours whose alpha does not matter: RGB follow the sRGB transfer function, alpha is linear.
    Srgb,
    /// The same where alpha is coverage: a colour counts as much as it covers.
    CoveredSrgb,
    /// Tangent-space normals: RGB hold a direction as 2c − 1.
    Normal,
    /// Everything else.
    Linear,
}

/// Texel values as stored, not yet decoded from sRGB: that depends on the use.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Eight bits a channel.
    Rgba8(Vec<[u8; 4]>),
    /// Sixteen bits a channel.
    Rgba16(Vec<[u16; 4]>),
}
