//! Early split clipping by area.
//!
//! Source: Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies", RT 2007, Algorithm 4. While the surface
//! area of a box exceeds SA_max, the box is cut in the middle of its longest axis, and the triangle's part in each half gets
//! its own box. Cuts follow the boxes, not the Morton grid. Departures:
//!
//! * The recursion is an explicit stack.
//! * Boxes of halves are found as in [`super::cut`]: the whole triangle is cut, and the boxes of its parts are clipped.
//! * A box is not cut where the plane is not strictly inside it.
//!
//! # Budget
//!
//! A box lies inside those that it was cut from, so its area is at most theirs. A box is therefore cut exactly if its own area
//! exceeds SA_max, and each cut that leaves two parts makes one more reference. A histogram of the areas of such boxes gives the
//! number of references for every SA_max. The SA_max that is used is the larger of the one asked for and the lowest bin edge
//! within the budget. The latter depends on the triangles alone, so a smaller area never makes fewer references.
//!
//! The histogram is filled down to a threshold that is lowered by [`OCTAVES_PER_PASS`] until its cuts no longer fit: a pass costs a multiple of all
//! before it, and none cuts much more than the budget. Within a pass, boxes of areas that no longer fit are not cut. The bins above
//! are complete whatever the order, so the result does not depend on the number of threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::cut::halves;
use crate::bvh::references::{Input, Reference, padding};
use crate::cancel::Cancelled;
use crate::geometry::{Aabb, Triangle};
use crate::parallel_resize::resize_with;

/// Binary logarithm of the bins per octave of area.
const LOG2_BINS_PER_OCTAVE: u32 = 4;
/// Number of bins, 64 octaves below the largest area; the last one holds all smaller areas.
const BINS: usize = 64 << LOG2_BINS_PER_OCTAVE;
/// Octaves of area by which a pass goes further than the one before.
const OCTAVES_PER_PASS: u64 = 3;
/// Cuts that a task counts between updates of the shared histogram.
const FLUSH_EVERY: usize = 1 << 12;

/// Scratch memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    chunks: Vec<Vec<Reference>>,
}

/// SA_max that was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Threshold {
    /// Square metres.
    pub(crate) sa_max: f64,
    /// Whether it was raised to stay within the budget.
    pub(crate) budget_reached: bool,
}

/// Fills `references` with the boxes of all traced triangles for `sa_max`, or for the smallest threshold above it with at
/// most `limit` references. They are in the triangles' order.
pub(crate) fn gather(
    input: Input,
    sa_max: f64,
    limit: u64,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<Threshold, Cancelled> {
    let least = Histogram::fill(input, sa_max, limit, references.len())?.threshold();
    let threshold = Threshold { sa_max: sa_max.max(least), budget_reached: least > sa_max };
    emit_all(input, threshold.sa_max, scratch, references)?;
    Ok(threshold)
}

/// Areas of the boxes that are cut, shared by parallel tasks.
struct Histogram {
    /// Bits of the largest area.
    top: u64,
    /// Cuts that the budget allows.
    limit: u64,
    bins: Mutex<Vec<u64>>,
    /// Number of bins, from the largest areas on, whose cuts so far fit the budget.
    fitting: AtomicUsize,
}

impl Histogram {
    /// Counts the cuts of all boxes with areas above `sa_max`, or above a larger area where they exceed `limit` references.
    fn fill(input: Input, sa_max: f64, limit: u64, triangles: usize) -> Result<Self, Cancelled> {
        let area =
            |chunk| input.chunk(chunk).fold(0.0, |a: f64, (_, triangle)| a.max(triangle.bounds().area()));
        let largest = (0..input.chunks()).into_par_iter().map(area).reduce(|| 0.0, f64::max);
        let mut bins = 0;
        loop {
            bins += OCTAVES_PER_PASS << LOG2_BINS_PER_OCTAVE;
            let mut histogram = Self {
                top: largest.to_bits(),
                limit: limit.saturating_sub(triangles as u64),
                bins: Mutex::new(vec![0; BINS]),
                fitting: AtomicUsize::new(BINS),
            };
            let least = sa_max.max(histogram.edge(bins));
            histogram.count(input, least)?;
            if least <= sa_max || *histogram.fitting.get_mut() < BINS {
                return Ok(histogram);
            }
        }
    }

    /// Counts the cuts of all boxes with areas above `sa_max`.
    fn count(&self, input: Input, sa_max: f64) -> Result<(), Cancelled> {
        (0..input.chunks()).into_par_iter().try_for_each(|chunk| {
            let mut own = vec![0; BINS];
            let mut count = 0;
            let mut todo = Vec::new();
            for (_, triangle) in input.chunk(chunk) {
                todo.push(triangle.bounds());
                while let Some(bounds) = todo.pop() {
                    let area = bounds.area();
                    let bin = self.bin_of(area);
                    if area <= sa_max || bin >= self.fitting.load(Ordering::Relaxed) {
                        continue;
                    }
                    let parts = parts_of(triangle, &bounds);
                    own[bin] += u64::from(parts.is_some_and(|parts| parts.iter().flatten().count() == 2));
                    todo.extend(parts.into_iter().flatten().flatten());
                    count += 1;
                    if count % FLUSH_EVERY == 0 {
                        input.cancel.check()?;
                        self.add(&mut own);
                    }
                }
            }
            self.add(&mut own);
            Ok(())
        })
    }

    /// Adds the counts of a task, which become zero.
    fn add(&self, own: &mut [u64]) {
        let mut bins = self.bins.lock().unwrap_or_else(PoisonError::into_inner);
        let mut sum = 0;
        let mut fitting = 0;
        for (bin, own) in bins.iter_mut().zip(own) {
            *bin += std::mem::take(own);
            sum += *bin;
            fitting += usize::from(sum <= self.limit);
        }
        self.fitting.store(fitting, Ordering::Relaxed);
    }

    /// Bin of an area: parts of octaves below the largest, by its bits.
    fn bin_of(&self, area: f64) -> usize {
        let below =
            self.top.saturating_sub(area.to_bits()) >> (f64::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE);
        (below as usize).min(BINS - 1)
    }

    /// Smallest SA_max within the budget; zero if all areas are.
    fn threshold(&self) -> f64 {
        self.edge(self.fitting.load(Ordering::Relaxed) as u64)
    }

    /// The least area of the first `bins`; zero for all.
    fn edge(&self, bins: u64) -> f64 {
        if bins >= BINS as u64 {
            return 0.0;
        }
        f64::from_bits(self.top.saturating_sub(bins << (f64::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE)))
    }
}

/// Fills `references` with the boxes of all traced triangles.
fn emit_all(
    input: Input,
    sa_max: f64,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<(), Cancelled> {
    let chunks = input.chunks();
    scratch.chunks.resize_with(chunks.max(scratch.chunks.len()), Vec::new);
    let parts = &mut scratch.chunks[..chunks];
    parts.par_iter_mut().enumerate().try_for_each(|(chunk, part)| {
        input.cancel.check()?;
        part.clear();
        let mut todo = Vec::new();
        for (triangle_id, triangle) in input.chunk(chunk) {
            let padding = padding(triangle);
            split(triangle, sa_max, &mut todo, |bounds| {
                part.push(Reference { bounds: bounds.grown(padding), triangle_id });
            });
        }
        Ok(())
    })?;

    // Concatenate.
    resize_with(references, parts.iter().map(Vec::len).sum(), || Reference::NONE);
    let mut outputs = Vec::with_capacity(chunks);
    let mut rest = references.as_mut_slice();
    for part in &*parts {
        let (output, after) = rest.split_at_mut(part.len());
        outputs.push(output);
        rest = after;
    }
    outputs.into_par_iter().zip(parts).for_each(|(output, part)| output.copy_from_slice(part));
    Ok(())
}

/// Algorithm 4: passes the box of every part to `emit`. `todo` is scratch memory.
fn split(triangle: &Triangle, sa_max: f64, todo: &mut Vec<Aabb>, mut emit: impl FnMut(&Aabb)) {
    todo.push(triangle.bounds());
    while let Some(bounds) = todo.pop() {
        let parts = if bounds.area() > sa_max { parts_of(triangle, &bounds) } else { None };
        match parts {
            Some(parts) => todo.extend(parts.into_iter().rev().flatten()),
            None => emit(&bounds),
        }
    }
}

/// Boxes of both halves of a box, cut in the middle of its longest axis; `None` for an empty half. `None` in all if the middle is
/// not strictly inside the box, or if nothing of the triangle is.
fn parts_of(triangle: &Triangle, bounds: &Aabb) -> Option<[Option<Aabb>; 2]> {
    let axis = (bounds.max * 0.5 - bounds.min * 0.5).max_position();
    let plane = bounds.center()[axis];
    let is_inside = bounds.min[axis] < plane && plane < bounds.max[axis];
    let parts = is_inside.then(|| halves(triangle, bounds, axis, plane))?;
    let parts = parts.map(|part| (!part.is_empty()).then_some(part));
    (parts != [None, None]).then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::TriangleFlags;
    use crate::bvh::split::priority::tests::mixed_bars;
    use crate::cancel::CancelFlag;
    use glam::Vec3;

    /// Reference implementation: the recursion of the paper.
    fn recursive(triangle: &Triangle, bounds: &Aabb, sa_max: f64, out: &mut Vec<Aabb>) {
        match parts_of(triangle, bounds).filter(|_| bounds.area() > sa_max) {
            Some(parts) => parts.iter().flatten().for_each(|part| recursive(triangle, part, sa_max, out)),
            None => out.push(*bounds),
        }
    }

    fn gathered(triangles: &[Triangle], sa_max: f64, limit: u64) -> (Threshold, Vec<Reference>) {
        let hidden = |i| if i % 3 == 0 { TriangleFlags::HIDDEN } else { TriangleFlags::default() };
        let flags: Vec<TriangleFlags> = (0..triangles.len()).map(hidden).collect();
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let traced = (0..input.chunks()).map(|chunk| input.chunk(chunk).count()).sum();
        let mut references = vec![Reference::NONE; traced];
        let threshold = gather(input, sa_max, limit, &mut Scratch::default(), &mut references).unwrap();
        (threshold, references)
    }

    #[test]
    fn equals_the_recursion_and_respects_the_area() {
        let triangle =
            Triangle { vertices: [Vec3::ZERO, Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 0.9, 1.0)] };
        let (mut boxes, mut expected) = (Vec::new(), Vec::new());
        split(&triangle, 0.01, &mut Vec::new(), |bounds| boxes.push(*bounds));
        recursive(&triangle, &triangle.bounds(), 0.01, &mut expected);
        assert_eq!(boxes, expected);
        assert!(boxes.len() > 20);
        assert!(boxes.iter().all(|bounds| bounds.area() <= 0.01));
        let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
        assert_eq!(all, triangle.bounds());
    }

    #[test]
    fn boxes_of_a_triangle_are_disjoint_and_cover_it() {
        let corners = [Vec3::new(-1.3, 0.2, 0.7), Vec3::new(2.1, 1.9, -0.4), Vec3::new(0.3, -1.1, 1.6)];
        let mut boxes = Vec::new();
        split(&Triangle { vertices: corners }, 0.05, &mut Vec::new(), |bounds| boxes.push(*bounds));
        assert!(boxes.len() > 100, "{}", boxes.len());
        // Any two share a face at most.
        for (index, a) in boxes.iter().enumerate() {
            for b in &boxes[..index] {
                let (min, max) = (a.min.max(b.min), a.max.min(b.max));
                assert!((max - min).min_element() <= 0.0, "{a:?} {b:?}");
            }
        }
        // Each of a grid of points with 120 steps a side is in one, up to its own rounding.
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        for u in 0..=120 {
            for v in 0..=120 - u {
                let [u, v] = [u, v].map(|step| f64::from(step) / 120.0);
                let point = a * (1.0 - u - v) + b * u + c * v;
                let is_inside = |bounds: &Aabb| {
                    (point - bounds.min.as_dvec3()).min(bounds.max.as_dvec3() - point).min_element()
                        > -1.0e-12
                };
                assert!(boxes.iter().any(is_inside), "{point}");
            }
        }
    }

    #[test]
    fn a_box_between_adjacent_floats_is_not_cut() {
        let a = Vec3::ONE;
        let b = Vec3::splat(1.0_f32.next_up());
        // Splitting ends even with a threshold of zero.
        let triangle = Triangle { vertices: [a, Vec3::new(b.x, a.y, a.z), Vec3::new(a.x, b.y, a.z)] };
        let mut count = 0;
        split(&triangle, 0.0, &mut Vec::new(), |_| count += 1);
        assert_eq!(count, 1);
    }

    #[test]
    fn a_smaller_area_never_makes_fewer_references() {
        let triangles = mixed_bars(3000);
        let mut last = 0;
        for exponent in 0..60 {
            let sa_max = f64::from(libm::exp2f(4.0 - exponent as f32 * 0.5));
            let (threshold, references) = gathered(&triangles, sa_max, 8000);
            assert!(references.len() >= last && references.len() <= 8000);
            assert_eq!(threshold.budget_reached, threshold.sa_max > sa_max);
            last = references.len();
        }
        // The budget is used up to the width of a bin.
        assert!(last > 7500, "{last}");
        // A larger budget never makes fewer either.
        let counts = [2000, 3000, 5000, 9000, 20_000].map(|limit| gathered(&triangles, 0.0, limit).1.len());
        assert!(counts.is_sorted() && counts[0] == 2000, "{counts:?}");
    }

    #[test]
    fn references_keep_the_order_of_triangles_for_any_number_of_threads() {
        let triangles = mixed_bars(10_000);
        for (sa_max, limit) in [(0.05, u64::MAX), (1.0e-9, 20_000)] {
            let results = [1, 2, 3, 8].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| gathered(&triangles, sa_max, limit))
            });
            assert!(results.iter().all(|result| *result == results[0]));
            let references = &results[0].1;
            assert!(references.is_sorted_by_key(|reference| reference.triangle_id));
            assert!(references.iter().all(|reference| reference.triangle_id % 3 != 0));
            assert!(references.len() > 10_000);
        }
    }
}
