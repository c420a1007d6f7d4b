//! Textures: images with samplers.

use std::fmt;

use super::ImageIndex;

/// Image with its sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// The image.
    pub image: ImageIndex,
    /// The sampler.
    pub sampler: Sampler,
}

/// Wrap modes and filters of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sampler {
    /// Wrap mode along u.
    pub wrap_u: WrapMode,
    /// Wrap mode along v.
    pub wrap_v: WrapMode,
    /// Filter for magnification.
    pub magnify: Filter,
    /// Filter within a mip level for minification.
    pub minify: Filter,
    /// Filter between mip levels for minification.
    pub mip: MipFilter,
}

impl fmt::Display for Sampler {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} {}, {} magnified, {}{} minified",
            wrap(self.wrap_u),
            wrap(self.wrap_v),
            filter(self.magnify),
            filter(self.minify),
            match self.mip {
                MipFilter::None => "",
                MipFilter::Nearest => " in the nearest mip level",
                MipFilter::Linear => " between mip levels",
            }
        )
    }
}

fn filter(filter: Filter) -> &'static str {
    match filter {
        Filter::Nearest => "nearest",
        Filter::Linear => "linear",
    }
}

fn wrap(mode: WrapMode) -> &'static str {
    match mode {
        WrapMode::Repeat => "repeat",
        WrapMode::MirroredRepeat => "mirror",
        WrapMode::ClampToEdge => "clamp",
    }
}

/// Filter between mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MipFilter {
    /// No mip levels: one lookup in the full image.
    None,
    /// The nearest level.
    Nearest,
    /// Linear interpolation between two levels.
    #[default]
    Linear,
}

/// Wrap mode outside the unit interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum WrapMode {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats, mirrored every second time.
    MirroredRepeat,
    /// Extends the border texel.
    ClampToEdge,
}

/// Filter between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Linear interpolation.
    #[default]
    Linear,
}

/// Decoded texture image; row 0 is the top row.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Name or URI, for messages.
    pub name: Option<String>,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major texels, `width · height` of them.
    pub texels: Texels,
}

impl Image {
    /// Bits of a channel.
    pub fn bits(&self) -> u32 {
        match self.texels {
            Texels::Rgba8(_) => 8,
            Texels::Rgba16(_) => 16,
        }
    }
}

/// Encoding of texture channels, which determines decoding and averaging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Colours without coverage: RGB with the sRGB transfer function, alpha linear.
    Srgb,
    /// sRGB colours whose alpha is coverage: means weight a colour by its alpha.
    CoveredSrgb,
    /// Tangent-space normals: RGB hold a direction as 2c − 1.
    Normal,
    /// All other data.
    Linear,
}

/// Texels as stored. Decoding depends on the [`Encoding`] of the use.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Eight bits per channel.
    Rgba8(Vec<[u8; 4]>),
    /// Sixteen bits per channel.
    Rgba16(Vec<[u16; 4]>),
}
