//! Early split clipping by area.
//!
//! Source: Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies", RT 2007, Algorithm 4. While the surface
//! area of a box exceeds SA_max, the box is cut in the middle of its longest axis, and the triangle's part in each half gets
//! its own box. Departures:
//!
//! * The recursion is an explicit stack.
//! * The box of each half is found by clipping the part of the triangle in the parent's box.
//! * A box is not cut where the plane is not strictly inside it.
//!
//! [`super::threshold`] chooses SA_max.

use rayon::prelude::*;

use super::budget::Budget;
use crate::bvh::references::{Input, Reference, padding};
use crate::cancel::Cancelled;
use crate::geometry::{Aabb, Triangle, TrianglePart};

/// Scratch memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    chunks: Vec<Vec<Reference>>,
}

/// Fills `references` with the boxes of all traced triangles, in the triangles' order for any number of threads.
/// Returns false, with unspecified contents, if there are more than `limit`; memory stays within that limit.
pub(crate) fn gather(
    input: Input,
    sa_max: f64,
    limit: u64,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<bool, Cancelled> {
    let chunks = input.chunks();
    if scratch.chunks.len() < chunks {
        scratch.chunks.resize_with(chunks, Vec::new);
    }
    let budget = Budget::new(limit, input.cancel);
    let parts = &mut scratch.chunks[..chunks];
    parts.par_iter_mut().enumerate().for_each(|(chunk, part)| {
        part.clear();
        let mut share = budget.share();
        if share.is_exhausted() {
            return;
        }
        for (triangle_id, triangle) in input.chunk(chunk) {
            let padding = padding(triangle);
            split(triangle, sa_max, |bounds| {
                part.push(Reference { bounds: bounds.grown(padding), triangle_id });
                share.spend()
            });
        }
    });
    input.cancel.check()?;
    if budget.is_exceeded() {
        return Ok(false);
    }

    // Concatenate.
    references.clear();
    references.reserve(parts.iter().map(Vec::len).sum());
    for part in parts {
        references.extend_from_slice(part);
    }
    Ok(true)
}

/// Algorithm 4: passes the box of every part to `emit`, until it returns false.
pub(crate) fn split(triangle: &Triangle, sa_max: f64, mut emit: impl FnMut(&Aabb) -> bool) {
    let whole = triangle.bounds();
    let is_large = |bounds: &Aabb| bounds.area() > sa_max;
    if !is_large(&whole) {
        emit(&whole);
        return;
    }
    let mut todo = vec![TrianglePart::whole(triangle)];
    while let Some(part) = todo.pop() {
        let halves = is_large(part.bounds()).then(|| halves(&part)).flatten();
        match halves {
            Some([low, high]) => {
                todo.extend(high);
                todo.extend(low);
            }
            None => {
                if !emit(part.bounds()) {
                    return;
                }
            }
        }
    }
}

/// Both halves of a part, cut in the middle of its longest axis, unless the middle is not strictly inside its box.
fn halves(part: &TrianglePart) -> Option<[Option<TrianglePart>; 2]> {
    let bounds = part.bounds();
    let axis = (bounds.max * 0.5 - bounds.min * 0.5).max_position();
    let plane = bounds.center()[axis];
    (bounds.min[axis] < plane && plane < bounds.max[axis]).then(|| part.cut(axis, plane))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::TriangleFlags;
    use crate::cancel::CancelFlag;
    use glam::Vec3;

    /// Reference implementation: the recursion of the paper.
    fn recursive(part: &TrianglePart, sa_max: f64, out: &mut Vec<Aabb>) {
        if part.bounds().area() <= sa_max {
            out.push(*part.bounds());
            return;
        }
        for half in halves(part).unwrap().iter().flatten() {
            recursive(half, sa_max, out);
        }
    }

    fn diagonal() -> Triangle {
        Triangle { vertices: [Vec3::ZERO, Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 0.9, 1.0)] }
    }

    #[test]
    fn equals_the_recursion_and_respects_the_threshold() {
        let triangle = diagonal();
        let sa_max = 0.01;
        let mut boxes = Vec::new();
        split(&triangle, sa_max, |bounds| {
            boxes.push(*bounds);
            true
        });
        let mut expected = Vec::new();
        recursive(&TrianglePart::whole(&triangle), sa_max, &mut expected);
        assert_eq!(boxes, expected);
        assert!(boxes.len() > 20);
        assert!(boxes.iter().all(|bounds| bounds.area() <= sa_max));
        let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
        assert_eq!(all, triangle.bounds());
    }

    #[test]
    fn a_box_between_adjacent_floats_is_not_cut() {
        let a = Vec3::ONE;
        let b = Vec3::splat(1.0_f32.next_up());
        // Splitting ends even with a threshold of zero.
        let triangle = Triangle { vertices: [a, Vec3::new(b.x, a.y, a.z), Vec3::new(a.x, b.y, a.z)] };
        let mut count = 0;
        split(&triangle, 0.0, |_| {
            count += 1;
            true
        });
        assert_eq!(count, 1);
    }

    #[test]
    fn parts_keep_the_order_of_triangles_for_any_number_of_threads() {
        let triangles: Vec<Triangle> = (0..10_000)
            .map(|i| Triangle {
                vertices: diagonal().vertices.map(|p| p * (1.0 + (i % 7) as f32) + Vec3::X * i as f32),
            })
            .collect();
        let flags: Vec<TriangleFlags> = (0..triangles.len())
            .map(|i| if i % 3 == 0 { TriangleFlags::HIDDEN } else { TriangleFlags::default() })
            .collect();
        let cancel = CancelFlag::new();
        let input = Input { triangles: &triangles, flags: &flags, cancel: &cancel };
        let mut results = Vec::new();
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut references = Vec::new();
            pool.install(|| gather(input, 30.0, u64::MAX, &mut Scratch::default(), &mut references)).unwrap();
            results.push(references);
        }
        assert!(results.iter().all(|references| *references == results[0]));
        assert!(results[0].is_sorted_by_key(|reference| reference.triangle_id));
        assert!(results[0].iter().all(|reference| reference.triangle_id % 3 != 0));
        assert!(results[0].len() > 10_000);
    }
}
