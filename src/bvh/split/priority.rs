//! Early split clipping by priority: the triangles whose boxes waste most area get most splits.
//!
//! Source: Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", HPG 2013, section 4. A
//! triangle's priority is the cube root of its wasted area times 2⁻ⁱ. The wasted area is that of its box less that of many tiny
//! boxes; i is the level of the Morton grid that divides the box first. A triangle of priority p gets `⌊D p⌋` splits, with D
//! such that their sum is the number wanted.
//!
//! Departures: D comes from a histogram of log p rather than from a search over all triangles. The grid is a cube around the
//! boxes; that of the Morton codes is one around their centres, which are known only after splitting. [`super::cut`] chooses the
//! planes.

use rayon::prelude::*;

use super::cut::{cut_of, split_one};
use crate::bvh::build::morton::Grid;
use crate::bvh::references::{CHUNK, Input, Measures, Reference};
use crate::cancel::Cancelled;
use crate::geometry::Triangle;
use crate::parallel_resize::resize_with;

/// Binary logarithm of the bins per octave of priority.
const LOG2_BINS_PER_OCTAVE: u32 = 6;
/// Number of bins, 16 octaves below one. Triangles of lower priority are not split.
const BINS: usize = 16 << LOG2_BINS_PER_OCTAVE;
/// Steps of the search for D.
const SEARCH_STEPS: u32 = 40;
/// Area of a sparse box over that of many tiny boxes around its triangle.
const SPARSE: f32 = 4.0;
/// Maximum of splits of one triangle.
const MAX_SPLITS: f32 = 4096.0;

/// Scratch memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    priorities: Vec<f32>,
    parts: Vec<Reference>,
}

/// Splits `references`, the boxes of whole triangles, into at most `aim` references.
pub(crate) fn split(
    input: Input,
    whole: &Measures,
    aim: usize,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<(), Cancelled> {
    let grid = Grid::around(&whole.bounds);
    let Scratch { priorities, parts } = scratch;
    let histogram = compute_priorities(input, whole, &grid, references, priorities)?;
    let factor = splits_for_one(&histogram, aim.saturating_sub(references.len()) as u64);
    let splits = |priority: &f32| (factor * *priority).min(MAX_SPLITS) as u32;

    // Allocate the parts of each chunk.
    let capacities: Vec<usize> = priorities
        .par_chunks(CHUNK)
        .map(|chunk| chunk.iter().map(|priority| 1 + splits(priority) as usize).sum())
        .collect();
    resize_with(parts, capacities.iter().sum(), || Reference::NONE);
    let mut outputs = Vec::with_capacity(capacities.len());
    let mut rest = parts.as_mut_slice();
    for &capacity in &capacities {
        let (output, after) = rest.split_at_mut(capacity);
        outputs.push(output);
        rest = after;
    }

    // Split.
    let made: Vec<usize> = outputs
        .into_par_iter()
        .zip(references.par_chunks(CHUNK).zip(priorities.par_chunks(CHUNK)))
        .map(|(output, (references, priorities))| {
            input.cancel.check()?;
            let mut count = 0;
            let mut todo = Vec::new();
            for (reference, priority) in references.iter().zip(priorities) {
                let triangle = &input.triangles[reference.triangle_id as usize];
                count +=
                    split_one(triangle, reference, splits(priority), &grid, &mut todo, &mut output[count..]);
            }
            Ok(count)
        })
        .collect::<Result<_, _>>()?;

    // Close the gaps of triangles with fewer parts than allocated.
    let (mut from, mut to) = (0, 0);
    for (&capacity, &count) in capacities.iter().zip(&made) {
        if from != to {
            parts.copy_within(from..from + count, to);
        }
        (from, to) = (from + capacity, to + count);
    }
    parts.truncate(to);
    std::mem::swap(parts, references);
    Ok(())
}

/// Computes all priorities and their histogram.
fn compute_priorities(
    input: Input,
    whole: &Measures,
    grid: &Grid,
    references: &[Reference],
    priorities: &mut Vec<f32>,
) -> Result<Vec<u64>, Cancelled> {
    let scale = whole.scale();
    resize_with(priorities, references.len(), || 0.0);
    priorities
        .par_chunks_mut(CHUNK)
        .zip(references.par_chunks(CHUNK))
        .map(|(priorities, references)| {
            input.cancel.check()?;
            let mut bins = vec![0_u64; BINS];
            for (priority, reference) in priorities.iter_mut().zip(references) {
                let triangle = &input.triangles[reference.triangle_id as usize];
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

/// Priority of a triangle, from 0 to 1; `scale` makes the longest edge of the scene one.
fn priority_of(triangle: &Triangle, reference: &Reference, grid: &Grid, scale: f32) -> f32 {
    let (area, ideal) = half_areas(triangle, reference, scale);
    let waste = area - ideal;
    if waste > 0.0 && waste < f32::INFINITY {
        // In units of the half area of the scene's cube, which is three.
        let level = cut_of(&reference.bounds, grid).map_or(0, |cut| cut.level.min(21));
        let importance = f32::from_bits((127 - level) << 23);
        approximate_cube_root(waste * (1.0 / 3.0) * importance).min(1.0)
    } else {
        0.0
    }
}

/// Half the area of a triangle's box, and that of many tiny boxes around the triangle: the least that splits can leave. The latter is
/// the sum of the triangle's projections along the axes.
fn half_areas(triangle: &Triangle, reference: &Reference, scale: f32) -> (f32, f32) {
    let e = reference.bounds.extent() * scale;
    let [a, b, c] = triangle.vertices.map(|vertex| vertex * scale);
    let ideal = 0.5 * (b - a).cross(c - a).abs().element_sum();
    (e.x * e.y + e.y * e.z + e.z * e.x, ideal)
}

/// Average number of sparse boxes that a line through the scene intersects: the sum of their areas over that of the scene's box. A box
/// is sparse if it is at least [`SPARSE`] times as large as many tiny boxes around its triangle; half of a wall's box is not.
pub(super) fn sparse_overlap(
    input: Input,
    whole: &Measures,
    references: &[Reference],
) -> Result<f64, Cancelled> {
    let scale = whole.scale();
    let sums: Vec<f64> = references
        .par_chunks(CHUNK)
        .map(|chunk| {
            input.cancel.check()?;
            let areas = chunk.iter().map(|reference| {
                let triangle = &input.triangles[reference.triangle_id as usize];
                let (area, ideal) = half_areas(triangle, reference, scale);
                if area >= SPARSE * ideal { f64::from(area) } else { 0.0 }
            });
            Ok(areas.sum())
        })
        .collect::<Result<_, _>>()?;
    let e = whole.bounds.extent().as_dvec3() * f64::from(scale);
    let scene = e.x * e.y + e.y * e.z + e.z * e.x;
    Ok(if scene > 0.0 { sums.iter().sum::<f64>() / scene } else { 0.0 })
}

/// Cube root within a relative error of 0.002, equal on every machine.
fn approximate_cube_root(x: f32) -> f32 {
    // A third of the exponent, and one Newton step.
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    guess - (guess - x / (guess * guess)) * (1.0 / 3.0)
}

/// Bin of a priority; at least [`BINS`] for priorities below all bins.
fn bin_of(priority: f32) -> usize {
    let shift = f32::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE;
    ((1.0_f32.to_bits() >> shift) - (priority.to_bits() >> shift)) as usize
}

/// Highest priority of a bin.
fn top_of(bin: usize) -> f32 {
    let shift = f32::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE;
    f32::from_bits((((1.0_f32.to_bits() >> shift) - bin as u32 + 1) << shift) - 1)
}

/// Largest D with at most `wanted` splits: the number of splits of a triangle of priority 1.
fn splits_for_one(histogram: &[u64], wanted: u64) -> f32 {
    let total = |factor: f32| -> u64 {
        let splits = |bin| (factor * top_of(bin)).min(MAX_SPLITS) as u64;
        histogram.iter().enumerate().map(|(bin, &count)| count * splits(bin)).sum()
    };
    // Priorities below the last bin must get no splits.
    let (mut low, mut high) = (0.0, top_of(BINS - 1).recip());
    for _ in 0..SEARCH_STEPS {
        let middle = 0.5 * (low + high);
        *(if total(middle) <= wanted { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::bvh::TriangleFlags;
    use crate::bvh::references::gather_whole;
    use crate::cancel::CancelFlag;
    use crate::geometry::Aabb;
    use glam::Vec3;

    /// Long thin diagonal triangles through a unit cube, among small ones.
    pub(crate) fn mixed_bars(n: usize) -> Vec<Triangle> {
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
        let flags = vec![TriangleFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let mut references = Vec::new();
        let whole = gather_whole(input, &mut references).unwrap();
        split(input, &whole, aim, &mut Scratch::default(), &mut references).unwrap();
        references
    }

    #[test]
    fn parts_approach_the_aim_and_cover_every_triangle() {
        let triangles = mixed_bars(20_000);
        for aim in [20_000, 21_000, 40_000, 80_000] {
            let references = parts_of(&triangles, aim);
            assert!(references.len() <= aim && references.len() * 100 > aim * 94, "{}", references.len());
            assert!(references.is_sorted_by_key(|reference| reference.triangle_id));
            for parts in references.chunk_by(|a, b| a.triangle_id == b.triangle_id) {
                let covered = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(part.bounds));
                assert!(covered.contains(&triangles[parts[0].triangle_id as usize].bounds()));
            }
            let areas: f64 = references.iter().map(|reference| reference.bounds.area()).sum();
            let whole: f64 = triangles.iter().map(|triangle| triangle.bounds().area()).sum();
            assert!(aim == 20_000 || areas < 0.95 * whole);
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let triangles = mixed_bars(10_000);
        let results = [1, 2, 3, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| parts_of(&triangles, 25_000))
        });
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn cube_root_is_accurate() {
        for x in [1.0e-12_f32, 1.0e-3, 0.3, 1.0] {
            let error = approximate_cube_root(x) / libm::cbrtf(x) - 1.0;
            assert!(error.abs() < 2.0e-3, "{x} {error}");
        }
    }

    #[test]
    fn bins_contain_priorities_up_to_their_top() {
        for bin in [0, 1, 100, BINS - 1] {
            assert_eq!(bin_of(top_of(bin).min(1.0)), bin);
            assert_eq!(bin_of(top_of(bin).next_up().min(1.0)), bin.saturating_sub(1));
        }
        assert!(bin_of(0.0) >= BINS);
    }
}
