//! Dimensions of a path's sample points.

/// Dimensions of one bounce.
const OF_BOUNCE: u32 = 16;

/// A decision at one surface of a path. Each has a sample point of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// The colour channel that goes on where a surface disperses light.
    Channel,
    /// The lobe of the ray that goes on; whether the path ends.
    LobeAndRoulette,
    /// Its direction.
    Direction,
    /// The punctual light.
    Light,
    /// The point on that light.
    LightPoint,
    /// The direction to the environment.
    Environment,
    /// The emissive triangle.
    Emitter,
    /// The point on that triangle.
    EmitterPoint,
    /// Whether a transparent surface is passed.
    Coverage,
}

impl Decision {
    /// Its dimension at a surface after `depth` bounces.
    pub(super) fn dimension(self, depth: u32) -> u32 {
        depth.wrapping_mul(OF_BOUNCE).wrapping_add(self as u32)
    }
}
