//! Boxes of blocks of triangles at every measured time. They bound how far triangles reach in a direction, so that few are looked at, and few times posed.

use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::{TriangleFlags, is_traced};
use crate::geometry::{Aabb, Triangle};

/// Fewest triangles of a block.
const FEWEST_TRIANGLES: usize = 64;
/// Most boxes of all times, about: 24 MB.
const MOST_BOXES: usize = 1_000_000;
/// Blocks of one parallel task.
const BLOCKS_PER_TASK: usize = 64;

/// The boxes of neighbouring triangles at every measured time, in their order.
#[derive(Debug)]
pub(super) struct Blocks {
    /// Triangles of each block but the last.
    size: usize,
    /// By time, then by block; empty boxes where nothing is traced.
    boxes: Vec<Vec<Aabb>>,
}

impl Blocks {
    /// Those of so many triangles at no time yet, which will be measured at about so many.
    pub(super) fn new(triangles: usize, times: usize) -> Self {
        Self { size: block_size(triangles, times), boxes: Vec::new() }
    }

    /// Triangles of each block but the last.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// The boxes of triangles that are posed like this.
    pub(super) fn boxes(&self, triangles: &[Triangle], flags: &[TriangleFlags]) -> Vec<Aabb> {
        let blocks = triangles.par_chunks(self.size).zip(flags.par_chunks(self.size));
        let boxes = blocks.with_min_len(BLOCKS_PER_TASK).map(|(triangles, flags)| {
            let traced = triangles.iter().zip(flags).filter(|(triangle, flags)| is_traced(triangle, **flags));
            traced.fold(Aabb::EMPTY, |bounds, (triangle, _)| bounds.union(triangle.bounds()))
        });
        boxes.collect()
    }

    /// Adds the boxes of the next time.
    pub(super) fn add(&mut self, boxes: Vec<Aabb>) {
        self.boxes.push(boxes);
    }

    /// The boxes at a measured time.
    pub(super) fn at(&self, time: usize) -> &[Aabb] {
        &self.boxes[time]
    }

    /// What no triangle of the blocks for which `is_framed` holds exceeds at a measured time, for each direction.
    pub(super) fn reaches(&self, time: usize, is_framed: &[bool], directions: &[Vec3]) -> Vec<f32> {
        let framed = || self.at(time).iter().zip(is_framed).filter(|(_, is_framed)| **is_framed);
        let farthest = |direction: &Vec3| {
            let reaches = framed().map(|(bounds, _)| reach(bounds, *direction));
            reaches.fold(f32::NEG_INFINITY, f32::max)
        };
        directions.iter().map(farthest).collect()
    }
}

/// What the product of no point of a box with `direction` exceeds, as [`Vec3::dot`] rounds it: infinity where products overflow, negative infinity for an empty box.
pub(super) fn reach(bounds: &Aabb, direction: Vec3) -> f32 {
    if bounds.is_empty() {
        return f32::NEG_INFINITY;
    }
    let larger = (bounds.min * direction).max(bounds.max * direction);
    let reach = (larger.x + larger.y) + larger.z;
    if reach.is_nan() { f32::INFINITY } else { reach }
}

fn block_size(triangles: usize, times: usize) -> usize {
    triangles.saturating_mul(times).div_ceil(MOST_BOXES).max(FEWEST_TRIANGLES)
}

/// Bytes of the boxes of so many triangles at so many times, and at others that are added.
pub(super) fn block_bytes(triangles: usize, times: usize, added: usize) -> usize {
    let blocks = triangles.div_ceil(block_size(triangles, times));
    blocks.saturating_mul((times + added) * size_of::<Aabb>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_corner_reaches_beyond_its_box() {
        let value = |seed: u32| (seed.wrapping_mul(2_654_435_761) >> 8) as f32 / 8_388_608.0 - 1.0;
        let point = |seed: u32| Vec3::new(value(seed), value(seed + 1), value(seed + 2)) * value(seed + 3);
        for seed in (0..40_000).step_by(20) {
            let points = [0, 4, 8].map(|offset| point(seed + offset));
            let bounds = Aabb::from_points(&points);
            let direction = point(seed + 12);
            let reach = reach(&bounds, direction);
            assert!(points.iter().all(|point| point.dot(direction) <= reach), "{bounds:?} {direction}");
            // An edge of the box is as far as its bound says.
            assert!(reach <= bounds.center().dot(direction) + bounds.extent().length() * direction.length());
        }
        assert_eq!(reach(&Aabb::EMPTY, Vec3::X), f32::NEG_INFINITY);
        let far = Vec3::new(f32::MAX, -f32::MAX, 0.0);
        assert_eq!(reach(&Aabb { min: far, max: far }, Vec3::MAX), f32::INFINITY);
    }

    #[test]
    fn there_are_no_more_boxes_than_memory_for_them() {
        for triangles in [0, 1, 64, 65, 10_000, 3_000_000] {
            for times in [1, 65, 510] {
                let bytes = block_bytes(triangles, times, 0);
                assert!(bytes <= (MOST_BOXES + times) * size_of::<Aabb>(), "{triangles} {times}: {bytes}");
                let blocks = Blocks::new(triangles, times);
                let triangles = triangles.min(10_000);
                let triangle = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
                let flags = vec![TriangleFlags::default(); triangles];
                let boxes = blocks.boxes(&vec![triangle; triangles], &flags);
                assert_eq!(boxes.len(), triangles.div_ceil(blocks.size()));
                assert!(boxes.iter().all(|bounds| *bounds == triangle.bounds()));
            }
        }
    }
}
