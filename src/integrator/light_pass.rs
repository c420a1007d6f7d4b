//! Light passes: the parts of a pixel's light by the way it took to the camera.

/// A part of a pixel's light, by the first surface that the camera sees. Each contribution is in exactly one pass, so that
/// the passes sum to the colour. With paths, the light of lamps, emissive surfaces and the environment that rough lobes of the first surface scatter
/// is in the passes of these, whether a shadow ray or the path's own ray finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightPass {
    /// Emitted by the first surface, unlit materials included.
    Emission,
    /// From punctual lights, the environment's key light and, with paths, emissive surfaces, scattered by the first surface.
    Direct,
    /// From the environment, scattered by the first surface or seen directly as the background.
    Environment,
    /// Found by mirror rays of the first surface, whatever they hit; with paths, by the rays that it reflects, diffuse ones included.
    Reflection,
    /// Found by refraction rays of the first surface, whatever they hit; with paths, by the rays that it transmits.
    Refraction,
    /// From everything beyond a transparent first surface (by alpha, not by transmission).
    Transparency,
}

impl LightPass {
    /// All passes, in the order of their indices.
    pub const ALL: [Self; 6] = [
        Self::Emission,
        Self::Direct,
        Self::Environment,
        Self::Reflection,
        Self::Refraction,
        Self::Transparency,
    ];

    /// Index of the pass in [`LightPasses`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name of the AOV of the pass in files.
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
    fn indices_follow_the_list() {
        for (index, light_pass) in LightPass::ALL.into_iter().enumerate() {
            assert_eq!(light_pass.index(), index);
        }
    }
}
