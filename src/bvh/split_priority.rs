//! Splitting the triangles whose boxes waste most.
//!
//! Source: Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", HPG 2013, section
//! 4: a triangle's priority is the cube root of how much its box area exceeds what many parts would have, times 2⁻ⁱ for a
//! box that the Morton grid first divides at level i, and `⌊D p⌋` splits go to priority p, D being chosen so that
//! their sum is what is wanted. Parts share a triangle's splits by their longest extents.
//!
//! Departures. D comes from a histogram of log p, not from a search over all triangles. A box is cut along its longest axis
//! alone, at the most important plane of the grid within its middle 80 %, or in the middle if there is none there:
//! planes of other axes, or near its ends, leave slivers.

use rayon::prelude::*;

use super::morton::Grid;
use super::references::{CHUNK, Input, Measures, Reference, padding};
use crate::cancel::Cancelled;
use crate::geometry::{Aabb, Triangle, rounded_down, rounded_up};

/// The part of a box's extent at either end where it is not cut.
const MARGIN: f32 = 0.1;
/// Bins of priorities, as a power of two, to an octave.
const BINS_AN_OCTAVE_LOG2: u32 = 6;
/// Bins, 16 octaves below one. What is lower than all of them is not split.
const BINS: usize = 16 << BINS_AN_OCTAVE_LOG2;
/// Steps of the search for D.
const SEARCH_STEPS: u32 = 40;
/// More splits than this of one triangle are not wanted.
const MOST_SPLITS: f32 = 4096.0;

/// Memory kept between builds.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    priorities: Vec<f32>,
    parts: Vec<Reference>,
}

/// Where a box is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    plane: f32,
    /// Levels of the grid above that of the plane.
    level: u32,
}

/// Splits `references`, the boxes of whole triangles, into at most `aim`.
pub(super) fn split(
    input: Input,
    whole: &Measures,
    aim: usize,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<(), Cancelled> {
    let grid = Grid::around(&whole.bounds);
    let Scratch { priorities, parts } = scratch;
    let histogram = prioritise(input, whole, &grid, references, priorities)?;
    let factor = splits_for_one(&histogram, aim.saturating_sub(references.len()) as u64);
    let splits = |priority: &f32| (factor * *priority).min(MOST_SPLITS) as u32;

    // Room for the parts of each chunk.
    let rooms: Vec<usize> = priorities
        .par_chunks(CHUNK)
        .map(|chunk| chunk.iter().map(|priority| 1 + splits(priority) as usize).sum())
        .collect();
    parts.resize(rooms.iter().sum(), Reference::NONE);
    let mut outputs = Vec::with_capacity(rooms.len());
    let mut rest = parts.as_mut_slice();
    for &room in &rooms {
        let (output, after) = rest.split_at_mut(room);
        outputs.push(output);
        rest = after;
    }

    // The parts.
    let made: Vec<usize> = outputs
        .into_par_iter()
        .zip(references.par_chunks(CHUNK).zip(priorities.par_chunks(CHUNK)))
        .map(|(output, (references, priorities))| {
            input.cancel.check()?;
            let mut count = 0;
            let mut todo = Vec::new();
            for (reference, priority) in references.iter().zip(priorities) {
                let triangle = &input.triangles[reference.primitive as usize];
                count += split_one(
                    triangle,
                    reference,
                    splits(priority),
                    (&grid, &mut todo),
                    &mut output[count..],
                );
            }
            Ok(count)
        })
        .collect::<Result<_, _>>()?;

    // Close the gaps that cuts left out leave.
    let (mut from, mut to) = (0, 0);
    for (&room, &count) in rooms.iter().zip(&made) {
        if from != to {
            parts.copy_within(from..from + count, to);
        }
        (from, to) = (from + room, to + count);
    }
    parts.truncate(to);
    std::mem::swap(parts, references);
    Ok(())
}

/// Computes all priorities; gives how many there are by bin.
fn prioritise(
    input: Input,
    whole: &Measures,
    grid: &Grid,
    references: &[Reference],
    priorities: &mut Vec<f32>,
) -> Result<Vec<u64>, Cancelled> {
    let scale = whole.scale();
    priorities.resize(references.len(), 0.0);
    priorities
        .par_chunks_mut(CHUNK)
        .zip(references.par_chunks(CHUNK))
        .map(|(priorities, references)| {
            input.cancel.check()?;
            let mut bins = vec![0_u64; BINS];
            for (priority, reference) in priorities.iter_mut().zip(references) {
                let triangle = &input.triangles[reference.primitive as usize];
                *priority = priority_of(triangle, reference, grid, scale);
                if let Some(bin) = bins.get_mut(bin_of(*priority)) {
                    *bin += 1;
                }
            }
            Ok(bins)
        })
        .try_reduce(
            || vec![0; BINS],
            |mut a, b| {
                a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
                Ok(a)
            },
        )
}

/// The priority of a triangle, from 0 to 1; `scale` makes the scene one long.
fn priority_of(triangle: &Triangle, reference: &Reference, grid: &Grid, scale: f32) -> f32 {
    let e = reference.bounds.extent() * scale;
    let area = e.x * e.y + e.y * e.z + e.z * e.x;
    // The areas of the triangle's shadows along the axes: what tiny boxes around it come to.
    let [a, b, c] = triangle.vertices.map(|vertex| vertex * scale);
    let ideal = 0.5 * (b - a).cross(c - a).abs().element_sum();
    let waste = area - ideal;
    if waste > 0.0 && waste < f32::INFINITY {
        // A third of the areas of a cube as long as the scene.
        let level = cut_of(&reference.bounds, grid).map_or(0, |cut| cut.level.min(21));
        let importance = f32::from_bits((127 - level) << 23);
        rough_cube_root(waste * (1.0 / 3.0) * importance).min(1.0)
    } else {
        0.0
    }
}

/// Within a thousandth of the cube root; the same on every machine.
fn rough_cube_root(x: f32) -> f32 {
    // A third of the exponent, and one step of Newton's.
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    guess - (guess - x / (guess * guess)) * (1.0 / 3.0)
}

/// The bin of a priority; beyond all bins for those too low.
fn bin_of(priority: f32) -> usize {
    let shift = f32::MANTISSA_DIGITS - 1 - BINS_AN_OCTAVE_LOG2;
    ((1.0_f32.to_bits() >> shift) - (priority.to_bits() >> shift)) as usize
}

/// The highest priority of a bin.
fn top_of(bin: usize) -> f32 {
    let shift = f32::MANTISSA_DIGITS - 1 - BINS_AN_OCTAVE_LOG2;
    f32::from_bits((((1.0_f32.to_bits() >> shift) - bin as u32 + 1) << shift) - 1)
}

/// The largest D that makes at most `wanted` splits: how many a triangle of priority 1 gets.
fn splits_for_one(histogram: &[u64], wanted: u64) -> f32 {
    let total = |factor: f32| -> u64 {
        let splits = |bin| (factor * top_of(bin)).min(MOST_SPLITS) as u64;
        histogram.iter().enumerate().map(|(bin, &count)| count * splits(bin)).sum()
    };
    // What is beyond the last bin must get none.
    let (mut low, mut high) = (0.0, top_of(BINS - 1).recip());
    for _ in 0..SEARCH_STEPS {
        let middle = 0.5 * (low + high);
        *(if total(middle) <= wanted { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The most important plane along the longest axis of a box, unless the box is as thin as a number.
fn cut_of(bounds: &Aabb, grid: &Grid) -> Option<Cut> {
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

/// Splits one triangle; gives the number of parts, at most one more than `splits`.
fn split_one(
    triangle: &Triangle,
    whole: &Reference,
    splits: u32,
    (grid, todo): (&Grid, &mut Vec<(Aabb, u32)>),
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
            (is_empty, _) => {
                if is_empty {
                    0
                } else {
                    splits - 1
                }
            }
        };
        for (half, splits) in [(high, splits - 1 - low_splits), (low, low_splits)] {
            if !half.is_empty() {
                todo.push((half, splits));
            }
        }
    }
    count
}

/// Boxes of the triangle's parts below and above a plane, within `bounds`; a box without any part of it may be empty.
///
/// The triangle is cut whole and its parts' boxes are clipped: Stich, Friedrich, Dietrich, "Spatial Splits in Bounding
/// Volume Hierarchies", HPG 2009. Crossings are computed in `f64` and rounded outward.
fn halves(triangle: &Triangle, bounds: &Aabb, axis: usize, plane: f32) -> [Aabb; 2] {
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
            let crossing = from + (to - from) * ((f64::from(plane) - from[axis]) / (to[axis] - from[axis]));
            let around = Aabb {
                min: crossing.to_array().map(rounded_down).into(),
                max: crossing.to_array().map(rounded_up).into(),
            };
            (low, high) = (low.union(around), high.union(around));
        }
    }
    low.max[axis] = plane;
    high.min[axis] = plane;
    [low, high].map(|half| Aabb { min: half.min.max(bounds.min), max: half.max.min(bounds.max) })
}

/// How many of `splits` the first of two boxes gets.
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
    use crate::bvh::PrimitiveFlags;
    use crate::bvh::references::gather_whole;
    use crate::cancel::CancelFlag;
    use crate::geometry::TrianglePart;
    use glam::Vec3;

    /// Long thin diagonal triangles through a unit cube, among small ones.
    fn bars(n: usize) -> Vec<Triangle> {
        let mut state = 3_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|i| {
                let [a, b] = [0; 2].map(|_| Vec3::new(random(), random(), random()));
                let b = if i % 2 == 0 { b } else { a + Vec3::splat(0.01) };
                Triangle { vertices: [a, b, b + Vec3::new(0.001, 0.002, 0.0)] }
            })
            .collect()
    }

    fn parts_of(triangles: &[Triangle], aim: usize) -> Vec<Reference> {
        let flags = vec![PrimitiveFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let mut references = Vec::new();
        let whole = gather_whole(input, &mut references).unwrap();
        split(input, &whole, aim, &mut Scratch::default(), &mut references).unwrap();
        references
    }

    #[test]
    fn comes_near_the_aim_and_covers_every_triangle() {
        let triangles = bars(20_000);
        for aim in [20_000, 21_000, 40_000, 80_000] {
            let references = parts_of(&triangles, aim);
            assert!(references.len() <= aim && references.len() * 100 > aim * 94, "{}", references.len());
            assert!(references.is_sorted_by_key(|reference| reference.primitive));
            for parts in references.chunk_by(|a, b| a.primitive == b.primitive) {
                let covered = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(part.bounds));
                assert!(covered.contains(&triangles[parts[0].primitive as usize].bounds()));
            }
            let areas: f64 = references.iter().map(|reference| reference.bounds.area()).sum();
            let whole: f64 = triangles.iter().map(|triangle| triangle.bounds().area()).sum();
            assert!(aim == 20_000 || areas < 0.95 * whole);
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let triangles = bars(10_000);
        let results = [1, 2, 3, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| parts_of(&triangles, 25_000))
        });
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn cuts_are_at_important_planes() {
        let grid = Grid::around(&Aabb { min: Vec3::ZERO, max: Vec3::splat(1.0) });
        let box_of = |min: f32, max: f32| Aabb { min: Vec3::ZERO.with_y(min), max: Vec3::ZERO.with_y(max) };
        // The middle of the grid, though not of the box.
        assert_eq!(cut_of(&box_of(0.4, 0.9), &grid), Some(Cut { axis: 1, plane: 0.5, level: 0 }));
        // It is too near the end of this one, whose next best plane is at three quarters.
        assert_eq!(cut_of(&box_of(0.49, 0.9), &grid), Some(Cut { axis: 1, plane: 0.75, level: 1 }));
        assert_eq!(cut_of(&box_of(0.3, 0.3), &grid), None);
    }

    #[test]
    fn halves_contain_the_exact_parts() {
        for triangle in bars(500) {
            let mut part = TrianglePart::whole(&triangle);
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

    #[test]
    fn the_cube_root_is_near() {
        for x in [1.0e-12_f32, 1.0e-3, 0.3, 1.0] {
            let error = rough_cube_root(x) / libm::cbrtf(x) - 1.0;
            assert!(error.abs() < 2.0e-3, "{x} {error}");
        }
    }

    #[test]
    fn a_bin_holds_what_lies_below_its_top() {
        for bin in [0, 1, 100, BINS - 1] {
            assert_eq!(bin_of(top_of(bin).min(1.0)), bin);
            assert_eq!(bin_of(top_of(bin).next_up().min(1.0)), bin.saturating_sub(1));
        }
        assert!(bin_of(0.0) >= BINS);
    }
}
