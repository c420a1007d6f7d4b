//! How light came to the eye: the parts that a picture can be taken apart into.

/// How light came to the eye. What the camera sees last decides: each bit of a pixel's light is in exactly one part, so that
/// they sum to its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightPass {
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
    Transparency,
}

impl LightPass {
    /// All parts, in the order of their subscripts.
    pub const ALL: [Self; 6] = [
        Self::Emission,
        Self::Direct,
        Self::Environment,
        Self::Reflection,
        Self::Refraction,
        Self::Transparency,
    ];

    /// Its subscript in [`LightPasses`].
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
            Self::Transparency => "pass_through",
        }
    }
}

/// Linear Rec.709 radiance of one pixel by [`LightPass`], premultiplied like the pixel itself.
pub type LightPasses = [[f32; 3]; LightPass::ALL.len()];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscripts_follow_the_list() {
        for (subscript, part) in LightPass::ALL.into_iter().enumerate() {
            assert_eq!(part.subscript(), subscript);
        }
    }
}
