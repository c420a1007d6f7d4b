//! Luminance of an environment on a coarse grid of directions, to choose directions by.

use glam::{Vec2, Vec3};

use super::Environment;
use super::octahedral::{OctahedralImage, direction_from_uv, uv_from_direction};
use crate::color::luminance;

/// Cells along an edge of the grid: 6° to 9° each.
const CELLS: usize = 32;

/// Roughness of the lobe that the radiance is averaged over. Its width is about that of a cell, so that no lamp falls between.
const ROUGHNESS: f32 = 0.3;

/// Luminance by direction.
#[derive(Debug)]
pub(crate) struct LuminanceImage(OctahedralImage<f32>);

impl LuminanceImage {
    /// The luminance of an environment.
    pub(crate) fn new(environment: &Environment) -> Self {
        Self(OctahedralImage::of_numbers(CELLS, |direction| {
            luminance(environment.prefiltered(direction, ROUGHNESS))
        }))
    }

    /// Position of a direction in the unit square; neighbours in the square are neighbours on the sphere.
    #[inline(always)]
    pub(crate) fn uv_from_direction(direction: Vec3) -> Vec2 {
        uv_from_direction(direction)
    }

    /// Unit vector of a position in the unit square.
    #[inline]
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
