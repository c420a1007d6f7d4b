//! How light came to the eye: the parts that a picture can be taken apart into.

/// How light came to the eye. What the camera sees last decides: each bit of a pixel's light is in exactly one part, so that
/// they sum to its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightPart {
    /// Given off by the first surface, unlit ones included.
    Emission,
    /// From lamps, scattered by the first surface.
    Direct,
    /// From the environment, scattered by the first surface or seen by itself behind the scene.
    Environment,
    /// By mirror rays of the first surface, whatever they met.
    Reflection,
    /// By rays through the first surface where it is glass, whatever they met.
    Refraction,
    /// By whatever is seen behind a see-through first surface (alpha, not glass).
    PassThrough,
}

impl LightPart {
    /// All parts, in the order of their subscripts.
    pub const ALL: [Self; 6] = [
        Self::Emission,
        Self::Direct,
        Self::Environment,
        Self::Reflection,
        Self::Refraction,
        Self::PassThrough,
    ];

    /// Its subscript in [`LightParts`].
    pub fn subscript(self) -> usize {
        self as usize
    }

    /// As layers are called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Emission => "emission",
            Self::Direct => "direct",
            Self::Environment => "environment",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::PassThrough => "pass_through",
        }
    }
}

/// Linear Rec.709 radiance of one pixel by [`LightPart`], premultiplied like the pixel itself.
pub type LightParts = [[f32; 3]; LightPart::ALL.len()];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscripts_follow_the_list() {
        for (subscript, part) in LightPart::ALL.into_iter().enumerate() {
            assert_eq!(part.subscript(), subscript);
        }
    }
}
