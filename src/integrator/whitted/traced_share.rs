//! Split of a rough lobe between traced rays and lookups of the prefiltered environment.

use crate::geometry::smoothstep;

/// Lobes of a lower roughness are traced.
const TRACED_ROUGHNESS: f32 = 0.1;
/// Lobes of a higher roughness look up the prefiltered environment.
pub(super) const PREFILTERED_ROUGHNESS: f32 = 0.4;

/// Share of a lobe that rays follow; the prefiltered environment has the rest.
#[inline(always)]
pub(super) fn traced_share(roughness: f32) -> f32 {
    1.0 - smoothstep([TRACED_ROUGHNESS, PREFILTERED_ROUGHNESS], roughness)
}
