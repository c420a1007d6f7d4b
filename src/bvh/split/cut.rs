//! Cuts of one triangle's box into parts.
//!
//! Source: Karras and Aila, HPG 2013, section 4 (see [`super::priority`]). Parts share a triangle's splits in proportion to their
//! longest extents, and are cut at planes of the grid over the scene's box. The radix tree splits half a cell below those of a
//! grid of the same kind over the boxes' centres, which is slightly smaller.
//!
//! Departure: a box is cut only along its longest axis, at the coarsest plane of the grid within its middle 80 %, or in the
//! middle if there is none. Planes of other axes, or near its ends, leave slivers.

use crate::bvh::build::morton::Grid;
use crate::bvh::references::{Reference, padding};
use crate::geometry::{Aabb, Triangle, rounded_down, rounded_up};

/// Part of a box's extent at either end where it is not cut.
const MARGIN: f32 = 0.1;

/// Plane at which a box is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// Axis that the plane is perpendicular to.
    pub(crate) axis: usize,
    /// Coordinate on the axis.
    pub(crate) plane: f32,
    /// Level of the plane in the grid; zero is the coarsest.
    pub(crate) level: u32,
}

/// Cut of a box along its longest axis; `None` if no float lies between its ends.
pub(crate) fn cut_of(bounds: &Aabb, grid: &Grid) -> Option<Cut> {
    let extent = bounds.max * 0.5 - bounds.min * 0.5;
    let axis = extent.max_position();
    let margin = 2.0 * MARGIN * extent[axis];
    let (low, high) = (bounds.min[axis] + margin, bounds.max[axis] - margin);
    let is_inside = |plane: f32| bounds.min[axis] < plane && plane < bounds.max[axis];
    let center = Cut { axis, plane: bounds.center()[axis], level: u32::MAX };
    let cut = grid
        .first_plane(axis, low, high)
        .map(|(plane, level)| Cut { plane, level, ..center })
        .filter(|cut| is_inside(cut.plane))
        .unwrap_or(center);
    is_inside(cut.plane).then_some(cut)
}

/// Splits one triangle into `output`; returns the number of parts, at most `splits + 1`. `todo` is scratch memory.
pub(crate) fn split_one(
    triangle: &Triangle,
    whole: &Reference,
    splits: u32,
    grid: &Grid,
    todo: &mut Vec<(Aabb, u32)>,
    output: &mut [Reference],
) -> usize {
    if splits == 0 {
        output[0] = *whole;
        return 1;
    }
    let padding = padding(triangle);
    let mut count = 0;
    todo.push((triangle.bounds(), splits));
    while let Some((bounds, splits)) = todo.pop() {
        let Some(cut) = cut_of(&bounds, grid).filter(|_| splits > 0) else {
            output[count] = Reference { bounds: bounds.grown(padding), ..*whole };
            count += 1;
            continue;
        };
        let [low, high] = halves(triangle, &bounds, cut.axis, cut.plane);
        let low_splits = match (low.is_empty(), high.is_empty()) {
            (false, false) => share(splits - 1, &low, &high),
            (true, _) => 0,
            (false, true) => splits - 1,
        };
        for (half, splits) in [(high, splits - 1 - low_splits), (low, low_splits)] {
            if !half.is_empty() {
                todo.push((half, splits));
            }
        }
    }
    count
}

/// Boxes of the triangle's parts below and above a plane, within `bounds`. The box of a side without any part may be empty.
///
/// The whole triangle is cut, and the boxes of its parts are clipped to `bounds`: Stich, Friedrich, Dietrich, "Spatial Splits in
/// Bounding Volume Hierarchies", HPG 2009. Intersections are computed in `f64` and rounded outward.
pub(crate) fn halves(triangle: &Triangle, bounds: &Aabb, axis: usize, plane: f32) -> [Aabb; 2] {
    let (mut low, mut high) = (Aabb::EMPTY, Aabb::EMPTY);
    let [a, b, c] = triangle.vertices;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let (from_height, to_height) = (from[axis], to[axis]);
        if from_height <= plane {
            low = low.union_point(from);
        }
        if from_height >= plane {
            high = high.union_point(from);
        }
        if (from_height < plane && plane < to_height) || (to_height < plane && plane < from_height) {
            let (from, to) = (from.as_dvec3(), to.as_dvec3());
            let point = from + (to - from) * ((f64::from(plane) - from[axis]) / (to[axis] - from[axis]));
            let around = Aabb {
                min: point.to_array().map(rounded_down).into(),
                max: point.to_array().map(rounded_up).into(),
            };
            (low, high) = (low.union(around), high.union(around));
        }
    }
    low.max[axis] = plane;
    high.min[axis] = plane;
    [low, high].map(|half| Aabb { min: half.min.max(bounds.min), max: half.max.min(bounds.max) })
}

/// Share of `splits` of the first of two boxes.
fn share(splits: u32, low: &Aabb, high: &Aabb) -> u32 {
    let (low, high) = (low.extent().max_element(), high.extent().max_element());
    if low + high > 0.0 && low + high < f32::INFINITY {
        ((splits as f32 * (low / (low + high)) + 0.5) as u32).min(splits)
    } else {
        splits / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::split::priority::tests::mixed_bars;
    use crate::geometry::ClippedTriangle;
    use glam::Vec3;

    #[test]
    fn cuts_are_at_coarse_planes() {
        let grid = Grid::around(&Aabb { min: Vec3::ZERO, max: Vec3::splat(1.0) });
        let box_of = |min: f32, max: f32| Aabb { min: Vec3::ZERO.with_y(min), max: Vec3::ZERO.with_y(max) };
        // The middle of the grid, though not of the box.
        assert_eq!(cut_of(&box_of(0.4, 0.9), &grid), Some(Cut { axis: 1, plane: 0.5, level: 0 }));
        // That plane is too near the end of this box; the next coarsest is at three quarters.
        assert_eq!(cut_of(&box_of(0.49, 0.9), &grid), Some(Cut { axis: 1, plane: 0.75, level: 1 }));
        assert_eq!(cut_of(&box_of(0.3, 0.3), &grid), None);
    }

    #[test]
    fn halves_contain_the_exact_parts() {
        for triangle in mixed_bars(500) {
            let mut part = ClippedTriangle::whole(&triangle);
            let mut bounds = triangle.bounds();
            for step in 0..6 {
                let (axis, plane) = (step % 3, bounds.center()[step % 3]);
                let inside = part.bounds();
                if !(inside.min[axis] < plane && plane < inside.max[axis]) {
                    break;
                }
                let boxes = halves(&triangle, &bounds, axis, plane);
                let parts = part.cut(axis, plane);
                for (half, exact) in boxes.iter().zip(&parts) {
                    let padded = half.grown(padding(&triangle));
                    assert!(exact.as_ref().is_none_or(|exact| padded.contains(exact.bounds())));
                    assert!(bounds.contains(half));
                }
                let Some(next) = parts[step / 2 % 2] else { break };
                (part, bounds) = (next, boxes[step / 2 % 2]);
            }
        }
    }
}
