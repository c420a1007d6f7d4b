//! Luminance of an environment on a grid of directions, to choose directions by.

use fearless_simd::Level;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::lookup_lanes::LookupLanes;
use super::octahedral::{OctahedralImage, direction_from_uv, node_directions, uv_from_direction};
use super::prefilter::STEPS;
use crate::color::luminance;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec3Lanes};

/// Roughness of the lobe that the radiance is averaged over: the first step, whose width is about that of a cell, so that no lamp falls between.
const ROUGHNESS: f32 = 1.0 / STEPS as f32;

/// Luminance by direction.
#[derive(Debug)]
pub(crate) struct LuminanceImage(OctahedralImage<f32>);

impl LuminanceImage {
    /// Cells along an edge of the grid: 0.9° to 2.2° each.
    pub(crate) const CELLS: usize = 128;

    /// The luminance of an environment by its prefiltered radiance: `prefiltered` is [`super::Environment::prefiltered_lanes`].
    pub(super) fn new(prefiltered: impl Fn(&LookupLanes<'_>, &F32Lanes, &mut Vec3Lanes) + Sync) -> Self {
        let level = Level::new();
        let luminances = |block: &[Vec3]| {
            let (mut directions, mut radiances) = (Vec3Lanes::default(), Vec3Lanes::default());
            for (lane, direction) in block.iter().enumerate() {
                directions.set(lane, *direction);
            }
            let lookups =
                LookupLanes { level, directions: &directions, lanes: ActiveLanes::first(block.len()) };
            prefiltered(&lookups, &[ROUGHNESS; LANES], &mut radiances);
            (0..block.len()).map(move |lane| luminance(radiances.get(lane)))
        };
        let directions: Vec<Vec3> = node_directions(Self::CELLS).collect();
        Self(OctahedralImage::of_numbers(
            Self::CELLS,
            directions.par_chunks(LANES).flat_map_iter(luminances).collect(),
        ))
    }

    /// Position of a direction in the unit square; neighbours in the square are neighbours on the sphere.
    #[inline(always)]
    pub(crate) fn uv_from_direction(direction: Vec3) -> Vec2 {
        uv_from_direction(direction)
    }

    /// Unit vector of a position in the unit square.
    #[inline(always)]
    pub(crate) fn direction_from_uv(uv: Vec2) -> Vec3 {
        direction_from_uv(uv)
    }

    /// Luminance from a direction.
    #[inline]
    pub(crate) fn at(&self, direction: Vec3) -> f32 {
        self.at_uv(uv_from_direction(direction))
    }

    /// The largest luminance from any direction.
    pub(crate) fn largest(&self) -> f32 {
        self.0.largest()
    }

    /// Luminance from the direction of a position in the unit square.
    #[inline(always)]
    pub(crate) fn at_uv(&self, uv: Vec2) -> f32 {
        self.0.number_at(uv)
    }
}
