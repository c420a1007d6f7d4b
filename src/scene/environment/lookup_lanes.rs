//! Directions that are looked up together, in lanes.

use fearless_simd::Level;

use super::octahedral::uvs_from_directions;
use crate::geometry::{ActiveLanes, Vec2Lanes, Vec3Lanes, vectorized};

/// Directions that are looked up together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LookupLanes<'d> {
    /// The instruction set that computes the positions.
    pub(crate) level: Level,
    pub(crate) directions: &'d Vec3Lanes,
    /// The lanes that are looked up. Others keep their values or get undefined ones.
    pub(crate) lanes: ActiveLanes,
}

impl LookupLanes<'_> {
    /// Positions in octahedral images.
    #[inline(always)]
    pub(super) fn octahedral_positions(&self) -> Vec2Lanes {
        let mut uvs = Vec2Lanes::default();
        vectorized!(self.level, uvs_from_directions(self.directions, &mut uvs));
        uvs
    }
}
